"""The PettingZoo adapter: PettingZoo's own tests, and the game's own returns."""

from functools import partial

import numpy as np
import pettingzoo
import pytest
from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test, render_test, seed_test
from pettingzoo.test.state_test import state_test
from pettingzoo.utils import parallel_to_aec

from sjdsl.interop.pettingzoo import ParallelGame, parallel_env

SHORT = {"params": {"length": 40}}
coins = partial(parallel_env, "coins", **SHORT)


def actions_of(env: ParallelGame, step: int) -> dict[str, int]:
    return {
        agent: (3 * step + index) % env.env.num_actions for index, agent in enumerate(env.agents)
    }


def trajectory(env: ParallelGame, seed: int, steps: int) -> list[tuple]:
    """Plays steps, over as many episodes as they take, and returns all that was returned."""
    seen: list[tuple] = [env.reset(seed=seed)]
    for step in range(steps):
        seen.append(env.step(actions_of(env, step)))
        if not env.agents:
            seen.append(env.reset())
    return seen


def assert_alike(first: list[tuple], second: list[tuple]) -> None:
    for a, b in zip(first, second, strict=True):
        for agent in a[0]:
            np.testing.assert_array_equal(a[0][agent], b[0][agent])
        assert a[1:-1] == b[1:-1]
        assert _plain(a[-1]) == _plain(b[-1])


def _plain(infos: dict[str, dict]) -> dict[str, dict]:
    return {
        agent: {name: np.asarray(value).tolist() for name, value in info.items()}
        for agent, info in infos.items()
    }


@pytest.mark.filterwarnings("error::UserWarning")
def test_pettingzoos_own_tests() -> None:
    parallel_api_test(coins(), num_cycles=100)
    parallel_seed_test(coins)
    api_test(parallel_to_aec(coins()), num_cycles=60)
    seed_test(lambda: parallel_to_aec(coins()))
    state_test(parallel_to_aec(coins()), coins())
    render_test(lambda render_mode=None: parallel_to_aec(coins(render_mode=render_mode)))


def test_bundled_games_are_registered() -> None:
    env = pettingzoo.make("parallel", "sjdsl/coins-v0", params={"length": 40})
    assert_alike(trajectory(env.unwrapped, 5, 60), trajectory(coins(), 5, 60))


def test_the_returns_are_the_games() -> None:
    """Rewards, events and the time limit against the environment itself."""
    env = coins()
    env.reset(seed=2)
    rewards = np.zeros(2)
    counts = np.zeros(2)
    for step in range(40):
        _, reward, terminated, truncated, info = env.step(actions_of(env, step))
        rewards += list(reward.values())
        counts += [info[agent]["own_coins"] + info[agent]["other_coins"] for agent in info]
        assert not any(terminated.values())
        assert all(truncated.values()) == (step == 39)
    assert env.agents == []
    assert env.step({}) == ({}, {}, {}, {}, {})
    assert rewards.sum() <= counts.sum()
