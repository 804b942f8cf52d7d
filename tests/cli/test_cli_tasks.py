"""The options --tasks, --split and --problem, from the command line to what is stored."""

import json
from pathlib import Path
from typing import Any

import click
import pytest

import sjdsl
import sjdsl.cli.evaluate as evaluating
import sjdsl.cli.list as listing
from sjdsl.cli import run, scenarios
from sjdsl.cli.environment_options import EnvironmentOptions, make_environment, read_tasks
from sjdsl.replay.dataset import load_recording
from sjdsl.replay.episode_player import EpisodePlayer, replayed
from sjdsl.replay.recording import Recording, RecordingError, check_tasks
from sjdsl.runtime.env import Environment
from tests.experiments.stored_policies import store, store_manifest

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


SIDES: dict[str, dict[str, Any]] = {
    "late": {"tasks": "held_out", "split": "late"},
    "problem": {"problem": 906},
}


def recorded(env: Environment, environment: dict[str, Any]) -> Recording:
    """Returns an episode of three steps."""
    player = EpisodePlayer(env, seed=3)
    for _ in range(3):
        player.step([2, 2])
    return player.recording(environment)


def test_an_episode_is_replayed_with_its_own_tasks_only() -> None:
    """Whatever the caller says of the environment, the recording names the tasks played."""
    envs = {name: sjdsl.make(CASE, **arguments) for name, arguments in SIDES.items()}
    assert len({env.hash for env in envs.values()}) == 1
    for name, env in envs.items():
        recording = recorded(env, {"game": str(CASE)})
        assert sjdsl.make(**recording.environment).game.task == env.game.task
        read = Recording.model_validate_json(recording.model_dump_json())
        check_tasks(read, env.game, env.name)
        assert len(list(replayed(read, env))) == 4
        for other, elsewhere in envs.items():
            if other != name:
                with pytest.raises(RecordingError, match="with other tasks of splits"):
                    next(replayed(read, elsewhere))


def test_a_recording_may_say_its_tasks_as_they_were_chosen() -> None:
    env = sjdsl.make(CASE, problem=906)
    recording = recorded(env, {"game": str(CASE)})
    chosen = recording.model_copy(update={"environment": {"game": str(CASE), "problem": 906}})
    check_tasks(chosen, env.game, env.name)
    nothing = recording.model_copy(update={"environment": {"game": str(CASE)}})
    with pytest.raises(RecordingError, match="other tasks of splits: tasks='all' there"):
        check_tasks(nothing, env.game, env.name)
    check_tasks(nothing, sjdsl.make(CASE, tasks="all").game, env.name)
    check_tasks(nothing, None, env.name)
    with pytest.raises(RecordingError, match="other tasks"):
        check_tasks(chosen, None, env.name)
    wrong = recording.model_copy(update={"environment": {"game": str(CASE), "tasks": "trainig"}})
    with pytest.raises(RecordingError, match="did you mean `training`"):
        check_tasks(wrong, env.game, env.name)


def test_recorded_and_played_episodes_name_their_tasks(tmp_path: Path) -> None:
    played = tmp_path / "played.json"
    play = ["play", str(CASE), "--watch", "--steps", "2", "--record", str(played)]
    assert run(play) == 0
    assert load_recording(played).environment["tasks"] == "training"
    file = tmp_path / "episodes.npz"
    assert run(["record", str(CASE), "--problem", "906", "--episodes", "1", "-o", str(file)]) == 0
    stored = load_recording(file).environment
    assert len(stored["tasks"]) == 8
    assert "problem" not in stored
    assert run(["replay", str(file)]) == 0


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (EnvironmentOptions(), {"tasks": "held_out", "split": "rich", "variant": "v"}),
        (EnvironmentOptions(tasks="training"), {"tasks": "training", "variant": "v"}),
        (EnvironmentOptions(problem=3), {"problem": 3, "variant": "v"}),
    ],
)
def test_a_choice_of_tasks_replaces_that_of_a_preset(
    options: EnvironmentOptions, expected: dict[str, Any]
) -> None:
    chosen = options.or_else({"tasks": "held_out", "split": "rich", "variant": "v"})
    assert {**chosen.of_tasks, "variant": chosen.variant} == expected


def stored_run(folder: Path, **tasks: Any) -> str:
    """Stores a run on some tasks; returns its folder."""
    provenance = EnvironmentOptions(**tasks).describe(str(CASE))
    store(folder, make_environment(provenance), 0)
    store_manifest(folder, provenance=provenance)
    return str(folder)


def test_tasks_that_are_chosen_replace_those_of_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    seen: list[Any] = []

    def stop(*arguments: Any, **_: Any) -> dict[str, Any]:
        seen.append(arguments)
        return {}

    monkeypatch.setattr(evaluating, "evaluate_run", stop)
    one = stored_run(tmp_path / "one", problem=3)
    assert run(["evaluate", one, "--tasks", "held_out", "--split", "late"]) == 0, (
        capsys.readouterr()
    )
    assert (seen[-1][1].tasks, seen[-1][1].split) == ("held_out", "late")
    rich = stored_run(tmp_path / "rich", tasks="held_out", split="rich")
    assert run(["evaluate", rich, "--tasks", "training"]) == 0, capsys.readouterr()
    assert (seen[-1][1].tasks, seen[-1][1].split) == ("training", "")

    monkeypatch.setattr(scenarios, "prepare_environment", stop)
    with pytest.raises(TypeError):  # what `stop` returns is no environment
        run(["evaluate", rich, "--scenario", "all", "--problem", "4"])
    arguments = seen[-1][1]
    assert arguments["problem"] == 4
    assert "tasks" not in arguments
    assert "split" not in arguments


@pytest.mark.parametrize(
    ("tasks", "message"),
    [
        ({"tasks": {"feeding": "red"}}, "the run is one on tasks with feeding=red"),
        ({"tasks": "held_out", "split": "rich"}, "the run is one on held-out tasks, rich"),
        ({"tasks": "all"}, "the run is one on all tasks"),
    ],
)
def test_why_a_split_alone_is_refused(
    tasks: dict[str, Any], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = stored_run(tmp_path / "run", **tasks)
    assert run(["evaluate", folder, "--split", "late"]) == 2
    assert message in " ".join(capsys.readouterr().err.split())


def test_a_split_of_a_game_that_holds_nothing_out_is_refused() -> None:
    chosen = EnvironmentOptions(split="late")
    with pytest.raises(click.UsageError, match="coins has none"):
        evaluating._held_out(sjdsl.make("coins"), chosen)
    with pytest.raises(click.UsageError, match="holds out none"):
        evaluating._held_out(sjdsl.make(CASE.with_name("tasks.sj")), chosen)


def test_list_counts_tasks(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(listing, "main_games", lambda: [str(CASE)])
    monkeypatch.setattr(listing, "melting_pot_games", lambda: [])
    assert run(["list"]) == 0
    assert "; 14,580 tasks" in capsys.readouterr().out


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


def test_a_sweep_and_a_preset_choose_tasks(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sweep = ["sweep", str(CASE), "--run", str(tmp_path / "runs"), "--dry-run", "--preset"]
    assert run([*sweep, "two_cores", "--axis", "split=late,rich", "--tasks", "held_out"]) == 0
    assert "splits_split-late" in capsys.readouterr().out
    assert run([*sweep, "two_cores", "--axis", "problem=a"]) == 1
    assert "a problem is a whole number, not 'a'" in capsys.readouterr().err
    preset = tmp_path / "mine.toml"
    preset.write_text('extends = "two_cores"\n[environment]\ntasks = { feding = "red" }\n')
    assert run(["train", str(CASE), "--preset", str(preset)]) == 1
    assert "did you mean `feeding`" in capsys.readouterr().err
    assert run([*sweep, str(preset), "--axis", "learning_rate=1"]) == 1
    assert "did you mean `feeding`" in capsys.readouterr().err
