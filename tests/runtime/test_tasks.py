"""Tasks, and rows of different values: how often each comes up, how long it stays, what agents see of it."""

from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import sjdsl
from sjdsl.runtime.env import Environment
from sjdsl.runtime.random_bits import dealt_values

CASE = Path(__file__).parents[1] / "cases" / "tasks.sj"
TASK = ("world_feeding", "world_pay", "world_order", "world_delay")


@pytest.fixture(scope="module")
def env() -> Environment:
    return sjdsl.make(CASE)


def shuffled(words: np.ndarray, number: int) -> list[int]:
    """Returns the first values of a list after a Fisher-Yates shuffle, by plain integers."""
    values = list(range(number))
    for entry, word in enumerate(words):
        place = entry + (int(word) * (number - entry) >> 32)
        values[entry], values[place] = values[place], values[entry]
    return values[: len(words)]


@pytest.mark.parametrize(
    ("entries", "number"), [(1, 1), (3, 3), (3, 10), (8, 8), (9, 9), (9, 16), (64, 256)]
)
def test_dealt_values_are_those_of_a_shuffle(entries: int, number: int) -> None:
    words = np.random.default_rng(entries).integers(0, 2**32, (50, entries), np.uint32)
    words[0] = 2**32 - 1
    words[1] = 0
    dealt = np.asarray(dealt_values(jnp.asarray(words), number))
    assert dealt.tolist() == [shuffled(row, number) for row in words]
    assert all(len(set(row)) == entries for row in dealt.tolist())


def test_each_value_of_a_task_is_equally_likely(env: Environment) -> None:
    """3,000 episodes: a share p has a deviation of sqrt(p (1 - p) / 3000); five of it are allowed."""
    _, states = jax.vmap(env.reset)(jax.random.split(jax.random.key(0), 3000))
    rows = {"world_feeding": 3, "world_order": 3, "world_delay": 4, "world_pay": 10}
    for name, values in rows.items():
        drawn = np.asarray(getattr(states, name)).reshape(3000, -1)
        lowest = -1 if name == "world_delay" else 0
        bound = 5 * np.sqrt((1 / values) * (1 - 1 / values) / 3000)
        for value in range(lowest, lowest + values):
            shares = (drawn == value).mean(axis=0)
            assert (np.abs(shares - 1 / values) < bound).all(), (name, value, shares)


def test_a_task_lasts_for_all_trials_of_an_episode(env: Environment) -> None:
    _, state = env.reset(jax.random.key(1))
    tasks = []
    for step in range(40):
        tasks.append(tuple(np.asarray(getattr(state, name)).tolist() for name in TASK))
        state = env.step(jax.random.key(step), state, jnp.zeros(2, int))[1]
    tasks_as_text = [str(task) for task in tasks]
    episodes = [tasks_as_text[start : start + 10] for start in range(0, 40, 10)]
    assert all(len(set(episode)) == 1 for episode in episodes)
    assert len({episode[0] for episode in episodes}) > 1


def test_what_is_not_shown_changes_no_observation_and_no_mask(env: Environment) -> None:
    """`feeding` is shown, and a `forbid` reads it: with it the same, all else of the task may differ."""
    _, states = jax.vmap(env.reset)(jax.random.split(jax.random.key(2), 30))
    _, others = jax.vmap(env.reset)(jax.random.split(jax.random.key(3), 30))
    hidden = {name: getattr(others, name) for name in TASK if name != "world_feeding"}
    changed = states.replace(**hidden)
    for function in (env.observe, env.allowed_actions):
        np.testing.assert_array_equal(jax.vmap(function)(states), jax.vmap(function)(changed))
    told = states.replace(world_feeding=(states.world_feeding + 1) % 3)
    assert (jax.vmap(env.observe)(states) != jax.vmap(env.observe)(told)).any()
