"""The folder of an experiment: nothing else is in it, and no file of it is half written where the disk is full."""

import errno
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_games import OTHER, matrix_game

from sjdsl.experiments import (
    ExperimentError,
    cross_play,
    crossplay,
    playing,
    schelling,
    schelling_diagram,
)
from sjdsl.trainers.policies.evaluation import Evaluation

EPISODES = 3


@pytest.fixture
def played(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, ...]]:
    """Has line-ups played by a table, and pictures not drawn, for that would take seconds; returns the list of line-ups played."""
    done: list[tuple[str, ...]] = []

    def table(*_: Any) -> Any:
        def play(_: Any, lineup: Any, order: np.ndarray, *_asking: Any) -> tuple[Evaluation, None]:
            done.append(tuple(player.name for player in lineup))
            returns = np.arange(order.size, dtype=np.float32).reshape(order.shape) + len(
                set(lineup)
            )
            played = Evaluation(returns, np.full(len(order), 4, np.int32), {}, {}, {})
            return played, None

        return play

    monkeypatch.setattr(playing, "make_player_of_lineups", table)
    for command, draw in ((schelling, "draw_diagram"), (crossplay, "draw_matrix")):
        monkeypatch.setattr(command, draw, lambda _: None)
        monkeypatch.setattr(
            command, "picture_bytes", lambda _, ending: f"a picture as {ending}".encode()
        )
    return done


RESULTS = {
    "schelling": ("schelling.png", "schelling.svg", "schelling.json"),
    "crossplay": ("crossplay.csv", "matrix.png", "crossplay.json"),
}


def play(command: str, folder: Path, tell: Any = lambda _: None) -> None:
    if command == "schelling":
        schelling_diagram(matrix_game(), "stay", OTHER, episodes=EPISODES, folder=folder, tell=tell)
    else:
        cross_play(
            matrix_game(),
            policies=["stay", OTHER],
            mix="pairs",
            episodes=EPISODES,
            folder=folder,
            tell=tell,
        )


def files_of(command: str, folder: Path) -> dict[str, bytes]:
    return {name: (folder / name).read_bytes() for name in ("experiment.json", *RESULTS[command])}


@pytest.mark.usefixtures("played")
@pytest.mark.parametrize("command", RESULTS)
def test_a_full_disk_loses_nothing(
    tmp_path: Path, command: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Wherever it fills up: the error names the file, each file is whole or missing, and the same command writes all of them."""
    play(command, tmp_path / "whole")
    whole = files_of(command, tmp_path / "whole")
    sync, written = os.fsync, 0

    def full(file: int) -> None:
        nonlocal written
        written += 1
        if written > room:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        sync(file)

    names = ["experiment.json", *RESULTS[command]]
    for room in range(len(names)):
        folder, written = tmp_path / f"room_{room}", 0
        with monkeypatch.context() as patch:
            patch.setattr(os, "fsync", full)
            with pytest.raises(OSError, match="No space left") as refusal:
                play(command, folder)
        assert Path(refusal.value.filename).name == names[room]
        assert [(folder / name).exists() for name in names] == [
            name in names[:room] for name in names
        ]
        play(command, folder)
        assert files_of(command, folder) == whole


@pytest.mark.parametrize("command", RESULTS)
def test_two_processes_in_one_folder_write_the_same(
    tmp_path: Path, command: str, played: list[Any]
) -> None:
    def begin_another(said: str) -> None:
        if "line-up 2" in said:
            play(command, tmp_path / "folder")

    play(command, tmp_path / "folder", begin_another)
    assert len(played) == 6
    play(command, tmp_path / "alone")
    assert files_of(command, tmp_path / "folder") == files_of(command, tmp_path / "alone")


@pytest.mark.usefixtures("played")
def test_an_experiment_that_was_stopped_leaves_its_folder_to_another(tmp_path: Path) -> None:
    def stop(_: str) -> None:
        raise KeyboardInterrupt

    folder = tmp_path / "folder"
    with pytest.raises(KeyboardInterrupt):
        play("crossplay", folder, stop)
    play("schelling", folder)
    with pytest.raises(ExperimentError, match="holds another experiment"):
        play("crossplay", folder)


@pytest.mark.usefixtures("played")
def test_one_that_was_killed_while_it_wrote_leaves_its_folder_to_another(tmp_path: Path) -> None:
    """Its last file is missing; and where only its description is there, that may be half of one."""
    folder = tmp_path / "deep/folder"
    play("schelling", folder)
    (folder / "schelling.json").unlink()
    play("crossplay", folder)
    with pytest.raises(ExperimentError, match="holds another experiment"):
        play("schelling", folder)  # of which the cross-play is whole
    other = tmp_path / "other"
    other.mkdir()
    (other / "experiment.json").write_text("{")
    play("schelling", other)


def test_a_damaged_folder(tmp_path: Path, played: list[Any]) -> None:
    """Made, with half a file in it: used. Its description cut off: refused, and left as it is."""
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / "experiment.json.unfinished").write_text('{"exp')
    play("schelling", folder)
    assert len(played) == 3

    asked = folder / "experiment.json"
    asked.write_text(asked.read_text()[:100])
    before = {path: path.read_bytes() for path in folder.rglob("*.*") if path.is_file()}
    with pytest.raises(ExperimentError, match=r"experiment.json is damaged and can't be read"):
        play("schelling", folder)
    asked.unlink()
    with pytest.raises(ExperimentError, match=r"not empty and holds no experiment"):
        play("schelling", folder)
    assert {path: path.read_bytes() for path in before if path != asked} == {
        path: text for path, text in before.items() if path != asked
    }


def test_a_folder_in_use_is_not_written_to(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(ExperimentError, match=r"not empty and holds no experiment \(notes.txt\)"):
        play("schelling", tmp_path)
    with pytest.raises(ExperimentError, match="is a file"):
        play("schelling", tmp_path / "notes.txt")
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]
