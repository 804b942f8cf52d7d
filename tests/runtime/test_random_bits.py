"""Random words and what is made of them, against whole-number arithmetic."""

from fractions import Fraction

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.runtime.random_bits import (
    below,
    next_threshold,
    random_bits,
    random_bits_at,
    ranks,
    threshold,
)

from . import references

LAST = 2**32 - 1
EDGES = [0, 1, 2, 3, 2**16 - 1, 2**16, 2**31 - 1, 2**31, 2**31 + 1, LAST - 1, LAST]
# (key, counter, both outputs): threefry2x32 with 13 rounds. Source: Random123 1.14, kat_vectors
VECTORS = [
    ((0, 0), (0, 0), (0x9D1C5EC6, 0x8BD50731)),
    ((LAST, LAST), (LAST, LAST), (0xFD36D048, 0x2D17272C)),
    ((0x13198A2E, 0x03707344), (0x243F6A88, 0x85A308D3), (0xBA3E4725, 0xF27D669E)),
]


def some_words(number: int, seed: int = 0) -> list[int]:
    return [*EDGES, *np.random.default_rng(seed).integers(0, 2**32, number).tolist()]


def key_of(key: tuple[int, int]) -> jax.Array:
    return jnp.array(key, jnp.uint32)


@pytest.mark.parametrize(("key", "counter", "output"), VECTORS)
def test_published_vectors(
    key: tuple[int, int], counter: tuple[int, int], output: tuple[int, int]
) -> None:
    assert references.threefry(key, counter) == output
    if counter[1] < 2**31:  # word numbers are 32 bits
        numbers = jnp.array([2 * counter[1], 2 * counter[1] + 1], jnp.uint32)
        assert random_bits_at(key_of(key), counter[0], numbers).tolist() == list(output)


def test_words_are_threefry_of_stream_and_number() -> None:
    random = np.random.default_rng(1)
    for _ in range(20):
        key = tuple(random.integers(0, 2**32, 2).tolist())
        stream = int(random.choice([0, 1, LAST, *random.integers(0, 2**32, 3)]))
        numbers = np.array([0, 1, LAST, *random.integers(0, 2**32, 20)], np.uint32)
        expected = [references.threefry(key, (stream, int(n) // 2))[int(n) % 2] for n in numbers]
        assert random_bits_at(key_of(key), stream, jnp.asarray(numbers)).tolist() == expected


def test_words_are_numbered_in_row_major_order() -> None:
    key = key_of((3, 4))
    line = random_bits(key, 77, 24)
    assert line.dtype == jnp.uint32
    assert line.tolist() == [references.threefry((3, 4), (77, i // 2))[i % 2] for i in range(24)]
    np.testing.assert_array_equal(random_bits(key, 77, 2, 3, 4), line.reshape(2, 3, 4))
    np.testing.assert_array_equal(
        random_bits(key, 77, 7), line[:7]
    )  # how many are drawn changes none
    assert random_bits(key, 77).shape == ()
    assert int(random_bits(key, 77)) == int(line[0])


def test_words_of_a_batch_of_keys() -> None:
    keys = jax.random.bits(jax.random.key(0), (5, 2), jnp.uint32)
    batch = jax.vmap(lambda k: random_bits(k, 9, 6))(keys)
    assert batch.tolist() == [
        [references.threefry(tuple(k), (9, i // 2))[i % 2] for i in range(6)] for k in keys.tolist()
    ]


def probabilities() -> list[float]:
    edges = [0.0, 1.0, 0.5, 1 - 2**-24, 2**-24, 2**-31, 0.1, 0.001, 0.0005, 0.025, 1 / 3]
    return [
        *edges,
        *np.random.default_rng(2).random(500).tolist(),
        *(10 ** np.random.default_rng(3).uniform(-9, 0, 500)).tolist(),
    ]


def exact(p: np.float32) -> Fraction:
    return Fraction(float(p))


def test_threshold_is_exact() -> None:
    p = np.array(probabilities(), np.float32)
    found = threshold(jnp.asarray(p))
    assert found.dtype == jnp.uint32
    assert found.tolist() == [int(exact(x) * 2**31) for x in p]


def test_never_and_always() -> None:
    """A chance of 0 happens for no word at all, one of 1 for every word."""
    upper = jnp.array(some_words(50), jnp.uint32) >> 1
    assert not (upper < threshold(jnp.float32(0))).any()
    assert (upper < threshold(jnp.float32(1))).all()
    assert int(threshold(jnp.float32(1))) == 2**31


def test_next_threshold_is_exact() -> None:
    """The float32 products of the manual, in whole numbers: T2 = T1 + trunc(float32(2^31 - T1) * q)."""
    random = np.random.default_rng(4)
    p, q = (
        np.array(probabilities(), np.float32),
        np.array(random.permutation(probabilities()), np.float32),
    )
    before = threshold(jnp.asarray(p))
    expected = []
    for t, x in zip(before.tolist(), q, strict=True):
        product = references.float32(references.float32(Fraction(2**31 - t)) * exact(x))
        expected.append(t + int(product))
    found = next_threshold(before, jnp.asarray(q))
    assert found.dtype == jnp.uint32
    assert found.tolist() == expected
    assert (np.asarray(found) >= np.asarray(before)).all()


def test_a_chain_that_ends_with_certainty_leaves_nothing() -> None:
    """After `chance p`, `otherwise chance 1` takes all the rest: at most 2^-24 of it is lost to rounding."""
    before = threshold(jnp.array(probabilities(), jnp.float32))
    last = np.asarray(next_threshold(before, jnp.ones(before.shape, jnp.float32))).astype(np.int64)
    assert (np.abs(2**31 - last) <= 64).all()
    assert int(next_threshold(jnp.uint32(0), jnp.float32(1))) == 2**31
    assert int(next_threshold(jnp.uint32(2**31), jnp.float32(1))) == 2**31
    assert int(next_threshold(jnp.uint32(2**30), jnp.float32(0))) == 2**30


@pytest.mark.parametrize("bound", [1, 2, 3, 4, 7, 91, 255, 256, 257, 40_000, 65_534, 65_535])
def test_below_is_the_exact_share(bound: int) -> None:
    w = some_words(2000, bound)
    w += [
        k * 2**32 // bound + d for k in range(1, min(bound, 40)) for d in (-1, 0, 1)
    ]  # beside the steps
    found = below(jnp.array(w, jnp.uint32), bound)
    assert found.dtype == jnp.int32
    assert found.tolist() == [x * bound // 2**32 for x in w]


def test_below_with_a_bound_for_each_word() -> None:
    random = np.random.default_rng(5)
    w, bounds = random.integers(0, 2**32, 500), random.integers(1, 65_536, 500)
    found = below(jnp.asarray(w, jnp.uint32), jnp.asarray(bounds, jnp.int32))
    assert found.tolist() == [int(x) * int(n) // 2**32 for x, n in zip(w, bounds, strict=True)]


def test_ranks_order_members_by_their_upper_bits() -> None:
    """Members have a rank above 0 whatever their word; two words that differ in the lowest bit are equal."""
    w = jnp.array([0, 1, 2, 3, LAST, LAST - 1], jnp.uint32)
    assert ranks(w, jnp.ones(6, bool)).tolist() == [1, 1, 2, 2, 2**31, 2**31]
    assert ranks(w, jnp.array([True, False] * 3)).tolist() == [1, 0, 2, 0, 2**31, 0]
