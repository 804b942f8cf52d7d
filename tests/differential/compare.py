"""Steps the compiled game and the reference interpreter side by side on the same draws and says where they first differ."""

from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_name
from sjdsl.compiler.ir.queries import all_fields
from sjdsl.compiler.lower.deciding import deciding
from sjdsl.interpreter.state import Outcome, World, default_params
from sjdsl.interpreter.step import reset, step
from sjdsl.interpreter.stored import stored_values
from sjdsl.interpreter.threefry import Threefry
from sjdsl.runtime.env import Environment
from sjdsl.testing.differences import CLOSE, outcome_differences, state_differences


@dataclass
class Report:
    """How far two runs went together."""

    steps: int = 0
    differences: list[str] = field(default_factory=list)


def run(
    env: Environment,
    key: jax.Array,
    steps: int,
    actions: np.ndarray | None = None,
    params: Any = None,
    given: dict | None = None,
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
        actions = np.asarray(
            jax.random.randint(k_actions, (steps, env.num_agents), -1, env.num_actions + 1)
        )
    for t, step_key in enumerate(jax.random.split(k_steps, steps)):
        if report.differences:
            return report
        words = jax.random.key_data(step_key)
        draws = Threefry(int(words[0]), int(words[1]))
        world, outcome = step(env.game, world, [int(a) for a in actions[t]], given, draws)
        observation, state, reward, done, info = env.step_env(
            step_key, state, jnp.asarray(actions[t], jnp.int32), params
        )
        report.steps += 1
        compare(env, state, observation, world, report)
        compare_outcome(env, reward, done, info, outcome, report)
        report.differences = [f"step {t}: {d}" for d in report.differences]
    return report


def compare(
    env: Environment,
    state: Any,
    observation: jax.Array,
    world: World,
    report: Report,
    close: float = CLOSE,
) -> None:
    """Adds every difference between two states to the report. Reals that decide something are equal, others close."""
    report.differences += state_differences(env, state, world, observation, close=close)
    for declared in exact_fields(env):
        mine, theirs = (
            np.asarray(getattr(state, attribute_name(declared))),
            np.asarray(stored_values(declared, world), np.float32),
        )
        if not np.array_equal(mine, theirs.reshape(mine.shape)):
            report.differences.append(
                f"{declared.name}, which decides: {mine.tolist()} / {theirs.tolist()}"
            )


@lru_cache(maxsize=8)
def exact_fields(env: Environment) -> tuple[ir.VarField, ...]:
    """Returns the fields of reals that decide something."""
    found = deciding(env.game)
    return tuple(
        declared
        for declared in all_fields(env.game)
        if declared.type.kind == "real" and found.has_field(declared)
    )


def compare_outcome(
    env: Environment,
    reward: jax.Array,
    done: jax.Array,
    info: dict,
    outcome: Outcome,
    report: Report,
    close: float = CLOSE,
) -> None:
    """Adds differences of rewards, events, measures and endings to the report."""
    report.differences += outcome_differences(env, reward, info, outcome, close)
    if bool(done) != (outcome.terminated or outcome.truncated):
        report.differences.append(f"done: {bool(done)} / {outcome.terminated or outcome.truncated}")
