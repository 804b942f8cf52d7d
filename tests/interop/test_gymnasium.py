"""The Gymnasium adapter: spaces, autoreset in the same step; each against the game's own step."""

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from sjdsl.interop.gymnasium import AgentGame, VectorGame

LENGTH = 10
SHORT = {"params": {"length": LENGTH}}


def test_slots_and_spaces() -> None:
    env = VectorGame("coins", 3, **SHORT)
    assert env.num_envs == 6
    assert env.metadata["autoreset_mode"] == gymnasium.vector.AutoresetMode.SAME_STEP
    observation, info = env.reset(seed=0)
    assert info == {}
    assert observation in env.observation_space
    assert observation[0] in env.single_observation_space
    observation, reward, terminated, truncated, _ = env.step(env.action_space.sample())
    assert observation in env.observation_space
    assert reward.dtype == np.float64
    assert reward.shape == terminated.shape == truncated.shape == (6,)


@pytest.fixture(scope="module")
def certain(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Returns a game of one agent without chance, which ends when both trees are eaten or after 20 steps."""
    text = (Path(__file__).parents[1] / "cases/endings.sj").read_text()
    for old, new in {
        "to path": "to path facing north",
        "acts forward": "acts step_left, step_right, forward",
        " or step % 7 == 6": "",
    }.items():
        assert text.count(old) == 1
        text = text.replace(old, new)
    path = tmp_path_factory.mktemp("game") / "endings.sj"
    path.write_text(text)
    return str(path)


def assert_alike(ours: Any, theirs: Any) -> None:
    for mine, own in zip(ours[:4], theirs[:4], strict=True):
        np.testing.assert_array_equal(mine, own)
    assert ("_final_obs" in ours[4]) == ("_final_obs" in theirs[4])
    for mine, own in (
        (ours[4], theirs[4]),
        (ours[4].get("final_info", {}), theirs[4].get("final_info", {})),
    ):
        for name in set(own) & {"_on_tree", "_final_obs", "_final_info"}:
            np.testing.assert_array_equal(mine[name], own[name])
        holds = own.get("_on_tree", np.zeros(3, bool))
        np.testing.assert_array_equal(
            mine.get("on_tree", holds)[holds], own.get("on_tree", holds)[holds]
        )
    for mine, own in zip(ours[4].get("final_obs", []), theirs[4].get("final_obs", []), strict=True):
        assert (mine is None) == (own is None) and (mine is None or np.array_equal(mine, own))


def test_autoreset_is_gymnasiums(certain: str) -> None:
    """Step by step what Gymnasium's own vector environment gives, through episodes that end at different times."""
    alone = [lambda: AgentGame(certain, others="stay")] * 3
    ours, theirs = (
        VectorGame(certain, 3),
        SyncVectorEnv(alone, autoreset_mode=AutoresetMode.SAME_STEP),
    )
    assert ours.metadata["autoreset_mode"] == theirs.metadata["autoreset_mode"]
    np.testing.assert_array_equal(ours.reset(seed=1)[0], theirs.reset(seed=1)[0])
    ends = np.zeros(3, int)
    ways = np.random.default_rng(0).integers(0, ours.single_action_space.n, (80, 3))
    for actions in ways:
        made = ours.step(actions)
        assert_alike(made, theirs.step(actions))
        ends += made[2] | made[3]
    assert len(set(ends.tolist())) > 1 and ends.min() > 1
