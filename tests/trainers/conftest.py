"""Trainer tests run with JAX's check that no key is used twice, and runs leave an empty picture where they would draw a curve."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import jax
import pytest
from probes import matching
from run_outcomes import SHORT, compiled_once

from sjdsl.trainers import train
from sjdsl.trainers.runs import recorder
from sjdsl.trainers.runs.learning_curve import LEARNING_CURVE, curve_panels
from sjdsl.trainers.runs.metrics_files import Row


@pytest.fixture(autouse=True)
def check_key_reuse() -> Iterator[None]:
    """Makes JAX raise wherever a typed key is consumed twice."""
    with jax.debug_key_reuse(True):
        yield


def _leave_empty(folder: Path, rows: Sequence[Row], title: str) -> None:
    """Stands in for the drawing of a curve, which takes longer than a short run; `test_train_run.py` has it drawn."""
    del title
    if curve_panels(rows):
        (folder / LEARNING_CURVE).touch()


@pytest.fixture(scope="session", autouse=True)
def empty_curves() -> Iterator[None]:
    """Has runs leave an empty file for a learning curve, where they would have drawn one."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(recorder, "draw_learning_curve", _leave_empty)
        yield


@pytest.fixture(scope="module")
def shared() -> Iterator[None]:
    """Has the runs of a module share what is compiled."""
    with (
        compiled_once(),
        jax.debug_key_reuse(True),
    ):  # as in the tests: otherwise programs are traced again
        yield


@pytest.fixture(scope="module")
def whole(shared: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run that nothing stopped."""
    del shared
    return train(matching(), SHORT, tmp_path_factory.mktemp("runs") / "whole", "none").run_dir
