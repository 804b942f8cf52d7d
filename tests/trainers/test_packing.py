"""Packed observations: nothing is lost, and no byte is wasted that a plane does not need."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.runtime.planes import TokenPlane
from sjdsl.trainers.networks.packing import bits_of, make_packing

WORDS_6 = TokenPlane("six", "word", tuple("abcdef"))
WORDS_2 = TokenPlane("two", "word", tuple("ab"))
WORDS_9 = TokenPlane("nine", "word", tuple("abcdefghi"))
BITS_3 = TokenPlane("marks", "bits", tuple("abc"), high=7)
NUMBER_255 = TokenPlane("count", "number", high=255)
NUMBER_15 = TokenPlane("bag", "number", high=15)
OWN_15 = TokenPlane("own bag", "number", high=15, uniform=True)
OWN_9 = TokenPlane("own nine", "word", tuple("abcdefghi"), uniform=True)


@pytest.mark.parametrize(
    ("plane", "bits"),
    [(WORDS_6, 3), (WORDS_2, 1), (WORDS_9, 4), (BITS_3, 3), (NUMBER_255, 8), (NUMBER_15, 4)],
)
def test_a_plane_takes_as_many_bits_as_its_largest_value(plane: TokenPlane, bits: int) -> None:
    assert bits_of(plane) == bits


@pytest.mark.parametrize(
    ("planes", "size"),
    [
        ((WORDS_6,), 15),
        ((WORDS_6, BITS_3, WORDS_2), 15),  # 3 + 3 + 1
        ((WORDS_9, WORDS_6, BITS_3), 30),  # 4 + 3, 3
        ((NUMBER_255, WORDS_2, NUMBER_255), 45),
        ((WORDS_6, NUMBER_255, WORDS_6, WORDS_2), 30),  # the last two join the first
        ((OWN_15, WORDS_6, OWN_9, BITS_3, OWN_15), 17),  # 3 + 3; once 4 + 4, 4
    ],
)
def test_values_come_back(planes: tuple[TokenPlane, ...], size: int) -> None:
    packing = make_packing(planes, (5, 3))
    assert packing.size == size
    random = np.random.default_rng(0)
    highest = [2 ** bits_of(plane) - 1 for plane in planes]
    values = np.stack(
        [random.integers(0, high, (4, 2, 5, 3), endpoint=True) for high in highest], axis=2
    ).astype(np.uint8)
    for index, high in enumerate(highest):
        values[0, 0, index, 0, 0] = high
        if planes[index].uniform:
            values[:, :, index] = values[:, :, index, :1, :1]
    packed = jax.jit(packing.pack)(jnp.asarray(values))
    assert packed.shape == (4, 2, size)
    assert packed.dtype == jnp.uint8
    np.testing.assert_array_equal(jax.jit(packing.unpack)(packed), values)
