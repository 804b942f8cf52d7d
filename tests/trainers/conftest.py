"""Trainer tests run with JAX's check that no key is used twice, and runs leave an empty picture where they would draw a curve."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import jax
import pytest

from sjdsl.trainers import recorder
from sjdsl.trainers.learning_curve import LEARNING_CURVE, curve_panels
from sjdsl.trainers.metrics_files import Row


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
