"""Stages, memory and takeovers of sweeps, with cells that are not trained but written as if they had been."""

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from sjdsl.sweeps import running, work
from sjdsl.sweeps.axes import Axis
from sjdsl.sweeps.cells import SweepSpec
from sjdsl.sweeps.folder import cells_of, read_sweep, record_failure
from sjdsl.sweeps.running import Outcome, sweep
from sjdsl.sweeps.work import Watch
from sjdsl.trainers.run_errors import RunError
from tests.sweeps.described import GAME, TINY

ASKED = SweepSpec([GAME], (), "svo", {**TINY, "seed": 4}, episodes=2)


def finish(path: Path, seeds: range, earned: Callable[[int], float]) -> None:
    """Writes what is read of a run that is done; `earned`: the collective return of a seed."""
    for seed in seeds:
        own = path / f"seed_{seed}"
        own.mkdir(parents=True)
        (own / "metrics.jsonl").write_text('{"update": 4, "env_steps": 64, "seconds": 1.5}\n')
        summary = {"collective return": {"mean": earned(seed), "low": 0.0, "high": None}}
        asked = {"policy": "last", "seed": seed, "greedy": None, "episodes": 2}
        (own / "evaluation.json").write_text(json.dumps({**asked, "summary": summary}))
    (path / "manifest.json").write_text(json.dumps({"game": {}, "config": {}, "versions": {}, "status": "finished", "updates": 4}))


def run_with(earned: Callable[[Any, int], float], fails: Callable[[Any], bool], folder: Path) -> tuple[Outcome, list[str]]:
    """Runs the sweep with cells that earn what `earned` says of a cell and a seed."""
    said: list[str] = []

    def run(path: Path, _: Watch) -> None:
        cell = next(cell for cell in cells_of(read_sweep(folder)) if cell.name == path.name)
        if fails(cell):
            record_failure(folder, cell, "it had to")
        else:
            finish(path, cell.seeds, lambda seed: earned(cell, seed))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(running, "run_cell", run)
        patch.setattr(running, "check_cells", lambda _: None)
        return sweep(ASKED, folder, watch=Watch(tell=said.append)), said


def test_angles_at_the_best_weight_with_other_seeds(tmp_path: Path) -> None:
    """Weight 0.4 has the best mean, 0.8 the best seed."""
    means = {0.4: (5.0, 5.0), 0.8: (9.0, 0.0)}
    outcome, said = run_with(lambda cell, seed: means.get(cell.values["svo_weight"], (1.0, 1.0))[seed % 2], lambda _: False, tmp_path)
    assert outcome.complete
    assert said == ["second stage of matrix_game: weight 0.4 was best, seeds 6 to 7"]
    assert len(outcome.done) == 6 + 5
    rows = [*csv.DictReader((tmp_path / "results.csv").read_text().splitlines())]
    first, second = ([row for row in rows if row["stage"] == stage] for stage in "12")
    assert [row["point"] for row in first[::2]] == ["0", "0.2", "0.4", "0.6", "0.8", "1"]
    assert [(row["point"], row["svo_angle"], row["svo_weight"]) for row in second[::2]] == [
        (angle, angle, "0.4") for angle in ("0", "22.5", "45", "67.5", "90")
    ]
    assert {row["seed"] for row in first} == {"4", "5"}
    assert {row["seed"] for row in second} == {"6", "7"}
    known = json.loads((tmp_path / "sweep.json").read_text())
    assert sum(cell["stage"] == 2 for cell in known["cells"].values()) == 5
    assert run_with(lambda *_: 0.0, lambda _: True, tmp_path)[0].done == outcome.done, "nothing is run again"


def test_no_second_stage_while_a_cell_of_the_first_has_failed(tmp_path: Path) -> None:
    """The best of the others would be no choice among all."""
    outcome, said = run_with(lambda *_: 1.0, lambda cell: cell.values["svo_weight"] == 0.6, tmp_path)
    assert not outcome.complete
    assert len(outcome.done) == 5
    assert outcome.failed == {"matrix_game_reward-svo_svo_weight-0.6_svo_angle-90": "it had to"}
    assert said == ["the second stage begins when every cell of the first is done"]
    assert len((tmp_path / "results.csv").read_text().splitlines()) == 1 + 10


RATES = SweepSpec([GAME], [Axis("learning_rate", (0.1, 0.2, 0.3, 0.4, 0.5))], settings=TINY, episodes=2)


@pytest.mark.thorough
def test_a_cell_that_does_not_fit_into_memory_has_failed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def train(_: Any, config: Any, run_dir: Path, *__: Any) -> None:
        if config.learning_rate == 0.2:
            raise RunError("an update needs more")
        finish(run_dir, range(2), float)

    monkeypatch.setattr(work, "train", train)
    outcome = sweep(RATES, tmp_path / "sweep")
    assert outcome.failed == {"matrix_game_learning_rate-0.2": "an update needs more"}
    assert len(outcome.done) == 4
