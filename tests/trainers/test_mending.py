"""Metrics of a run that were damaged: no row is lost in silence when it is resumed."""

import warnings
from collections.abc import Callable
from pathlib import Path

import pytest
from probes import matching
from run_outcomes import SHORT, assert_same_end, copy_run, counting

from sjdsl.results import ResultsWarning, load
from sjdsl.trainers import RunError, resume, run, train
from sjdsl.trainers.compiled import compile_train
from sjdsl.trainers.metrics_files import read_rows

JSONL, EVALUATIONS = "metrics.jsonl", "evaluations.jsonl"
Damage = Callable[[Path], None]
pytestmark = pytest.mark.usefixtures("shared")


@pytest.fixture(scope="module")
def stopped(shared: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same run, stopped after update 9."""
    del shared
    folder = tmp_path_factory.mktemp("runs") / "stopped"
    return train(
        matching(), SHORT, folder, "none", callback=lambda update: update.number == 9
    ).run_dir


def change(number: int, to: Callable[[bytes], bytes]) -> Damage:
    """Returns what changes one line of a file, counted from 0."""

    def damage(path: Path) -> None:
        lines = path.read_bytes().splitlines(keepends=True)
        lines[number] = to(lines[number])
        path.write_bytes(b"".join(lines))

    return damage


DAMAGES: dict[str, Damage] = {
    "halved": lambda path: path.write_bytes(path.read_bytes()[: path.stat().st_size // 2]),
    "emptied": lambda path: path.write_bytes(b""),
    "removed": lambda path: path.unlink(),
    "a line broken in the middle": change(3, lambda line: line[: len(line) // 2] + b"\n"),
    "a line gone": change(4, lambda _: b""),
    "a line twice": change(4, lambda line: 2 * line),
    "a line of zeros": change(5, lambda line: b"\0" * (len(line) - 2) + b"\n"),
    "a line without its end": change(2, lambda line: line.rstrip()),
    "another thing in JSON": change(3, lambda _: b"3\n"),
    "bytes of no text": change(3, lambda line: b"\xff\xfe" + line),
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
def test_rows_that_are_lost_are_missed(stopped: Path, tmp_path: Path, damage: Damage) -> None:
    again = copy_run(stopped, tmp_path / "run")
    before = {path: path.read_bytes() for path in (again / "policies").iterdir()}
    damage(again / JSONL)
    with pytest.raises(
        RunError,
        match=r"metrics\.jsonl is damaged: it(s line \d can't be read| holds only the first [0-8] of the 9 updates)\.",
    ):
        resume(matching(), again, "none")
    assert {path: path.read_bytes() for path in (again / "policies").iterdir()} == before


@pytest.mark.parametrize(
    "damage",
    [
        DAMAGES["halved"],
        DAMAGES["removed"],
        change(1, lambda line: line[:9] + b"\n"),
        change(1, lambda _: b"3\n"),
    ],
)
def test_evaluations_that_are_lost_are_missed(
    stopped: Path, tmp_path: Path, damage: Damage
) -> None:
    again = copy_run(stopped, tmp_path / "run")
    damage(again / EVALUATIONS)
    with pytest.raises(
        RunError,
        match=r"evaluations\.jsonl is damaged: it(s line 2 can't be read| holds only [01] of 3 evaluations)\.",
    ):
        resume(matching(), again, "none")


def test_what_comes_after_the_checkpoint_may_be_anything(
    stopped: Path, whole: Path, tmp_path: Path
) -> None:
    again = copy_run(stopped, tmp_path / "run")
    (again / "checkpoints" / "9.safetensors").unlink()
    change(-1, lambda line: line[:30] + b"\n")(again / JSONL)
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)
        resume(matching(), again, "none")
    assert_same_end(again, whole)


def test_a_seed_that_has_diverged_has_fewer_rows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(run, "compile_train", compile_train)
    monkeypatch.setattr(
        run, "make_train", lambda *_: counting(diverges_after=3, seed_that_diverges=5)
    )
    config = SHORT.model_copy(update={"evaluate_every": 0, "seeds": 2})
    train(matching(), config, tmp_path / "run", "none", callback=lambda update: update.number == 6)
    resume(matching(), tmp_path / "run", "none")
    assert [len([*read_rows(tmp_path / "run" / f"seed_{seed}" / JSONL)]) for seed in (5, 6)] == [
        4,
        12,
    ]


def test_who_reads_a_damaged_file_is_told_where(whole: Path, tmp_path: Path) -> None:
    again = copy_run(whole, tmp_path / "run")
    change(3, lambda line: line[:20] + b"\n")(again / JSONL)
    with pytest.raises(RunError, match=r"metrics\.jsonl is damaged: its line 4 can't be read"):
        [*read_rows(again / JSONL)]
    with pytest.warns(ResultsWarning, match="line 4 can't be read"):
        load(again)
