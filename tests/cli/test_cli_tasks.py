"""The options --tasks, --split and --problem, from the command line to what is stored."""

import json
from pathlib import Path

import click
import pytest

import sjdsl.cli.list as listing
from sjdsl.cli import run
from sjdsl.cli.environment_options import EnvironmentOptions, read_tasks
from sjdsl.replay.dataset import load_recording

CASE = Path(__file__).parents[1] / "cases" / "splits.sj"


def test_texts_are_a_side_or_values() -> None:
    assert read_tasks(()) is None
    assert read_tasks(("held_out",)) == "held_out"
    fields = read_tasks(("feeding=red", "pay[red]=3", "pay[blue]=1"))
    assert fields == {"feeding": "red", "pay": {"red": 3, "blue": 1}}
    with pytest.raises(click.UsageError, match="one side"):
        read_tasks(("training", "feeding=red"))


def test_games_are_described_with_their_tasks() -> None:
    plain = EnvironmentOptions().describe("coins")
    assert "tasks" not in plain
    chosen = EnvironmentOptions(tasks="held_out", split="rich", problem=7)
    described = chosen.describe(str(CASE))
    assert (described["tasks"], described["split"], described["problem"]) == ("held_out", "rich", 7)
    assert chosen.names == ["tasks", "split", "problem"]
    game = chosen.check(str(CASE))
    assert game.task is not None
    assert len(game.task.given) == 8


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--tasks", "feding=red"], "did you mean `feeding`"),
        (["--tasks", "pay[rod]=3"], "did you mean `pay[red]`"),
        (["--tasks", "feeding=rod"], "one of red, green, blue"),
        (["--tasks", "held_out"], "several splits, rules, rich, late"),
        (["--tasks", "held_out", "--split", "rick"], "did you mean `rich`"),
    ],
)
def test_what_does_not_fit_the_game_is_refused(
    options: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["trace", str(CASE), "--steps", "1", *options]) == 1
    assert message in capsys.readouterr().err


def test_a_game_without_a_task_says_so(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["trace", "coins", "--steps", "1", "--problem", "3"]) == 1
    assert "coins has no task" in capsys.readouterr().err


def test_a_recorded_episode_is_replayed_with_its_tasks(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "episodes.npz"
    options = ["--tasks", "held_out", "--split", "late", "--episodes", "2", "-o", str(file)]
    assert run(["record", str(CASE), *options]) == 0
    capsys.readouterr()
    assert run(["replay", str(file), "--episode", "1"]) == 0  # which checks rewards and returns
    stored = load_recording(file, 1).environment
    assert (stored["tasks"], stored["split"]) == ("held_out", "late")
    assert "problem" not in stored


def test_list_counts_tasks(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(listing, "main_games", lambda: [str(CASE)])
    monkeypatch.setattr(listing, "melting_pot_games", lambda: [])
    assert run(["list"]) == 0
    assert "    tasks    14,580" in capsys.readouterr().out


def test_evaluation_compares_training_and_held_out_tasks(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "evaluation.json"
    options = ["--split", "late", "--episodes", "4", "-o", str(file)]
    assert run(["evaluate", "stay", "--game", str(CASE), *options]) == 0
    out = capsys.readouterr().out
    assert "held out, late" in out
    stored = json.loads(file.read_text())
    assert stored["game"]["tasks"] == "training"
    (of_split,) = stored["held_out"].values()
    difference = stored["summary"]["final paid"]["mean"] - of_split["summary"]["final paid"]["mean"]
    assert difference != 0  # red pays 0 to 2 in late tasks
    assert of_split["training_minus_held_out"] == {"mean": 0, "low": 0, "high": 0}
