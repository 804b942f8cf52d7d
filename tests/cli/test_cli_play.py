"""`sjdsl play`, `replay` and `new`: keys become actions, what was played can be shown again, and a new game passes its own tests."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from command_line import Sjdsl

import sjdsl as package
from sjdsl.replay import EpisodePlayer, RecordingError, replayed
from sjdsl.runtime.env import Environment


@pytest.fixture
def env(folder: Path) -> Environment:
    return package.make(folder / "orchard.sj")


def test_what_was_recorded_is_shown_again(env: Environment, sjdsl: Sjdsl, folder: Path) -> None:
    (folder / "kept").mkdir()
    played = sjdsl("play", "orchard.sj", "--watch", "--seed", "5", "--record", "kept/episode.json")
    assert played.status == 0, played.text
    assert "kept/episode.json  6 steps of A Small Orchard" in played.out
    kept = json.loads((folder / "kept/episode.json").read_text())
    assert kept["hash"] == env.hash
    assert kept["seed"] == 5
    assert np.shape(kept["actions"]) == (6, 2)
    player = EpisodePlayer(env, 5)
    for step in kept["actions"]:
        player.step(step)
    assert kept["returns"] == player.returns.tolist()
    shown = sjdsl("replay", "kept/episode.json", "--speed", "1000")
    assert shown.status == 0, shown.text
    assert shown.out.count("step ") == 7
    assert "step 6\nreturns 0: " in shown.out
    filmed = sjdsl("replay", "kept/episode.json", "-o", "film.gif")
    assert "film.gif  7 frames" in filmed.out
    assert (folder / "film.gif").read_bytes().startswith(b"GIF8")


def test_an_episode_of_other_rules_is_refused(env: Environment, sjdsl: Sjdsl, folder: Path) -> None:
    player = EpisodePlayer(env, 5)
    player.step([0, 0])
    recording = player.recording({"game": str(folder / "orchard.sj")})
    (folder / "episode.json").write_text(recording.model_dump_json())
    (folder / "orchard.sj").write_text((folder / "orchard.sj").read_text().replace("none: 0.1", "none: 0.2"))
    shown = sjdsl("replay", "episode.json")
    assert shown.status == 1
    assert "the rules of orchard have changed since the episode was recorded" in shown.err
    with pytest.raises(RecordingError, match="were recorded"):
        list(replayed(recording.model_copy(update={"returns": [9.0, 9.0]}), env))


@pytest.mark.thorough
def test_a_new_game_passes_its_tests(sjdsl: Sjdsl, folder: Path) -> None:
    made = sjdsl("new", "pond")
    assert made.status == 0, made.text
    assert made.out.split()[:3] == ["pond.sj", "pond.txt", "test_pond.py"]
    assert "pond.sj: no problems" in sjdsl("check", "pond.sj").text
    assert sjdsl("fmt", "--check", "pond.sj").status == 0
    again = sjdsl("new", "pond")
    assert again.status == 1
    assert "pond.sj exists already; nothing was written" in again.err
    tests = subprocess.run([sys.executable, "-m", "pytest", "-q", "test_pond.py"], cwd=folder, capture_output=True, text=True, check=False)
    assert tests.returncode == 0, tests.stdout
    assert "3 passed" in tests.stdout
    assert sjdsl("test", "pond.sj", "--examples", "20").status == 0
