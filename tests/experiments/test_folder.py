"""The folder of an experiment: one process at a time, nothing else in it, and nothing lost where the disk is full."""

import errno
import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_games import OTHER, matrix_game

from sjdsl.experiments import ExperimentError, cross_play, crossplay, playing, schelling, schelling_diagram
from sjdsl.experiments.folder import open_folder
from sjdsl.trainers.evaluation import Evaluation

EPISODES = 3


@pytest.fixture
def played(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, ...]]:
    """Has line-ups played by a table, and pictures not drawn, for that would take seconds; returns the list of line-ups played."""
    done: list[tuple[str, ...]] = []

    def table(*_: Any) -> Any:
        def play(_: Any, lineup: Any, order: np.ndarray) -> Evaluation:
            done.append(tuple(player.name for player in lineup))
            returns = np.arange(order.size, dtype=np.float32).reshape(order.shape) + len(set(lineup))
            return Evaluation(returns, np.full(len(order), 4, np.int32), {}, {}, {})

        return play

    monkeypatch.setattr(playing, "make_player_of_lineups", table)
    for command, draw in ((schelling, "draw_diagram"), (crossplay, "draw_matrix")):
        monkeypatch.setattr(command, draw, lambda _: None)
        monkeypatch.setattr(command, "picture_bytes", lambda _, ending: f"a picture as {ending}".encode())
    return done


RESULTS = {
    "schelling": ("schelling.json", "schelling.png", "schelling.svg"),
    "crossplay": ("crossplay.csv", "crossplay.json", "matrix.png"),
}


def play(command: str, folder: Path, tell: Any = lambda _: None) -> None:
    if command == "schelling":
        schelling_diagram(matrix_game(), "stay", OTHER, episodes=EPISODES, folder=folder, tell=tell)
    else:
        cross_play(matrix_game(), policies=["stay", OTHER], mix="pairs", episodes=EPISODES, folder=folder, tell=tell)


def files_of(command: str, folder: Path) -> dict[str, bytes]:
    return {name: (folder / name).read_bytes() for name in ("experiment.json", *RESULTS[command])}


@pytest.mark.parametrize("command", RESULTS)
def test_a_full_disk_loses_nothing(tmp_path: Path, command: str, played: list[Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """Wherever it fills up: the error names the file, what was whole is still there, and the same command goes on to the same files."""
    play(command, tmp_path / "whole")
    whole, lineups = files_of(command, tmp_path / "whole"), len(played)
    sync, written = os.fsync, 0

    def full(file: int) -> None:
        nonlocal written
        written += 1
        if written > room:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        sync(file)

    for room in range(1 + lineups + len(RESULTS[command])):
        folder, written = tmp_path / f"room_{room}", 0
        with monkeypatch.context() as patch:
            patch.setattr(os, "fsync", full)
            with pytest.raises(OSError, match="No space left") as refusal:
                play(command, folder)
        names = ["experiment.json", *(f"lineup_{number:03d}_replicate_00.json" for number in range(lineups)), *RESULTS[command]]
        assert Path(refusal.value.filename).name == names[room]
        assert [(folder / name).exists() for name in RESULTS[command]] == [name in names[:room] for name in RESULTS[command]]
        played.clear()
        play(command, folder)
        assert len(played) == lineups - len(set(names[:room]) & set(names[1 : 1 + lineups]))
        assert files_of(command, folder) == whole


@pytest.mark.parametrize("command", RESULTS)
def test_two_processes_do_not_play_in_one_folder(tmp_path: Path, command: str, played: list[Any]) -> None:
    """The second is told who plays there, and disturbs nothing; when the first has ended, it finds everything done."""
    folder, refusals = tmp_path / "folder", []

    def begin_another(_: str) -> None:
        with pytest.raises(ExperimentError, match=rf"folder is in use by process {os.getpid()} on \S+;") as refusal:
            play(command, folder)
        refusals.append(refusal)

    play(command, folder, begin_another)
    assert len(refusals) == len(played) == 3
    play(command, tmp_path / "alone")
    assert files_of(command, folder) == files_of(command, tmp_path / "alone")
    play(command, folder)
    assert len(played) == 6


def test_a_folder_is_free_after_a_process_has_failed_in_it(tmp_path: Path) -> None:
    for _ in range(2):
        with pytest.raises(KeyboardInterrupt), open_folder(tmp_path / "folder", {"experiment": "mine"}):
            raise KeyboardInterrupt


@pytest.mark.usefixtures("played")
def test_an_experiment_that_ended_before_its_first_line_up_leaves_its_folder_to_another(tmp_path: Path) -> None:
    """What it asked is not held against another experiment, which plays and keeps there; from then on the folder is of that one."""
    folder = tmp_path / "folder"
    with pytest.raises(KeyboardInterrupt), open_folder(folder, {"experiment": "mine"}):
        raise KeyboardInterrupt
    play("schelling", folder)
    play("schelling", tmp_path / "alone")
    assert files_of("schelling", folder) == files_of("schelling", tmp_path / "alone")
    with pytest.raises(ExperimentError, match="holds another experiment"), open_folder(folder, {"experiment": "mine"}):
        pass


@pytest.mark.parametrize("returns", ["[[1.0], [2.0, 3.0]]", '[["much"]]'])
def test_a_damaged_part_is_played_again(tmp_path: Path, played: list[Any], returns: str) -> None:
    """Where it is JSON, too, but no table of numbers."""
    play("schelling", tmp_path)
    before = files_of("schelling", tmp_path)
    part = next((tmp_path / "parts").glob("*.json"))
    part.write_text(json.dumps({**json.loads(part.read_text()), "returns": json.loads(returns)}))
    done = len(played)
    play("schelling", tmp_path)
    assert len(played) == done + 1
    assert files_of("schelling", tmp_path) == before


def test_a_half_written_folder(tmp_path: Path, played: list[Any]) -> None:
    """Made, with nothing in it yet: gone on with. Its description cut off: refused, and left as it is."""
    folder = tmp_path / "folder"
    (folder / "parts").mkdir(parents=True)
    (folder / "parts/.lock").touch()
    (folder / "experiment.json.unfinished").write_text('{"exp')
    play("schelling", folder)
    assert len(played) == 3

    asked = folder / "experiment.json"
    asked.write_text(asked.read_text()[:100])
    before = {path: path.read_bytes() for path in folder.rglob("*.*") if path.is_file()}
    with pytest.raises(ExperimentError, match=r"experiment.json is damaged and can't be read"):
        play("schelling", folder)
    asked.unlink()
    with pytest.raises(ExperimentError, match=r"not empty and holds no experiment to resume"):
        play("schelling", folder)
    assert {path: path.read_bytes() for path in before if path != asked} == {path: text for path, text in before.items() if path != asked}


def test_a_folder_in_use_is_not_written_to(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(ExperimentError, match=r"not empty and holds no experiment to resume \(notes.txt\)"):
        play("schelling", tmp_path)
    with pytest.raises(ExperimentError, match="is a file"):
        play("schelling", tmp_path / "notes.txt")
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]
