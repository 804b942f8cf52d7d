"""Steps the compiled game and the reference interpreter side by side on the same draws and says where they first differ."""

from dataclasses import dataclass, field
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.identifiers import attribute_name, param_attribute
from sjdsl.interpreter import observe as interpreter_view
from sjdsl.interpreter.draws import Recorded, Threefry
from sjdsl.interpreter.state import World, default_params
from sjdsl.interpreter.step import reset, step
from sjdsl.runtime.env import Environment

RELATIVE, ABSOLUTE = 1e-6, 1e-6


@dataclass
class Report:
    """How far two runs went together. `near`: draws that fell on a computed threshold, where float32 may decide either way."""

    steps: int = 0
    near: int = 0
    differences: list[str] = field(default_factory=list)


def run(
    env: Environment, key: jax.Array, steps: int, actions: np.ndarray | None = None, params: Any = None, given: dict | None = None
) -> Report:
    """Returns the first differences of `steps` steps from a reset, with random actions unless `actions` `[T, N]` are given.

    `params` for the compiled step and `given` for the interpreter are the same numbers.
    """
    params = env.params if params is None else params
    given = {**default_params(env.game), **(given or {})}
    report = Report()
    k_reset, k_actions, k_steps = jax.random.split(key, 3)
    words = jax.random.key_data(k_reset)
    world = reset(env.game, given, Threefry(int(words[0]), int(words[1])))
    observation, state = env.reset(k_reset, params)
    compare(env, state, observation, world, report)
    if actions is None:
        # one number too many on each side: unknown actions are `stay`
        actions = np.asarray(jax.random.randint(k_actions, (steps, env.num_agents), -1, env.num_actions + 1))
    for t, step_key in enumerate(jax.random.split(k_steps, steps)):
        if report.differences:
            return report
        words = jax.random.key_data(step_key)
        draws = Recorded(Threefry(int(words[0]), int(words[1])))
        world, outcome = step(env.game, world, [int(a) for a in actions[t]], given, draws)
        observation, state, reward, done, info = env.step_env(step_key, state, jnp.asarray(actions[t], jnp.int32), params)
        report.steps += 1
        if draws.near:
            report.near += len(draws.near)
            return report
        compare(env, state, observation, world, report)
        compare_outcome(env, reward, done, info, outcome, report)
        report.differences = [f"step {t}: {d}" for d in report.differences]
    return report


def compare(env: Environment, state: Any, observation: jax.Array, world: World, report: Report) -> None:
    """Adds every difference between two states to the report."""
    game = env.game
    rows, cols = (np.asarray(x) for x in env.cells(state))
    places = [(int(r), int(c)) if p else None for r, c, p in zip(rows, cols, np.asarray(state.position), strict=True)]
    _equal("position", places, [None if p is None else (p.row, p.col) for p in world.position], report)
    _equal("heading", np.asarray(state.heading).tolist(), list(world.heading), report)
    _equal("step", int(state.step), world.step, report)
    if hasattr(state, "moved"):
        _equal("moved", np.asarray(state.moved).tolist(), list(world.moved), report)
    if hasattr(state, "away"):
        _equal("away", np.asarray(state.away).tolist(), [a.ticks if a else 0 for a in world.away], report)
    for declared in (*(f for k in game.kinds for f in k.fields), *game.agents.fields, *game.fields):
        name = attribute_name(declared)
        mine = np.asarray(getattr(state, name))
        match declared.place:
            case "cell":
                values: Any = world.cells[declared.kind, declared.name]
            case "agent":
                values = world.agents[declared.name]
            case _:
                values = world.fields[declared.name]
        theirs = encoded(values, declared, list_of=declared.place != "world")
        if declared.type.kind == "real":
            if not np.allclose(mine, np.asarray(theirs, np.float32), rtol=RELATIVE, atol=ABSOLUTE):
                report.differences.append(f"{name}: {mine.tolist()} / {theirs}")
        else:
            _equal(name, mine.tolist(), theirs, report)
    seen = interpreter_view.observe(game, world)
    mine = np.asarray(observation)
    if mine.shape != seen.shape or not np.array_equal(mine, seen):
        where = np.argwhere(mine != seen)[:5].tolist() if mine.shape == seen.shape else (mine.shape, seen.shape)
        shown = [(w, int(mine[tuple(w)]), int(seen[tuple(w)])) for w in where] if mine.shape == seen.shape else where
        report.differences.append(f"observation: {shown}")


def encoded(value: Any, declared: ir.VarField, list_of: bool) -> Any:
    """Returns an interpreter's value as the compiled state keeps it."""
    if list_of:
        return [encoded(v, declared, list_of=False) for v in value]
    if isinstance(value, tuple):
        return [encoded(v, declared, list_of=False) for v in value]
    match declared.type.kind:
        case "word":
            return declared.type.words.index(value)
        case "agent":
            return -1 if value is None else int(value)
        case "agents":
            return sum(1 << a for a in value)
        case "real":
            return float(value)
        case _:
            return int(value)


def compare_outcome(env: Environment, reward: jax.Array, done: jax.Array, info: dict, outcome: Any, report: Report) -> None:
    """Adds differences of rewards, events, measures and endings to the report."""
    if not np.allclose(np.asarray(reward), np.asarray(outcome.reward), rtol=RELATIVE, atol=ABSOLUTE):
        report.differences.append(f"reward: {np.asarray(reward).tolist()} / {outcome.reward}")
    for event in env.game.events:
        theirs = np.asarray(outcome.events[event.name])
        names = [f"{event.name}[{w}]" for w in event.by] or [event.name]
        for i, name in enumerate(names):
            mine = np.asarray(info["events"][name])
            _equal(f"event {name}", mine.tolist(), (theirs[..., i] if event.by else theirs).tolist(), report)
    for name, value in outcome.measures.items():
        if not np.isclose(float(info["metrics"][name]), float(value), rtol=RELATIVE, atol=ABSOLUTE):
            report.differences.append(f"metric {name}: {info['metrics'][name]} / {value}")
    _equal("terminated", bool(info["terminated"]), outcome.terminated, report)
    _equal("done", bool(done), outcome.terminated or outcome.truncated, report)


def _equal(name: str, mine: Any, theirs: Any, report: Report) -> None:
    if mine != theirs:
        if isinstance(mine, list) and isinstance(theirs, list) and len(mine) == len(theirs) and len(mine) > 12:
            at = [(i, a, b) for i, (a, b) in enumerate(zip(mine, theirs, strict=True)) if a != b][:5]
            report.differences.append(f"{name} at {at}")
        else:
            report.differences.append(f"{name}: {mine} / {theirs}")


__all__ = ["Report", "compare", "param_attribute", "run"]
