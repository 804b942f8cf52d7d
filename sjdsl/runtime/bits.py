"""Sets as bits of 32-bit integers: packing, and selecting the n-th member without a scan."""

import operator
from collections.abc import Sequence
from functools import partial, reduce

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from sjdsl.runtime.forms import by_platform
from sjdsl.runtime.reductions import lengthened, sum_of

WIDTH = 32


@jax.jit  # one function of the program for each shape, however many rules pick
def pack(members: Array) -> Array:
    """Returns members as bits: `[..., S]` bool -> `[..., W]` uint32, member i in bit i % 32 of word i // 32."""
    missing = -members.shape[-1] % WIDTH
    padded = lax.pad(
        members, jnp.asarray(False), [*[(0, 0, 0)] * (members.ndim - 1), (0, missing, 0)]
    )
    words = padded.reshape(*members.shape[:-1], -1, WIDTH)
    places = jnp.arange(WIDTH, dtype=jnp.uint32).reshape((1,) * members.ndim + (-1,))
    return jnp.sum(words.astype(jnp.uint32) << places, axis=-1, dtype=jnp.uint32)


def pack_all(size: int) -> Array:
    """Returns all members as bits, as `pack` does: `[W]` uint32."""
    full, rest = divmod(size, WIDTH)
    words = [2**WIDTH - 1] * full + [2**rest - 1] * bool(rest)
    return jnp.asarray(np.array(words, np.uint32))


def as_bits(members: Array, dtype: jnp.dtype) -> Array:
    """Returns sets as bits: `[..., N]` bool -> `[...]`, bit i for agent i."""
    # Written out: XLA evaluates no shifts by 0, 1, ..., and launched a kernel for a constant set.
    bit = jnp.asarray(2 ** np.arange(members.shape[-1], dtype=np.uint32), dtype)
    bit = bit.reshape((1,) * (members.ndim - 1) + (-1,))
    return sum_of(jnp.where(members, bit, jnp.zeros((), dtype)), axis=-1)


def from_bits(sets: Array, size: int) -> Array:
    """Returns the members of sets kept as bits: `[...]` unsigned -> `[..., size]` bool, entry i for bit i."""
    place = jnp.arange(size, dtype=sets.dtype).reshape((1,) * sets.ndim + (-1,))
    return ((sets[..., None] >> place) & 1) != 0


@partial(jax.jit, static_argnames="size")  # as above
def unpack(words: Array, size: int) -> Array:
    """Returns what was packed: `[..., W]` uint32 -> `[..., size]` bool."""
    places = jnp.arange(WIDTH, dtype=jnp.uint32).reshape((1,) * words.ndim + (-1,))
    members = (words[..., None] >> places) & jnp.uint32(1)
    result: Array = members.reshape(*words.shape[:-1], -1)[..., :size] != 0
    return result


def has_member(words: Array, member: Array) -> Array:
    """Returns whether sets have a member: `[..., W]` uint32 and `[...]` int32 -> `[...]` bool; nobody, -1, is in none."""
    index = jnp.arange(words.shape[-1], dtype=jnp.int32).reshape((1,) * member.ndim + (-1,))
    word = sum_of(jnp.where(index == (member >> 5)[..., None], words, jnp.uint32(0)), axis=-1)
    result: Array = ((word >> (member & (WIDTH - 1)).astype(jnp.uint32)) & jnp.uint32(1)) != 0
    return result


def count(words: Array) -> Array:
    """Returns how many bits are set in all words: `[..., W]` -> `[...]` int32."""
    return sum_of(lax.population_count(words).astype(jnp.int32), axis=-1)


@jax.jit  # as above
def nth_bit(word: Array, n: Array) -> Array:
    """Returns the place of the n-th set bit, n from 0: `[...]` unsigned and int32 -> `[...]` int32. Anything if there are fewer."""
    return by_platform(
        _nth_by_halves, _nth_by_table if word.dtype == jnp.uint8 else _nth_by_halves, word, n
    )


def _nth_by_table(word: Array, n: Array) -> Array:
    """The form for GPUs of a byte: a table with a row for each."""
    places = np.argsort(
        ~np.unpackbits(np.arange(256, dtype=np.uint8)[:, None], axis=1, bitorder="little") & 1,
        axis=1,
        kind="stable",
    )
    row = word.astype(jnp.int32) * 8
    return (
        jnp.asarray(places.reshape(-1), jnp.uint8)
        .at[row + n]
        .get(mode="promise_in_bounds", wrap_negative_indices=False)
        .astype(jnp.int32)
    )


def _nth_by_halves(word: Array, n: Array) -> Array:
    place, width = jnp.zeros_like(n), word.dtype.itemsize * 4
    while width:
        low = lax.population_count(word & word.dtype.type((1 << width) - 1)).astype(jnp.int32)
        above = n >= low
        n = jnp.where(above, n - low, n)
        word = jnp.where(above, word >> word.dtype.type(width), word)
        place = place + above.astype(jnp.int32) * width
        width //= 2
    return place


def nth(words: Array, n: Array) -> Array:
    """Returns which member is the n-th, n from 0: `[..., W]` uint32 and `[...]` int32 -> `[...]` int32. Anything if there are fewer."""
    return (
        nth_bit(words[..., 0], n)
        if words.shape[-1] == 1
        else by_platform(_nth_by_sums, _nth_in_turn, words, n)
    )


def _nth_in_turn(words: Array, n: Array) -> Array:
    """The form for GPUs."""
    number, bit = nth_of([jnp.broadcast_to(word, n.shape) for word in apart(words)], n)
    result: Array = number * WIDTH + bit
    return result


def _nth_by_sums(words: Array, n: Array) -> Array:
    """The form for CPUs."""
    index = jnp.arange(words.shape[-1], dtype=jnp.int32)
    counts = lax.population_count(words).astype(jnp.int32)
    earlier = (index[None] < index[:, None]).reshape((1,) * n.ndim + (index.size, index.size))
    before = jnp.sum(jnp.where(earlier, counts[..., None, :], 0), axis=-1, dtype=jnp.int32)
    here = (before <= n[..., None]) & (n[..., None] < before + counts)
    numbers = jnp.broadcast_to(index, words.shape)
    chosen = (
        jnp.where(here, words, jnp.uint32(0)),
        jnp.where(here, before, 0),
        jnp.where(here, numbers, 0),
    )
    # one sum of three instead of three: each would find `here` again
    zeros = (jnp.uint32(0), jnp.int32(0), jnp.int32(0))
    word, passed, number = lax.reduce(
        chosen, zeros, lambda a, b: tuple(map(operator.add, a, b)), (words.ndim - 1,)
    )
    result: Array = number * WIDTH + nth_bit(word, n - passed)
    return result


def apart(words: Array) -> list[Array]:
    """Returns the words of sets one by one, for work on a GPU of which nothing is written to memory: `[..., W]` -> W of `[...]`."""
    return [
        lax.index_in_dim(words, place, words.ndim - 1, keepdims=False)
        for place in range(words.shape[-1])
    ]


def nth_of(words: Sequence[Array], n: Array) -> tuple[Array, Array]:
    """Returns in which of some words the n-th member is, and which bit of it: W uint32 and an int32 of one shape -> two int32 of it."""
    word, before, number, passed = words[0], jnp.zeros_like(n), jnp.zeros_like(n), _ones(words[0])
    for place, other in enumerate(words[1:], 1):
        later = lax.ge(n, passed)
        word, before = lax.select(later, other, word), lax.select(later, passed, before)
        number, passed = (
            lax.select(later, lax.full_like(number, place), number),
            lax.add(passed, _ones(other)),
        )
    return number, nth_bit(word, n - before)


def field(words: Sequence[Array], number: Array, width: int, some: int) -> Array:
    """Returns a field of those that words hold, `some` a word, the first in the lowest bits of the first: uint32 of `number`'s shape."""
    word = reduce(
        lambda one, place: jnp.where(number // some == place, words[place], one),
        range(1, len(words)),
        words[0],
    )
    result: Array = (word >> (number % some * width).astype(jnp.uint32)) & jnp.uint32(
        (1 << width) - 1
    )
    return result


def _ones(word: Array) -> Array:
    return lax.population_count(word).astype(jnp.int32)


def set_of(numbers: Array, size: int) -> Array:
    """Returns the members of some numbers as bits, in a form for GPUs: `[..., M]` int32, -1 for none -> `[..., W]` uint32."""
    first = np.arange(0, size, WIDTH, dtype=np.int32).reshape((1,) * (numbers.ndim - 1) + (-1, 1))
    bit = (lax.optimization_barrier(numbers)[..., None, :] - first).astype(
        jnp.uint32
    )  # of other words: more than a word has
    mine = jnp.where(bit < WIDTH, jnp.uint32(1) << bit, jnp.uint32(0))
    words: Array = lax.optimization_barrier(
        lax.reduce(lengthened(mine, -1, 0), jnp.uint32(0), lax.bitwise_or, (numbers.ndim,))
    )
    return words


def without(words: Array, member: Array) -> Array:
    """Returns the members without one: `[..., W]` uint32 and `[...]` int32 -> `[..., W]` uint32."""
    index = jnp.arange(words.shape[-1], dtype=jnp.int32).reshape((1,) * member.ndim + (-1,))
    bit = jnp.uint32(1) << (member & (WIDTH - 1)).astype(jnp.uint32)
    return jnp.where(index == (member >> 5)[..., None], words & ~bit[..., None], words)
