"""Experiments are tested with JAX's check that no key is used twice; the games are small, and nobody moves in them."""

from collections.abc import Iterator

import jax
import pytest


@pytest.fixture(autouse=True)
def check_key_reuse() -> Iterator[None]:
    """Makes JAX raise wherever a typed key is consumed twice."""
    with jax.debug_key_reuse(True):
        yield
