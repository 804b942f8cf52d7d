"""The two engines of a scene: the compiled step and the reference interpreter, set to one state and compared in everything."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import jax
import numpy as np

from sjdsl.compiler.identifiers import attribute_name, param_attribute
from sjdsl.interpreter import observe as interpreter_view
from sjdsl.interpreter.draws import Recorded, Threefry
from sjdsl.interpreter.planes import marking
from sjdsl.interpreter.state import Outcome, World
from sjdsl.interpreter.step import action_mask, step
from sjdsl.runtime.env import Environment
from sjdsl.testing.states import fields_of, stored_values
from sjdsl.testing.values import loaded

QUICK = {"xla_backend_optimization_level": 0, "xla_llvm_disable_expensive_passes": True}  # compiling costs more than a few steps
CLOSE = {"rtol": 1e-6, "atol": 1e-6}


@dataclass(frozen=True)
class Compiled:
    """A compiled game. look: state, params -> observation, allowed actions; step: as of the environment, and the allowed actions.

    blank: the state before the phase `start`, as NumPy arrays.
    """

    env: Environment
    blank: Any
    look: Callable[[Any, Any], Any]
    step: Callable[[Any, Any, Any, Any], Any]


@dataclass(frozen=True)
class Numbers:
    """Run-time numbers for the compiled game and, the same bit for bit, for the interpreter."""

    compiled: Any
    interpreted: dict[str, Any]


def compile_quickly(env: Environment) -> Compiled:
    """Returns the functions of an environment that a scene needs, compiled for few runs."""

    def look(state: Any, params: Any) -> Any:
        return env.observe(state, params), env.allowed_actions(state, params)

    def whole_step(key: Any, state: Any, actions: Any, params: Any) -> Any:
        _, state, reward, done, info = env.step_env(key, state, actions, params)
        return look(state, params), state, reward, done, info

    return Compiled(
        env, jax.device_get(env.module.initial_state()), jax.jit(look, compiler_options=QUICK), jax.jit(whole_step, compiler_options=QUICK)
    )


def key_words(seed: int) -> tuple[int, int]:
    """Returns the two words of `jax.random.key(seed)`."""
    words = np.asarray(jax.random.key_data(jax.random.key(seed)))
    return int(words[0]), int(words[1])


def interpreter_params(env: Environment, params: Any) -> dict[str, Any]:
    """Returns the parameters of the compiled step as the interpreter has them, the same numbers bit for bit."""
    return {p.name: loaded(np.asarray(getattr(params, param_attribute(p.name))), p.type) for p in env.game.params}


@dataclass
class Stepped:
    """What both engines made of a step, as plain numbers of the compiled step; seen: observation and allowed actions."""

    state: Any
    world: World
    seen: tuple[np.ndarray, np.ndarray]
    reward: list[float]
    events: dict[str, Any]
    metrics: dict[str, float]
    terminated: bool
    truncated: bool


def take_step(compiled: Compiled, state: Any, world: World, actions: Sequence[int], numbers: Numbers, seed: int) -> Stepped:
    """Takes a step on both engines with the same draws. Raises AssertionError if they come out differently."""
    env = compiled.env
    draws = Recorded(Threefry(*key_words(seed)))
    world, outcome = step(env.game, world, actions, numbers.interpreted, draws)
    seen, state, reward, _, info = compiled.step(jax.random.key(seed), state, np.asarray(actions, np.int32), numbers.compiled)
    differences = [*state_differences(env, state, world, seen), *outcome_differences(env, reward, info, outcome)]
    if differences and draws.near:
        raise AssertionError(f"a draw of seed {seed} falls on a computed chance, which rounding may decide either way: take another seed")
    if differences:
        raise AssertionError("the compiled step and the interpreter differ:\n  " + "\n  ".join(differences))
    return Stepped(
        state,
        world,
        (np.asarray(seen[0]), np.asarray(seen[1])),
        reward=np.asarray(reward).tolist(),
        events={name: np.asarray(value).tolist() for name, value in info["events"].items()},
        metrics={name: float(value) for name, value in info["metrics"].items()},
        terminated=bool(info["terminated"]),
        truncated=bool(info["truncated"]),
    )


def look_at(compiled: Compiled, state: Any, world: World, params: Any) -> tuple[np.ndarray, np.ndarray]:
    """Returns the observation of a state and the allowed actions. Raises AssertionError if the state is not the world."""
    seen = compiled.look(state, params)
    differences = state_differences(compiled.env, state, world, seen)
    if differences:
        raise AssertionError("the compiled game and the interpreter differ:\n  " + "\n  ".join(differences))
    return np.asarray(seen[0]), np.asarray(seen[1])


def state_differences(env: Environment, state: Any, world: World, seen: Any) -> list[str]:
    """Returns where two states differ: places, fields, timers, marks, who is away, what is seen and allowed."""
    game, (_, cols), pad = env.game, env.module.FRAME, env.module.PAD
    places = [(p // cols - pad, p % cols - pad) if p else None for p in np.asarray(state.position).tolist()]
    pairs = [
        ("places", places, [None if p is None else tuple(p) for p in world.position]),
        ("headings", np.asarray(state.heading).tolist(), world.heading),
        ("step", int(state.step), world.step),
        ("allowed actions", np.asarray(seen[1]).tolist(), action_mask(game, world)),
    ]
    if hasattr(state, "moved"):
        pairs.append(("moved", np.asarray(state.moved).tolist(), world.moved))
    if hasattr(state, "away"):
        pairs.append(("away", np.asarray(state.away).tolist(), [a.ticks if a else 0 for a in world.away]))
    for phase in marking(game):
        cells = np.asarray(getattr(state, f"mark_{phase.name}", ())).tolist()
        mine = {(cell // cols - pad, cell % cols - pad) for cell in cells if cell}
        pairs.append((f"marks of {phase.label}", sorted(mine), sorted({(r, c) for name, r, c in world.marks if name == phase.name})))
    found = [f"{name}: {mine} / {theirs}" for name, mine, theirs in pairs if mine != theirs]
    for declared in fields_of(game):
        mine, theirs = np.asarray(getattr(state, attribute_name(declared))), np.asarray(stored_values(declared, world))
        same = np.allclose(mine, theirs, **CLOSE) if declared.type.kind == "real" else mine.tolist() == theirs.tolist()
        if not same:
            found.append(f"{attribute_name(declared)}: {mine.tolist()} / {theirs.tolist()}")
    if not np.array_equal(np.asarray(seen[0]), interpreter_view.observe(game, world)):
        found.append("observations")
    return found


def outcome_differences(env: Environment, reward: Any, info: dict[str, Any], outcome: Outcome) -> list[str]:
    """Returns where rewards, events, metrics and endings of two steps differ."""
    pairs: list[tuple[str, Any, Any]] = [("reward", reward, outcome.reward)]
    for event in env.game.events:
        counts = np.asarray(outcome.events[event.name])
        names = [f"{event.name}[{word}]" for word in event.by] or [event.name]
        pairs += [(f"event {n}", info["events"][n], counts[..., i] if event.by else counts) for i, n in enumerate(names)]
    pairs += [(f"metric {name}", info["metrics"][name], value) for name, value in outcome.measures.items()]
    pairs.append(("terminated", info["terminated"], outcome.terminated))
    pairs.append(("truncated", info["truncated"], outcome.truncated and not outcome.terminated))
    found = [(name, np.asarray(mine, np.float64), np.asarray(theirs, np.float64)) for name, mine, theirs in pairs]
    return [f"{name}: {mine.tolist()} / {theirs.tolist()}" for name, mine, theirs in found if not np.allclose(mine, theirs, **CLOSE)]
