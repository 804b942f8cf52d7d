"""Tests of compiled games run under strict JAX."""

import pytest


@pytest.fixture(autouse=True)
def strict(strict_jax: None) -> None:
    """Applies `strict_jax` to every test of this folder."""
