"""Whole sweeps of a game so small that a cell trains in seconds: what is kept, what goes on, what fails, and the tables."""

import csv
import json
import math
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jax
import pytest

import sjdsl
from sjdsl.experiments.refusals import ExperimentError
from sjdsl.sweeps import work
from sjdsl.sweeps.axes import Axis
from sjdsl.sweeps.cells import SweepSpec
from sjdsl.sweeps.folder import cells_of, progress_of, read_sweep
from sjdsl.sweeps.running import Outcome, sweep
from sjdsl.sweeps.work import Watch
from sjdsl.trainers import evaluate, load_policy
from sjdsl.trainers.policies.evaluation import evaluation_key
from sjdsl.trainers.runs.run_errors import DiskError, RunError
from tests.sweeps.described import GAME, TINY

LOW, HIGH = "matrix_game_exchange_ratio-0.25", "matrix_game_exchange_ratio-0.75"


@pytest.fixture(autouse=True)
def no_key_check() -> Iterator[None]:
    """JAX takes the keys of any vmapped scan for used."""
    with jax.debug_key_reuse(False):
        yield


def asked(*ratios: float, **changes: Any) -> SweepSpec:
    settings = {**TINY, "reward": "exchange", **changes.pop("settings", {})}
    return SweepSpec(
        [GAME], [Axis("exchange_ratio", ratios)], settings=settings, episodes=3, **changes
    )


def rows_of(folder: Path) -> list[dict[str, str]]:
    with open(folder / "results.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def table_of(folder: Path) -> bytes:
    return (folder / "results.csv").read_bytes()


def states_of(folder: Path) -> dict[str, str]:
    known = read_sweep(folder)
    return {
        cell.name: progress_of(folder, cell, known["episodes"]).state for cell in cells_of(known)
    }


@pytest.fixture(scope="module")
def grown(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[str], Outcome]:
    """A sweep of one ratio, to which another was added; what was said; what came of it. `killed`: the folder while the second was trained."""
    folder, lines = tmp_path_factory.mktemp("sweeps") / "grown", list[str]()
    sweep(asked(0.25), folder, watch=Watch(tell=lines.append))
    train = work.train

    def copy(update: Any) -> None:
        if update.number == 2:  # as a process leaves it that is killed now
            shutil.copytree(folder, folder.parent / "killed")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(work, "train", lambda *given, **more: train(*given, callback=copy, **more))
        outcome = sweep(asked(0.75), folder, watch=Watch(tell=lines.append))
    return folder, lines, outcome


@pytest.mark.thorough
def test_a_new_value_only_adds_cells(grown: tuple[Path, list[str], Outcome]) -> None:
    folder, lines, outcome = grown
    assert [line.partition(":")[0] for line in lines] == [LOW, LOW, HIGH, HIGH]
    assert outcome.done == (HIGH,)
    assert not outcome.failed
    known = json.loads((folder / "sweep.json").read_text())
    assert [*known["cells"]] == [LOW, HIGH]
    assert known["cells"][HIGH]["values"] == {"exchange_ratio": 0.75}
    assert states_of(folder) == {LOW: "done", HIGH: "done"}


def test_results_are_the_evaluations_of_the_last_policies(
    grown: tuple[Path, list[str], Outcome],
) -> None:
    rows = rows_of(grown[0])
    assert [(row["cell"], row["seed"]) for row in rows] == [
        (LOW, "0"),
        (LOW, "1"),
        (HIGH, "0"),
        (HIGH, "1"),
    ]
    env = sjdsl.make(GAME)
    row = rows[3]
    folder = grown[0] / "cells" / HIGH / "seed_1"
    played = evaluate(env, load_policy(folder, env), evaluation_key(1), 3)
    assert float(row["collective_return"]) == pytest.approx(played.collective_returns.mean())
    assert float(row["return_agent_1"]) == pytest.approx(played.returns[:, 1].mean())
    assert (row["env_steps"], row["updates"], row["episodes"], row["hash"]) == (
        "64",
        "4",
        "3",
        env.hash,
    )
    assert (row["algorithm"], row["reward"], row["sharing"], row["exchange_ratio"]) == (
        "ippo",
        "exchange",
        "shared",
        "0.75",
    )
    assert row["hardware"].startswith("cpu x1")


def test_the_same_again_runs_nothing(
    grown: tuple[Path, list[str], Outcome], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(work, "train", None)
    before = table_of(grown[0])
    said: list[str] = []
    outcome = sweep(asked(0.25, 0.75), grown[0], watch=Watch(tell=said.append))
    assert outcome.done == (LOW, HIGH)
    assert said == []
    assert table_of(grown[0]) == before


@pytest.mark.thorough
def test_killed_it_goes_on_to_the_same_results(grown: tuple[Path, list[str], Outcome]) -> None:
    folder = grown[0].parent / "killed"
    assert (folder / "locks" / f"{HIGH}.lock").exists(), (
        "a file that nobody holds is in no one's way"
    )
    said: list[str] = []
    sweep(asked(0.25, 0.75), folder, watch=Watch(tell=said.append))
    assert said[0] == f"{HIGH}: training, from its last checkpoint"
    assert table_of(folder) == table_of(grown[0])


def test_what_another_process_runs_is_waited_for(
    grown: tuple[Path, list[str], Outcome], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(grown[0], tmp_path / "copy")
    folder = tmp_path / "copy"
    done = folder / "cells" / HIGH / "seed_1" / "evaluation.json"
    text = done.read_text()
    done.unlink()
    other = work.take_lock(folder, HIGH)
    assert other is not None
    assert work.run_cell(folder / "cells" / HIGH) == "running"
    monkeypatch.setattr("sjdsl.sweeps.running.PATIENCE", 0.0)
    said: list[str] = []

    def tell(line: str) -> None:
        said.append(line)
        done.write_text(text)  # the other process has done it
        other.release()

    outcome = sweep(asked(0.25, 0.75), folder, watch=Watch(tell=tell))
    assert outcome.done == (LOW, HIGH)
    assert len(said) == 1
    assert said[0] == f"{HIGH}: waiting for the process that runs it"


@pytest.mark.parametrize(
    "change",
    [
        {"seed": 0},
        {"summary": {}},
        {"summary": {"collective return": 3}},
        {"summary": {"collective return": {"mean": [1]}}},
    ],
)
def test_an_evaluation_of_something_else_is_not_taken_for_a_result(
    change: dict[str, Any], grown: tuple[Path, list[str], Outcome], tmp_path: Path
) -> None:
    """`sjdsl evaluate` writes the same file, with other episodes and another seed; and files can be damaged, or gone."""
    shutil.copytree(grown[0], tmp_path / "copy")
    folder = tmp_path / "copy" / "cells" / LOW / "seed_1"
    file = folder / "evaluation.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | change))
    (folder / "metrics.jsonl").unlink()
    assert sweep(asked(0.25, 0.75), tmp_path / "copy").done == (LOW, HIGH)
    assert table_of(tmp_path / "copy") == table_of(grown[0])


REFUSED: list[tuple[Any, str]] = [
    (
        asked(0.25, settings={"seeds": 3}),
        f"its cell {LOW} has config seeds 2 there, 3 here. Ask for other cells with all else as it was",
    ),
    (asked(0.25, settings={"learning_rate": 0.5}), "learning_rate 0.0005 there, 0.5 here"),
    (
        SweepSpec(
            [GAME], [Axis("exchange_ratio", (0.25,))], settings={**TINY, "reward": "exchange"}
        ),
        "episodes 3 there, 30 here",
    ),
    (asked(0.25, variant="chicken"), f"its cell {LOW} has hash"),
]


@pytest.mark.parametrize(
    ("other", "said"),
    REFUSED,
    ids=[f"{said[:30]} {other.axes and other.axes[0].values}" for other, said in REFUSED],
)
def test_another_sweep_is_refused(
    grown: tuple[Path, list[str], Outcome], other: SweepSpec, said: str
) -> None:
    before = (grown[0] / "sweep.json").read_bytes()
    with pytest.raises(ExperimentError, match="holds another sweep") as refused:
        sweep(other, grown[0])
    assert said in str(refused.value)
    assert (grown[0] / "sweep.json").read_bytes() == before


@pytest.fixture(scope="module")
def diverging(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[str], Outcome]:
    """Two cells, of which one has a learning rate that no network survives."""
    folder, lines = tmp_path_factory.mktemp("sweeps") / "diverging", list[str]()
    rates = SweepSpec(
        [GAME], [Axis("learning_rate", (1e-3, 1e38))], settings={**TINY, "seeds": 1}, episodes=2
    )
    with jax.debug_key_reuse(False):
        return folder, lines, sweep(rates, folder, watch=Watch(tell=lines.append))


GOOD, BAD = "matrix_game_learning_rate-0.001", "matrix_game_learning_rate-1e-38"


@pytest.mark.thorough
def test_a_cell_whose_loss_is_not_finite_has_failed(
    diverging: tuple[Path, list[str], Outcome],
) -> None:
    folder, lines, outcome = diverging
    assert lines[0] == f"{GOOD}: training"
    assert outcome.done == (GOOD,)
    ((bad, reason),) = outcome.failed.items()
    assert "the loss became nan in update" in reason
    assert [row["cell"] for row in rows_of(folder)] == [GOOD]
    assert states_of(folder) == {GOOD: "done", bad: "failed"}
    assert all(math.isfinite(float(row["collective_return"])) for row in rows_of(folder))


@pytest.mark.thorough
def test_failed_cells_stay_so_until_they_are_retried(
    diverging: tuple[Path, list[str], Outcome], monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = diverging[0]
    (bad,) = diverging[2].failed
    rates = SweepSpec(
        [GAME], [Axis("learning_rate", (1e-3, 1e38))], settings={**TINY, "seeds": 1}, episodes=2
    )
    trained: list[str] = []

    def full(*given: Any, **_: Any) -> None:
        trained.append(given[2].name)
        raise DiskError("no room")

    monkeypatch.setattr(work, "train", full)
    assert [*sweep(rates, folder).failed] == [bad]
    assert trained == []
    with pytest.raises(DiskError, match="no room"):
        sweep(rates, folder, again=True)
    assert trained == [bad]
    assert (folder / "failed" / f"{bad}_1" / "manifest.json").is_file(), (
        "what it had written is put aside"
    )
    assert not (folder / "cells" / bad).exists()
    assert states_of(folder)[GOOD] == "done"

    def wrong(*_: Any, **__: Any) -> None:
        raise ZeroDivisionError("in a reward of one's own")

    monkeypatch.setattr(work, "train", wrong)
    assert sweep(rates, folder).failed == {bad: "ZeroDivisionError: in a reward of one's own"}


@pytest.mark.thorough
def test_a_folder_that_is_half_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def nothing(*_: Any, **__: Any) -> None:
        raise DiskError("no room")

    monkeypatch.setattr(work, "train", nothing)
    with pytest.raises(DiskError):
        sweep(asked(0.25), tmp_path / "sweep")
    cell = tmp_path / "sweep" / "cells" / LOW
    cell.mkdir()
    (cell / "start.json").write_text("{}")
    with pytest.raises(DiskError):
        sweep(asked(0.25), tmp_path / "sweep")
    assert not (cell / "start.json").exists(), "a run that was stopped before it began"
    (cell / "policies").mkdir()
    failed = sweep(asked(0.25), tmp_path / "sweep").failed
    assert "holds policies but no manifest.json" in failed[LOW]
    with pytest.raises(DiskError):
        sweep(asked(0.25), tmp_path / "sweep", again=True)
    assert (tmp_path / "sweep" / "failed" / f"{LOW}_1" / "policies").is_dir()
    (cell / "policies").mkdir(parents=True)
    (cell / "manifest.json").write_text("{")
    assert "manifest.json" in sweep(asked(0.25), tmp_path / "sweep").failed[LOW]
    with pytest.raises(DiskError):
        sweep(asked(0.25), tmp_path / "sweep", again=True)
    assert (tmp_path / "sweep" / "failed" / f"{LOW}_2" / "manifest.json").is_file(), (
        "one that cannot be read is put aside, too"
    )


def test_an_interrupted_cell_is_run_by_nobody(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: Any, **__: Any) -> None:
        assert states_of(tmp_path / "sweep")[LOW] == "running"
        raise KeyboardInterrupt

    monkeypatch.setattr(work, "train", interrupted)
    with pytest.raises(KeyboardInterrupt):
        sweep(asked(0.25), tmp_path / "sweep")
    assert states_of(tmp_path / "sweep")[LOW] == "waiting"


def finish(path: Path, seeds: range) -> None:
    """Writes what is read of a run that is done."""
    for seed in seeds:
        own = path / f"seed_{seed}"
        own.mkdir(parents=True)
        (own / "metrics.jsonl").write_text('{"update": 4, "env_steps": 64, "seconds": 1.5}\n')
        summary = {"collective return": {"mean": float(seed), "low": 0.0, "high": None}}
        asked = {"policy": "last", "update": 4, "seed": seed, "greedy": None, "episodes": 2}
        (own / "evaluation.json").write_text(json.dumps({**asked, "summary": summary}))
    (path / "manifest.json").write_text(
        json.dumps({"game": {}, "config": {}, "versions": {}, "status": "finished", "updates": 4})
    )


@pytest.mark.thorough
def test_a_cell_that_does_not_fit_into_memory_has_failed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def train(_: Any, config: Any, run_dir: Path, *__: Any, **___: Any) -> None:
        if config.learning_rate == 0.2:
            raise RunError("an update needs more")
        finish(run_dir, range(2))

    monkeypatch.setattr(work, "train", train)
    rates = SweepSpec(
        [GAME], [Axis("learning_rate", (0.1, 0.2, 0.3, 0.4, 0.5))], settings=TINY, episodes=2
    )
    outcome = sweep(rates, tmp_path / "sweep")
    assert outcome.failed == {"matrix_game_learning_rate-0.2": "an update needs more"}
    assert len(outcome.done) == 4
