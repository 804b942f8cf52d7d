"""Recorded episodes as a Minari dataset: an episode of one agent each, read back by Minari itself."""

from pathlib import Path

import minari
import numpy as np
import pytest

from sjdsl.cli import run
from sjdsl.interop.gymnasium import AgentGame
from sjdsl.replay import Dataset

CALL = ["record", "coins", "--episodes", "3", "--param", "length=20", "--param", "spawn=0.3"]
ID = "sjdsl/coins/random-v0"


@pytest.fixture
def datasets(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Lets Minari keep its datasets here."""
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path / "minari"))
    return tmp_path


def test_agents_are_episodes(datasets: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = datasets / "coins.npz"
    assert run([*CALL, "-o", str(file), "--observation", "onehot", "--minari", ID]) == 0
    assert f"{ID}  6 episodes of one agent each, 120 steps" in capsys.readouterr().out
    ours, theirs = Dataset(file), minari.load_dataset(ID)
    assert (theirs.total_episodes, theirs.total_steps) == (6, 120)
    for number, episode in enumerate(theirs.iterate_episodes()):
        whole, agent = ours[number // 2], number % 2
        assert whole.observations is not None
        np.testing.assert_array_equal(episode.observations, np.moveaxis(whole.observations[:, agent], 1, -1))
        np.testing.assert_array_equal(episode.actions, whole.actions[:, agent])
        np.testing.assert_array_equal(episode.rewards, whole.rewards[:, agent])
        np.testing.assert_array_equal(episode.infos["own_coins"][1:], whole.events["own_coins"][:, agent])
        assert episode.truncations.tolist() == [False] * 19 + [True] and not episode.terminations.any()
        assert all(observation in theirs.observation_space for observation in episode.observations)
    metadata = next(iter(theirs.storage.get_episode_metadata([3])))
    assert metadata["options"]["agent"] == 1 and metadata["options"]["episode"] == 1 and metadata["seed"] == 1


def test_the_environment_comes_back(datasets: Path) -> None:
    assert run([*CALL, "-o", str(datasets / "coins.npz"), "--minari", ID]) == 0
    dataset = minari.load_dataset(ID)
    env = dataset.recover_environment()
    assert isinstance(env.unwrapped, AgentGame)
    assert env.unwrapped.env.episode_length == 20
    assert (env.observation_space, env.action_space) == (dataset.observation_space, dataset.action_space)


def test_it_is_refused_before_anything_is_played(datasets: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = datasets / "coins.npz"
    for wrong in ("coins random", "coins", "coins-v"):
        assert run([*CALL, "-o", str(file), "--minari", wrong]) == 1
        assert f"`{wrong}` can't name a Minari dataset" in capsys.readouterr().err
    assert run([*CALL, "-o", str(file), "--minari", ID, "--observation", "none"]) == 2
    assert not file.exists()
    assert run([*CALL, "-o", str(file), "--minari", ID]) == 0
    file.unlink()
    capsys.readouterr()
    assert run([*CALL, "-o", str(file), "--minari", ID]) == 1
    assert "the Minari dataset sjdsl/coins/random-v0 exists already" in capsys.readouterr().err
    assert not file.exists()
