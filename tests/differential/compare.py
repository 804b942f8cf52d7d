"""Steps the compiled game and the reference interpreter side by side on the same draws and says where they first differ."""

from dataclasses import dataclass, field
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from sjdsl.interpreter.state import Outcome, World, default_params
from sjdsl.interpreter.step import reset, step
from sjdsl.interpreter.threefry import Recorded, Threefry
from sjdsl.runtime.env import Environment
from sjdsl.testing.differences import CLOSE, outcome_differences, state_differences


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


def compare(env: Environment, state: Any, observation: jax.Array, world: World, report: Report, close: float = CLOSE) -> None:
    """Adds every difference between two states to the report."""
    report.differences += state_differences(env, state, world, observation, close=close)


def compare_outcome(
    env: Environment, reward: jax.Array, done: jax.Array, info: dict, outcome: Outcome, report: Report, close: float = CLOSE
) -> None:
    """Adds differences of rewards, events, measures and endings to the report."""
    report.differences += outcome_differences(env, reward, info, outcome, close)
    if bool(done) != (outcome.terminated or outcome.truncated):
        report.differences.append(f"done: {bool(done)} / {outcome.terminated or outcome.truncated}")
