"""Random draws: a counter-based generator (threefry) with one stream a rule, and distributions.

Random number i of a stream is output i mod 2 of threefry-2x32 with 13 rounds on the counter
(stream, i div 2) under the step's key. It doesn't depend on other rules, on the order of
evaluation, or on how many others draw.
Source: Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC 2011; 13 rounds are the
fewest that pass BigCrush there (table 2).
"""

import math
from functools import partial

import jax
import jax.numpy as jnp
from jax import Array, lax

from sjdsl.runtime.forms import one_function
from sjdsl.runtime.varying import settled

_ROTATIONS = (13, 15, 26, 6, 17, 29, 16, 24)
ROUNDS = 13
MOST_UNROLLED = 8  # entries of a deal: with 20 XLA took 3 seconds to compile it
_PARITY = 0x1BD11BDA


def key_words(key: Array) -> Array:
    """Returns the `[2]` uint32 words of a key, typed or old style.

    Those of a generator other than threefry are drawn from it.

    Raises:
      TypeError: it isn't an array.
      ValueError: it is another array, or several keys.
    """
    expected = "a key is a typed key (jax.random.key) or two uint32 words"
    if not hasattr(key, "dtype"):
        raise TypeError(f"{expected}, not {key!r:.60}")
    is_typed = jnp.issubdtype(key.dtype, jax.dtypes.prng_key)
    shape = () if is_typed else (2,)
    if key.shape != shape or not (is_typed or key.dtype == jnp.uint32):
        is_batch = key.ndim > len(shape)
        hint = "; for a batch of environments, jax.vmap the call" if is_batch else ""
        raise ValueError(f"{expected}, not {key.dtype}{list(key.shape)}{hint}")
    if not is_typed:
        return key
    if jax.random.key_impl(key) == "threefry2x32":
        return jax.random.key_data(key)
    return jax.random.bits(key, (2,), jnp.uint32)


def random_bits_at(key: Array, stream: int | Array, numbers: Array) -> Array:
    """Returns the 32-bit random numbers of a stream with the given indices.

    Args:
      key: `[2]` uint32.
      stream: the rule's stream, 0 .. 2^32 - 1.
      numbers: any shape, uint32.
    Returns:
      uint32 of the shape of `numbers`.
    """
    return _numbered(key, jnp.uint32(stream), numbers)


@one_function
def _numbered(key: Array, stream: Array, numbers: Array) -> Array:
    """Returns `random_bits_at`: a block has two numbers, the even and the odd one."""
    first, second = _threefry(key, stream, numbers >> 1)
    return jnp.where((numbers & 1) == 0, first, second)


def _threefry(key: Array, stream: Array, numbers: Array) -> tuple[Array, Array]:
    """Returns the two words of threefry-2x32 for each number in a stream, uint32."""
    shape = (1,) * numbers.ndim
    k0, k1 = (word.reshape(shape) for word in jnp.split(key, 2))
    keys = (k0, k1, k0 ^ k1 ^ jnp.uint32(_PARITY))
    # x0 is as wide as x1, so that all rounds are one function of the program.
    x0 = jnp.broadcast_to(stream + keys[0], numbers.shape)
    x1 = numbers + keys[1]
    for turn in range(ROUNDS):
        x0, x1 = _mixed(x0, x1, jnp.uint32(_ROTATIONS[turn % 8]))
        if turn % 4 == 3:
            group = turn // 4
            x0 = x0 + keys[(group + 1) % 3]
            x1 = x1 + keys[(group + 2) % 3] + jnp.uint32(group + 1)
    return x0, x1


@one_function
def _mixed(x0: Array, x1: Array, rotation: Array) -> tuple[Array, Array]:
    """Returns the words after one round of threefry: an addition, a rotation, an exclusive or."""
    x0 = x0 + x1
    return x0, x0 ^ (x1 << rotation | x1 >> (jnp.uint32(32) - rotation))


def random_bits(key: Array, stream: int, *shape: int) -> Array:
    """Returns the first random numbers of a stream, `shape` uint32, numbered in row-major order.

    Each block is computed twice, once for each of its two numbers. It then fuses with the
    operations on the numbers, which costs less than interleaving pairs.
    """
    numbers = jnp.arange(math.prod(shape), dtype=jnp.uint32).reshape(shape)
    return random_bits_at(key, stream, numbers)


def threshold(probability: Array) -> Array:
    """Returns the uint32 below which the upper 31 bits of a random number lie with a probability.

    Args:
      probability: float32 in 0 .. 1.
    """
    result: Array = (probability * jnp.float32(2**31)).astype(jnp.uint32)
    return result


def next_threshold(before: Array, probability: Array) -> Array:
    """Returns the threshold of the next branch of a chain, which has a share of what is left.

    Args:
      before: the threshold of the branch before.
      probability: the share, float32 in 0 .. 1.
    """
    left = (jnp.uint32(2**31) - before).astype(jnp.float32)
    result: Array = before + (left * probability).astype(jnp.uint32)
    return result


@one_function
def below(draw: Array, bound: Array | int) -> Array:
    """Returns floor(draw * bound / 2^32), int32: a random number below the bound.

    Args:
      draw: any shape, uint32. bound: at most 65,535, so that no product leaves 32 bits.
    """
    n = jnp.asarray(bound, jnp.uint32)
    upper_half = draw >> 16
    lower_half = draw & 0xFFFF
    upper = upper_half * n
    carried = (lower_half * n) >> 16
    return ((upper + carried) >> 16).astype(jnp.int32)


def dealt_values(draws: Array, number: int) -> Array:
    """Returns different whole numbers below `number`, as many as there are draws: int32.

    It is a Fisher-Yates shuffle of the list 0 .. number - 1, of which the first entries are kept:
    entry i is swapped with the entry at place i + floor(draw * (number - i) / 2^32).

    Few swaps are followed one by one, without a list: the time to compile that grows with the
    square of their number.

    Args:
      draws: `[..., K]` uint32, random.
    """
    count = draws.shape[-1]
    if count > MOST_UNROLLED:
        return _dealt_in_a_loop(draws, number)
    places = [entry + below(draws[..., entry], number - entry) for entry in range(count)]
    moved: list[Array] = []  # what stood at place i when entry i was drawn
    dealt = []
    for entry, place in enumerate(places):
        at_entry = jnp.full_like(place, entry)
        at_place = place
        for earlier_place, content in zip(places, moved, strict=False):
            at_entry = jnp.where(earlier_place == entry, content, at_entry)
            at_place = jnp.where(earlier_place == place, content, at_place)
        moved.append(at_entry)
        dealt.append(at_place)
    return jnp.stack(dealt, axis=-1)


def _dealt_in_a_loop(draws: Array, number: int) -> Array:
    """Returns what `dealt_values` does, by a loop over the entries."""
    count = draws.shape[-1]
    places = jnp.broadcast_to(jnp.arange(number), (*draws.shape[:-1], number))

    def swap(entry: Array | int, values: Array) -> Array:
        """Returns the list after the swap of one entry: `[..., number]`."""
        place = entry + below(draws[..., entry], number - entry)
        place = place[..., None]
        at_place = jnp.take_along_axis(values, place, axis=-1)
        at_entry = values[..., entry][..., None]
        values = jnp.where(places == place, at_entry, values)
        return jnp.where(places == entry, at_place, values)

    values: Array = lax.fori_loop(0, count, swap, settled(partial(swap, 0), places))
    return values[..., :count]


def unit(draw: Array) -> Array:
    """Returns the upper 24 bits of random numbers as float32 in [0, 1): exact, equally likely."""
    result: Array = (draw >> 8).astype(jnp.float32) * jnp.float32(2.0**-24)
    return result


def ranks(draw: Array, member: Array) -> Array:
    """Returns a random rank from 1 to 2^31 for each member, 0 for those that are none: uint32."""
    return jnp.where(member, (draw >> 1) + 1, jnp.uint32(0))
