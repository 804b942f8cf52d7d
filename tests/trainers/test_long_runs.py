"""Runs of very many updates: what they write is bounded by time and size, what they remember does not grow."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest
from probes import matching
from run_outcomes import read_lines

import sjdsl
from sjdsl.trainers import Config, load_preset, make_config, make_train
from sjdsl.trainers.algorithms.training_functions import TrainState
from sjdsl.trainers.runs import updates
from sjdsl.trainers.runs.checkpoint_pace import CheckpointPace
from sjdsl.trainers.runs.compiled import Compiled
from sjdsl.trainers.runs.metrics_files import read_rows, thinned_rows
from sjdsl.trainers.runs.recorder import open_recorders
from sjdsl.trainers.runs.run_stage import RunStage

MINUTE = 60.0


@pytest.fixture(scope="module")
def paper() -> Config:
    return load_preset("paper", {"algorithm": "vdn"}, "coins").config


@pytest.fixture(scope="module")
def num_bytes(paper: Config) -> int:
    """What a checkpoint of VDN in Coins has to write: shapes alone, nothing is computed."""
    program = make_train(sjdsl.make("coins"), paper)
    state = jax.eval_shape(program.init, jax.eval_shape(lambda: jax.random.key(0)))
    return sum(leaf.size * leaf.dtype.itemsize for leaf in jax.tree.leaves(state))


def _count(
    config: Config, num_bytes: float, seconds_an_update: float, bytes_a_second: float
) -> tuple[int, float, float]:
    """Plays a run on a clock that only stands for one; returns checkpoints, seconds spent writing, and seconds in all."""
    now = writing = 0.0
    number = 0
    pace = CheckpointPace(config, now)
    for update in range(1, config.num_updates + 1):
        now += seconds_an_update
        if pace.is_due(update, now):
            began, now = now, now + num_bytes / bytes_a_second
            pace.written(began, now)
            writing += now - began
            number += 1
    return number, writing, now


@pytest.mark.parametrize("bytes_a_second", [50e6, 500e6, 5e9])
@pytest.mark.parametrize("seconds_an_update", [0.003, 0.03])
def test_vdn_of_the_paper_writes_few_checkpoints(
    paper: Config, num_bytes: int, seconds_an_update: float, bytes_a_second: float
) -> None:
    """156,250 updates; one every 50 would have been 3,125 copies of the replay buffer, hundreds of gigabytes."""
    assert paper.num_updates == 156_250
    assert num_bytes > 30e6, "the replay buffer is in it"
    number, writing, seconds = _count(paper, num_bytes, seconds_an_update, bytes_a_second)
    assert number <= seconds / (10 * MINUTE)
    assert number >= seconds // (20 * MINUTE), "and no more than twenty minutes are lost"
    assert writing <= 0.05 * seconds


def test_a_checkpoint_waits_for_its_share_of_the_time() -> None:
    pace = CheckpointPace(make_config(checkpoint_minutes=1, checkpoint_share=0.1), 0.0)
    assert (pace.is_due(1, 59.0), pace.is_due(1, 60.0)) == (False, True)
    pace.written(60.0, 70.0)
    assert pace.interval == pytest.approx(90.0)


# the loop itself, on a clock that moves when it is told to


class _Clock:
    """Seconds that pass only in updates and checkpoints."""

    def __init__(self) -> None:
        self.now = 0.0

    def perf_counter(self) -> float:
        return self.now


def _play(
    folder: Path,
    config: Config,
    monkeypatch: pytest.MonkeyPatch,
    seconds_an_update: float,
    seconds_a_checkpoint: float,
) -> list[int]:
    """Runs the updates of a run that computes nothing; returns after which of them it wrote a checkpoint."""
    clock, written = _Clock(), []
    monkeypatch.setattr(updates, "time", clock)
    parameters = {"weight": np.zeros(3, np.float32)}
    metrics = {"episodes": 1, "collective_return": 2.0, "agent_return": np.ones(2), "loss": 1.0}

    def collect(state: TrainState) -> tuple[TrainState, Any]:
        clock.now += seconds_an_update
        return state, ()

    def save(number: int, _: Any) -> None:
        clock.now += seconds_a_checkpoint
        written.append(number)

    compiled = Compiled(
        None, collect, lambda state, _: (state, metrics), lambda _: parameters, None, 0.0, 0.0
    )  # type: ignore[arg-type]
    state: Any = {"replay": np.zeros(10)}
    stage = RunStage(matching(), config, folder, {"loggers": ()})
    with open_recorders(stage, 0) as recorders:
        updates.Loop(stage, compiled, state, recorders, save, lambda *_: None).run()
    return written


def test_the_loop_keeps_to_the_pace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """2,000 updates of a second, checkpoints that take 20: every 380 seconds; and one at the end. The last three policies stay."""
    config = make_config(
        algorithm="vdn",
        total_timesteps=2000 * 32,
        buffer_size=32,
        keep_policies=3,
        checkpoint_minutes=1,
    )
    written = _play(tmp_path, config, monkeypatch, 1.0, 20.0)
    assert written == [60, 440, 820, 1200, 1580, 1960, 2000]
    names = {path.stem for path in (tmp_path / "policies").iterdir()}
    assert names == {"00001800", "00001900", "00002000", "last", "best"}
    assert len(read_lines(tmp_path / "metrics.jsonl")) == 2000


# rows on disk


@pytest.fixture
def rows_on_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    _play(
        tmp_path,
        make_config(algorithm="vdn", total_timesteps=50 * 32, buffer_size=32),
        monkeypatch,
        1.0,
        0.0,
    )
    return tmp_path


def test_a_curve_has_no_more_points_than_can_be_seen(rows_on_disk: Path) -> None:
    rows = list(read_rows(rows_on_disk / "metrics.jsonl"))
    assert thinned_rows(rows_on_disk, 50) == rows
    thinned = thinned_rows(rows_on_disk, 10)
    assert [row["env_steps"] for row in thinned] == [
        np.mean([row["env_steps"] for row in rows[at : at + 5]]) for at in range(0, 50, 5)
    ]
