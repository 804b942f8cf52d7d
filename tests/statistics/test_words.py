"""The words of all rules of the nine games: no bit leans to a side, and none tells of any other bit of any other rule, number or key.

Sums of n signs are held against Hoeffding's bound, P(|sum| >= t) <= 2 exp(-t^2 / 2n), which is exact for independent fair bits.
"""

from functools import cache

import jax
import jax.numpy as jnp
import numpy as np

from sjdsl.runtime.random_bits import random_bits, random_bits_at
from tests.games.environments import NINE
from tests.laws.corpus import game_of
from tests.laws.streams import streams

FALSE_ALARM = 1e-6
KEYS = 4096


@cache
def all_streams() -> tuple[int, ...]:
    """Returns the streams of the nine games, those of agents who come back among them."""
    return tuple(sorted({stream for name in NINE for stream in streams(game_of(name))}))


def bound(trials: int, sums: int) -> float:
    """Returns what none of so many sums of signs reaches, but for a false alarm."""
    return float(np.sqrt(2 * trials * np.log(2 * sums / FALSE_ALARM)))


def signs(found: np.ndarray) -> np.ndarray:
    """Returns the bits of words as +1 and -1: `[..., n]` -> `[..., 32, n]`."""
    bits = found[..., None, :] >> np.arange(32, dtype=np.uint32)[:, None] & np.uint32(1)
    return 2 * bits.astype(np.float32) - 1


@cache
def first_words() -> np.ndarray:
    """Returns the first word of each stream under keys in a row, `[S, KEYS]`."""
    keys = jax.random.key_data(jax.vmap(jax.random.key)(jnp.arange(KEYS)))
    number = jnp.zeros((), jnp.uint32)
    return np.asarray(
        jax.vmap(lambda s: jax.vmap(lambda k: random_bits_at(k, s, number))(keys))(
            jnp.asarray(all_streams(), jnp.uint32)
        )
    )


def test_no_bit_leans() -> None:
    sums = signs(first_words()).sum(axis=-1)
    assert sums.size >= 32 * 50
    assert np.abs(sums).max() < bound(KEYS, sums.size)
    assert bound(KEYS, sums.size) < 0.11 * KEYS


def test_bits_of_all_rules_are_pairwise_independent() -> None:
    """Every bit of every stream with every bit of every other, and of its own word."""
    rows = signs(first_words()).reshape(-1, KEYS)
    together = np.abs(rows @ rows.T)
    np.fill_diagonal(together, 0)
    pairs = rows.shape[0] * (rows.shape[0] - 1) // 2
    assert together.max() < bound(KEYS, pairs)
    assert bound(KEYS, pairs) < 0.13 * KEYS


def test_bits_of_neighbouring_numbers_and_keys_are_independent() -> None:
    """Numbers under one key, as the instances of a rule have them; keys in a row."""
    number = 2**14
    instances = np.stack(
        [
            np.asarray(random_bits(jnp.array([0, 7], jnp.uint32), stream, number))
            for stream in all_streams()[::4]
        ]
    )
    for found in (instances, first_words()):
        rows = signs(found)
        together = np.abs(np.einsum("sin,sjn->sij", rows[..., :-1], rows[..., 1:], optimize=True))
        assert together.max() < bound(found.shape[-1] - 1, together.size)
