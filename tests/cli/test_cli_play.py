"""`sjdsl play`, `replay` and `new`: keys become actions, what was played can be shown again, and a new game passes its own tests."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import Sjdsl

import sjdsl as package
from sjdsl.cli.play import describe_moment, moments, own_keys
from sjdsl.render import random_policy, stay_policy
from sjdsl.render.look import make_look
from sjdsl.render.terminal import board_text
from sjdsl.replay import Course, RecordingError, replayed
from sjdsl.runtime.env import Environment

UP, LEFT = "\x1b[A", "\x1b[D"


@pytest.fixture
def env(folder: Path) -> Environment:
    return package.make(folder / "orchard.sj")


def steered(course: Course, keys: list[str], agent: int = 1, policy: Any = None) -> list[Any]:
    left = iter(keys)
    policy = policy or stay_policy(course.env)
    return list(moments(course, policy, agent, own_keys(course.env), lambda: next(left), 100))


def test_keys_are_actions_of_one_agent(env: Environment) -> None:
    course = Course(env, 3)
    shown = steered(course, [UP, LEFT, " ", "x", UP, "q"])
    names = [[env.action_names[number] for number in step] for step in course.actions]
    assert names == [["stay", "forward"], ["stay", "turn_left"], ["stay", "stay"], ["stay", "forward"]], "x is no key"
    assert len(shown) == 5
    assert not shown[-1].done


def test_an_episode_ends_by_itself(env: Environment) -> None:
    shown = steered(Course(env, 3), [UP] * 20)
    assert len(shown) == 7
    assert shown[-1].done


def test_own_actions_are_digits() -> None:
    keys = own_keys(package.make("clean_up"))
    assert (keys["1"], keys["2"], keys["\r"]) == (7, 8, 7)


def test_the_others_follow_their_policy_and_their_draws_are_their_own(env: Environment) -> None:
    first, second = Course(env, 3), Course(env, 3)
    steered(first, [UP] * 6, policy=random_policy(env))
    steered(second, [LEFT] * 6, policy=random_policy(env))
    assert [step[0] for step in first.actions] == [step[0] for step in second.actions]
    assert len({step[0] for step in first.actions}) > 1


def test_what_was_recorded_is_shown_again(env: Environment, sjdsl: Sjdsl, folder: Path) -> None:
    played = sjdsl("play", "orchard.sj", "--watch", "--seed", "5", "--record", "kept/episode.json")
    assert played.status == 0, played.text
    assert "kept/episode.json  6 steps of A Small Orchard" in played.out
    kept = json.loads((folder / "kept/episode.json").read_text())
    assert kept["hash"] == env.hash
    assert kept["seed"] == 5
    assert np.shape(kept["actions"]) == (6, 2)
    course = Course(env, 5)
    for step in kept["actions"]:
        course.step(step)
    assert kept["returns"] == course.returns.tolist()
    shown = sjdsl("replay", "kept/episode.json", "--speed", "1000")
    assert shown.status == 0, shown.text
    assert shown.out.count("step ") == 7
    assert "step 6\nreturns 0: " in shown.out
    filmed = sjdsl("replay", "kept/episode.json", "-o", "film.gif")
    assert "film.gif  7 frames" in filmed.out
    assert (folder / "film.gif").read_bytes().startswith(b"GIF8")


def test_an_episode_of_other_rules_is_refused(env: Environment, sjdsl: Sjdsl, folder: Path) -> None:
    course = Course(env, 5)
    course.step([0, 0])
    recording = course.recording({"game": str(folder / "orchard.sj")})
    (folder / "episode.json").write_text(recording.model_dump_json())
    (folder / "orchard.sj").write_text((folder / "orchard.sj").read_text().replace("none: 0.1", "none: 0.2"))
    shown = sjdsl("replay", "episode.json")
    assert shown.status == 1
    assert "was recorded under other rules" in shown.err
    with pytest.raises(RecordingError, match="were recorded"):
        list(replayed(recording.model_copy(update={"returns": [9.0, 9.0]}), env))


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (["replay", "none.json"], "none.json cannot be read: No such file or directory"),
        (["replay", "orchard.sj"], "orchard.sj is no recorded episode; `sjdsl play GAME --record orchard.sj` writes one"),
        (["replay", "none.json", "-o", "film.avi"], "is no .gif, no .mp4"),
        (["play", "orchard.sj"], "steering an agent takes a terminal; --watch does not"),
        (["play", "orchard.sj", "--watch", "--agent", "2"], "orchard has no agent 2: 0 to 1"),
        (["play", "orchard.sj", "--watch", "--others", "nobody"], "there is no policy `nobody`"),
        (["new", "My-Game"], "`My-Game` cannot name a game"),
        (["new", "class"], "`class` cannot name a game"),
    ],
)
def test_what_is_wrong_is_said(sjdsl: Sjdsl, call: list[str], said: str) -> None:
    shown = sjdsl(*call)
    assert shown.status in (1, 2)
    assert said in shown.err
    assert "Traceback" not in shown.err


def test_a_board_in_letters(env: Environment) -> None:
    course = Course(env, 3)
    moment = course.step([0, 3])
    text = board_text(make_look(env), moment.snapshot, {}).plain.splitlines()
    assert len(text) == 4
    assert {len(line) for line in text} == {10}, "two letters a cell"
    for number in (0, 1):
        row, col = int(moment.snapshot.row[number]), int(moment.snapshot.col[number])
        assert text[row][2 * col : 2 * col + 2] == f"{'▲▶▼◀'[moment.snapshot.heading[number]]}{number}"
    assert describe_moment(moment).splitlines()[0] == "step 1"


def test_a_new_game_passes_its_tests(sjdsl: Sjdsl, folder: Path) -> None:
    made = sjdsl("new", "pond")
    assert made.status == 0, made.text
    assert made.out.split()[:3] == ["pond.sj", "pond.txt", "test_pond.py"]
    assert "pond.sj: no problems" in sjdsl("check", "pond.sj").text
    assert sjdsl("fmt", "--check", "pond.sj").status == 0
    again = sjdsl("new", "pond")
    assert again.status == 1
    assert "pond.sj is there already; nothing was written" in again.err
    tests = subprocess.run([sys.executable, "-m", "pytest", "-q", "test_pond.py"], cwd=folder, capture_output=True, text=True, check=False)
    assert tests.returncode == 0, tests.stdout
    assert "3 passed" in tests.stdout
    assert sjdsl("test", "pond.sj", "--examples", "20").status == 0
