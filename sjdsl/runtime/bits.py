"""Sets as bits of 32-bit integers: packing, and selecting the n-th member without a scan."""

import operator
from collections.abc import Sequence
from functools import partial

import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from sjdsl.runtime.forms import by_platform, one_function
from sjdsl.runtime.reductions import lengthened, sum_of
from sjdsl.runtime.rows import entries_in_bounds, numbers_on_last_axis, on_last_axis, one_hot

WIDTH = 32


@one_function
def pack(members: Array) -> Array:
    """Returns members as bits, member i in bit i % 32 of word i // 32.

    Args:
      members: `[..., S]` bool.

    Returns:
      `[..., W]` uint32.
    """
    edges = [(0, 0, 0)] * members.ndim
    edges[-1] = (0, -members.shape[-1] % WIDTH, 0)
    padded = lax.pad(members, jnp.asarray(False), edges)
    words = padded.reshape(*members.shape[:-1], -1, WIDTH)
    places = numbers_on_last_axis(WIDTH, words.ndim, jnp.uint32)
    return jnp.sum(words.astype(jnp.uint32) << places, axis=-1, dtype=jnp.uint32)


def pack_all(size: int) -> Array:
    """Returns all members as bits, as `pack` does: `[W]` uint32."""
    num_full, rest = divmod(size, WIDTH)
    words = [2**WIDTH - 1] * num_full
    if rest:
        words.append(2**rest - 1)
    return jnp.asarray(np.array(words, np.uint32))


def as_bits(members: Array, dtype: jnp.dtype) -> Array:
    """Returns sets as bits: `[..., N]` bool -> `[...]`, bit i for agent i."""
    # Written out: XLA evaluates no shifts by 0, 1, ..., and launched a kernel for a constant set.
    bit = jnp.asarray(2 ** np.arange(members.shape[-1], dtype=np.uint32), dtype)
    bit = on_last_axis(bit, members.ndim)
    return sum_of(jnp.where(members, bit, jnp.zeros((), dtype)), axis=-1)


def from_bits(sets: Array, size: int) -> Array:
    """Returns the members of sets: `[...]` unsigned -> `[..., size]` bool, entry i for bit i."""
    places = numbers_on_last_axis(size, sets.ndim + 1, sets.dtype)
    return ((sets[..., None] >> places) & 1) != 0


@partial(one_function, static=("size",))
def unpack(words: Array, size: int) -> Array:
    """Returns what was packed: `[..., W]` uint32 -> `[..., size]` bool."""
    places = numbers_on_last_axis(WIDTH, words.ndim + 1, jnp.uint32)
    members = (words[..., None] >> places) & 1
    return members.reshape(*words.shape[:-1], -1)[..., :size] != 0


def has_member(words: Array, member: Array) -> Array:
    """Returns whether sets have a member.

    Args:
      words: `[..., W]` uint32.
      member: `[...]` int32; nobody, -1, is in no set.

    Returns:
      `[...]` bool.
    """
    is_in_word = one_hot(member >> 5, words.shape[-1])
    word = sum_of(jnp.where(is_in_word, words, jnp.uint32(0)), axis=-1)
    place = (member & (WIDTH - 1)).astype(jnp.uint32)
    return ((word >> place) & 1) != 0


def size_of_set(members: Array) -> Array:
    """Returns how many agents sets kept as bits have: `[...]` unsigned -> `[...]` int32."""
    return lax.population_count(members).astype(jnp.int32)


def size_of_large_set(words: Array) -> Array:
    """Returns the same of sets kept as bits in several words: `[..., W]` uint32 -> `[...]` int32."""
    return sum_of(size_of_set(words), axis=-1)


@one_function
def nth_bit(word: Array, n: Array) -> Array:
    """Returns the place of the n-th set bit, n from 0; undefined if there are fewer.

    Args:
      word: `[...]` unsigned.
      n: `[...]` int32.

    Returns:
      `[...]` int32.
    """
    for_gpus = _nth_by_table if word.dtype == jnp.uint8 else _nth_by_halves
    return by_platform(_nth_by_halves, for_gpus, word, n)


def _nth_by_table(word: Array, n: Array) -> Array:
    """The form for GPUs of a byte: a table with the places of each byte's bits, set ones first."""
    every_byte = np.arange(256, dtype=np.uint8)[:, None]
    is_set = np.unpackbits(every_byte, axis=1, bitorder="little")
    places = np.argsort(1 - is_set, axis=1, kind="stable")
    first = word.astype(jnp.int32) * 8
    table = jnp.asarray(places.reshape(-1), jnp.uint8)
    return entries_in_bounds(table, first + n).astype(jnp.int32)


def _nth_by_halves(word: Array, n: Array) -> Array:
    """The other form: counts the bits of the lower half, then those of half of that, and so on."""
    place = jnp.zeros_like(n)
    width = word.dtype.itemsize * 4
    while width:
        lower_half = word & word.dtype.type((1 << width) - 1)
        low = size_of_set(lower_half)
        is_above = n >= low
        n = jnp.where(is_above, n - low, n)
        word = jnp.where(is_above, word >> word.dtype.type(width), word)
        place = place + is_above.astype(jnp.int32) * width
        width //= 2
    return place


def nth(words: Array, n: Array) -> Array:
    """Returns which member is the n-th, n from 0; undefined if there are fewer.

    Args:
      words: `[..., W]` uint32.
      n: `[...]` int32.

    Returns:
      `[...]` int32.
    """
    if words.shape[-1] > 1:
        return by_platform(_nth_by_sums, _nth_in_turn, words, n)
    return nth_bit(words[..., 0], n)


def _nth_in_turn(words: Array, n: Array) -> Array:
    """The form for GPUs."""
    each_word = [jnp.broadcast_to(word, n.shape) for word in apart(words)]
    number, bit = nth_of(each_word, n)
    return number * WIDTH + bit


def _nth_by_sums(words: Array, n: Array) -> Array:
    """The form for CPUs."""
    index = jnp.arange(words.shape[-1], dtype=jnp.int32)
    counts = size_of_set(words)
    is_earlier = index[None] < index[:, None]
    is_earlier = is_earlier.reshape((1,) * n.ndim + (index.size, index.size))
    earlier_counts = jnp.where(is_earlier, counts[..., None, :], 0)
    before = jnp.sum(earlier_counts, axis=-1, dtype=jnp.int32)
    has_nth = (before <= n[..., None]) & (n[..., None] < before + counts)
    numbers = jnp.broadcast_to(index, words.shape)
    chosen = (
        jnp.where(has_nth, words, jnp.uint32(0)),
        jnp.where(has_nth, before, 0),
        jnp.where(has_nth, numbers, 0),
    )

    def add_each(left: tuple[Array, ...], right: tuple[Array, ...]) -> tuple[Array, ...]:
        return tuple(map(operator.add, left, right))

    # one sum of three instead of three: each would compute `has_nth` again
    zeros = (jnp.uint32(0), jnp.int32(0), jnp.int32(0))
    word, passed, number = lax.reduce(chosen, zeros, add_each, (words.ndim - 1,))
    result: Array = number * WIDTH + nth_bit(word, n - passed)
    return result


def apart(words: Array) -> list[Array]:
    """Returns the words of sets one by one: `[..., W]` -> W of `[...]`.

    Work on them on a GPU writes nothing to memory.
    """
    places = range(words.shape[-1])
    return [lax.index_in_dim(words, place, words.ndim - 1, keepdims=False) for place in places]


def nth_of(words: Sequence[Array], n: Array) -> tuple[Array, Array]:
    """Returns in which of some words the n-th member is, and which bit of it.

    Args:
      words: uint32, all of the shape of `n`.
      n: int32.

    Returns:
      two int32 of that shape.
    """
    word = words[0]
    before = jnp.zeros_like(n)  # members in the words before
    number = jnp.zeros_like(n)
    counted = size_of_set(word)
    for place, later_word in enumerate(words[1:], 1):
        is_later = lax.ge(n, counted)
        word = lax.select(is_later, later_word, word)
        before = lax.select(is_later, counted, before)
        number = lax.select(is_later, lax.full_like(number, place), number)
        counted = lax.add(counted, size_of_set(later_word))
    return number, nth_bit(word, n - before)


def unpack_number(words: Sequence[Array], place: Array, width: int, per_word: int) -> Array:
    """Returns one of the small numbers that words hold, `per_word` in each.

    The first number is in the lowest bits of the first word.

    Args:
      words: uint32.
      place: of the number, from 0; any shape.
      width: bits of a number.
      per_word: numbers in a word.

    Returns:
      uint32 of the shape of `place`.
    """
    word = words[0]
    for number_of_word, later_word in enumerate(words[1:], 1):
        word = jnp.where(place >= number_of_word * per_word, later_word, word)
    shift = (place % per_word * width).astype(jnp.uint32)
    result: Array = (word >> shift) & jnp.uint32((1 << width) - 1)
    return result


def set_of(numbers: Array, size: int) -> Array:
    """Returns the set of some members as bits, in a form for GPUs.

    Args:
      numbers: `[..., M]` int32, of the members, -1 for none.
      size: how many members there can be.

    Returns:
      `[..., W]` uint32.
    """
    first = np.arange(0, size, WIDTH, dtype=np.int32)
    first = first.reshape((1,) * (numbers.ndim - 1) + (-1, 1))
    stored = lax.optimization_barrier(numbers)[..., None, :]
    # As uint32 a member of an earlier word, whose place is negative, is huge: one comparison
    # leaves out members of earlier and of later words.
    bit = (stored - first).astype(jnp.uint32)
    members = jnp.where(bit < WIDTH, jnp.uint32(1) << bit, jnp.uint32(0))
    members = lengthened(members, -1, 0)
    words = lax.reduce(members, jnp.uint32(0), lax.bitwise_or, (numbers.ndim,))
    result: Array = lax.optimization_barrier(words)
    return result


def without(words: Array, member: Array) -> Array:
    """Returns the members without one: `[..., W]` uint32 and `[...]` int32 -> `[..., W]` uint32."""
    is_in_word = one_hot(member >> 5, words.shape[-1])
    bit = jnp.uint32(1) << (member & (WIDTH - 1)).astype(jnp.uint32)
    return jnp.where(is_in_word, words & ~bit[..., None], words)
