"""The two engines of a scene, the compiled step and the interpreter, set to the same state."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import jax
import numpy as np

from sjdsl.compiler.ir.names import param_attribute
from sjdsl.compiler.ir.queries import counts_of
from sjdsl.interpreter.observe import observe
from sjdsl.interpreter.state import Outcome, World
from sjdsl.interpreter.step import action_mask, step
from sjdsl.interpreter.threefry import Threefry
from sjdsl.runtime.env import Environment
from sjdsl.testing.differences import outcome_differences, state_differences
from sjdsl.testing.values import loaded

QUICK = {
    "xla_backend_optimization_level": 0,
    "xla_llvm_disable_expensive_passes": True,
}  # compiling costs more than a few steps


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
        observation, state, reward, done, info = env.step_env(key, state, actions, params)
        told = {
            name: info[name] for name in ("truncated", "terminated", "events", "metrics")
        }  # the rest is the state and observation again
        return (observation, env.allowed_actions(state, params)), state, reward, done, told

    return Compiled(
        env,
        jax.device_get(env.module.initial_state()),
        jax.jit(look, compiler_options=QUICK),
        jax.jit(whole_step, compiler_options=QUICK),
    )


@lru_cache(maxsize=1024)
def key_words(seed: int) -> tuple[int, int]:
    """Returns the two words of `jax.random.key(seed)`."""
    words = np.asarray(jax.random.key_data(jax.random.key(seed)))
    return int(words[0]), int(words[1])


def interpreter_params(env: Environment, params: Any) -> dict[str, Any]:
    """Returns the parameters of the compiled step as the interpreter has them, the same numbers bit for bit."""
    return {
        p.name: loaded(np.asarray(getattr(params, param_attribute(p.name))), p.type)
        for p in env.game.params
    }


@dataclass
class Stepped:
    """What a step came to, as plain numbers; seen: observation, allowed actions."""

    state: Any
    world: World
    seen: tuple[np.ndarray, np.ndarray]
    reward: list[float]
    events: dict[str, Any]
    metrics: dict[str, float]
    terminated: bool
    truncated: bool


def take_step(
    compiled: Compiled,
    state: Any,
    world: World,
    actions: Sequence[int],
    numbers: Numbers,
    seed: int,
) -> Stepped:
    """Takes a step on both engines with the same draws. Raises AssertionError if they come out differently."""
    env = compiled.env
    world, outcome = step(env.game, world, actions, numbers.interpreted, Threefry(*key_words(seed)))
    seen, state, reward, _, info = compiled.step(
        jax.random.key(seed), state, np.asarray(actions, np.int32), numbers.compiled
    )
    differences = [
        *state_differences(env, state, world, *seen),
        *outcome_differences(env, reward, info, outcome),
    ]
    if differences:
        raise AssertionError(
            "the compiled step and the interpreter differ:\n  " + "\n  ".join(differences)
        )
    return _stepped(env, state, world, (np.asarray(seen[0]), np.asarray(seen[1])), outcome)


def look_at(
    compiled: Compiled, state: Any, world: World, params: Any
) -> tuple[np.ndarray, np.ndarray]:
    """Returns the observation of a state and the allowed actions. Raises AssertionError if the state is not the world."""
    seen = compiled.look(state, params)
    differences = state_differences(compiled.env, state, world, *seen)
    if differences:
        raise AssertionError(
            "the compiled game and the interpreter differ:\n  " + "\n  ".join(differences)
        )
    return np.asarray(seen[0]), np.asarray(seen[1])


def interpret_step(
    env: Environment, world: World, actions: Sequence[int], numbers: Numbers, seed: int
) -> Stepped:
    """Takes a step on the interpreter alone, with the draws that `take_step` would have; there is no compiled state."""
    world, outcome = step(env.game, world, actions, numbers.interpreted, Threefry(*key_words(seed)))
    return _stepped(env, None, world, interpret_look(env, world), outcome)


def _stepped(
    env: Environment,
    state: Any,
    world: World,
    seen: tuple[np.ndarray, np.ndarray],
    outcome: Outcome,
) -> Stepped:
    events: dict[str, Any] = {}
    for event in env.game.events:
        counts = np.asarray(outcome.events[event.name])
        events |= {
            n: (counts if word is None else counts[..., i]).tolist()
            for i, (word, n) in enumerate(counts_of(event))
        }
    return Stepped(
        state,
        world,
        seen,
        reward=[float(reward) for reward in outcome.reward],
        events=events,
        metrics={name: float(np.float32(value)) for name, value in outcome.measures.items()},
        terminated=outcome.terminated,
        truncated=outcome.truncated and not outcome.terminated,
    )


def interpret_look(env: Environment, world: World) -> tuple[np.ndarray, np.ndarray]:
    """Returns the observation of a state and the allowed actions, as the interpreter has them."""
    return observe(env.game, world), np.asarray(action_mask(env.game, world))
