"""Tests of kernels run under strict JAX, and in both forms where they ask for it."""

from collections.abc import Iterator

import pytest

from sjdsl.runtime.forms import forced


@pytest.fixture(autouse=True)
def strict(strict_jax: None) -> None:
    """Applies `strict_jax` to every test of this folder."""


@pytest.fixture(params=["cpu", "gpu"])
def form(request: pytest.FixtureRequest) -> Iterator[None]:
    """Runs a test in both forms of the kernels."""
    with forced(request.param):
        yield
