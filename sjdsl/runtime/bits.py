"""Sets as bits of 32-bit integers: packing, and selecting the n-th member without a scan."""

import jax
import jax.numpy as jnp
from jax import Array, lax

WIDTH = 32


def pack(members: Array) -> Array:
    """Returns members as bits: `[..., S]` bool -> `[..., W]` uint32, member i in bit i % 32 of word i // 32."""
    missing = -members.shape[-1] % WIDTH
    padded = lax.pad(members, jnp.asarray(False), [*[(0, 0, 0)] * (members.ndim - 1), (0, missing, 0)])
    words = padded.reshape(*members.shape[:-1], -1, WIDTH)
    places = jnp.arange(WIDTH, dtype=jnp.uint32).reshape((1,) * members.ndim + (-1,))
    return jnp.sum(words.astype(jnp.uint32) << places, axis=-1, dtype=jnp.uint32)


def as_bits(members: Array, dtype: jnp.dtype) -> Array:
    """Returns sets as bits: `[..., N]` bool -> `[...]`, bit i for agent i."""
    bit = jnp.ones((), dtype) << jnp.arange(members.shape[-1], dtype=dtype).reshape((1,) * (members.ndim - 1) + (-1,))
    return jnp.sum(jnp.where(members, bit, jnp.zeros((), dtype)), axis=-1, dtype=dtype)


def from_bits(sets: Array, size: int) -> Array:
    """Returns the members of sets kept as bits: `[...]` unsigned -> `[..., size]` bool, entry i for bit i."""
    place = jnp.arange(size, dtype=sets.dtype).reshape((1,) * sets.ndim + (-1,))
    return ((sets[..., None] >> place) & 1) != 0


def unpack(words: Array, size: int) -> Array:
    """Returns what was packed: `[..., W]` uint32 -> `[..., size]` bool."""
    places = jnp.arange(WIDTH, dtype=jnp.uint32).reshape((1,) * words.ndim + (-1,))
    members = (words[..., None] >> places) & jnp.uint32(1)
    result: Array = members.reshape(*words.shape[:-1], -1)[..., :size] != 0
    return result


def has_member(words: Array, member: Array) -> Array:
    """Returns whether sets have a member: `[..., W]` uint32 and `[...]` int32 -> `[...]` bool; nobody, -1, is in none."""
    index = jnp.arange(words.shape[-1], dtype=jnp.int32).reshape((1,) * member.ndim + (-1,))
    word = jnp.sum(jnp.where(index == (member >> 5)[..., None], words, jnp.uint32(0)), axis=-1, dtype=jnp.uint32)
    result: Array = ((word >> (member & (WIDTH - 1)).astype(jnp.uint32)) & jnp.uint32(1)) != 0
    return result


def count(words: Array) -> Array:
    """Returns how many bits are set in all words: `[..., W]` -> `[...]` int32."""
    return jnp.sum(lax.population_count(words).astype(jnp.int32), axis=-1, dtype=jnp.int32)


@jax.jit  # one function of the program for each shape, however many rules pick
def nth_bit(word: Array, n: Array) -> Array:
    """Returns the place of the n-th set bit, n from 0: `[...]` unsigned and int32 -> `[...]` int32. Anything if there are fewer."""
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
    if words.shape[-1] == 1:
        only: Array = nth_bit(words[..., 0], n)
        return only
    index = jnp.arange(words.shape[-1], dtype=jnp.int32)
    counts = lax.population_count(words).astype(jnp.int32)
    earlier = (index[None] < index[:, None]).reshape((1,) * n.ndim + (index.size, index.size))
    before = jnp.sum(jnp.where(earlier, counts[..., None, :], 0), axis=-1, dtype=jnp.int32)
    here = (before <= n[..., None]) & (n[..., None] < before + counts)
    numbers = jnp.broadcast_to(index, words.shape)
    chosen = (jnp.where(here, words, jnp.uint32(0)), jnp.where(here, before, 0), jnp.where(here, numbers, 0))
    # one sum of three instead of three: each would find `here` again
    word, passed, number = lax.reduce(chosen, (jnp.uint32(0), jnp.int32(0), jnp.int32(0)), _added, (words.ndim - 1,))
    result: Array = number * WIDTH + nth_bit(word, n - passed)
    return result


def _added(left: tuple[Array, ...], right: tuple[Array, ...]) -> tuple[Array, ...]:
    return tuple(a + b for a, b in zip(left, right, strict=True))


def without(words: Array, member: Array) -> Array:
    """Returns the members without one: `[..., W]` uint32 and `[...]` int32 -> `[..., W]` uint32."""
    index = jnp.arange(words.shape[-1], dtype=jnp.int32).reshape((1,) * member.ndim + (-1,))
    bit = jnp.uint32(1) << (member & (WIDTH - 1)).astype(jnp.uint32)
    return jnp.where(index == (member >> 5)[..., None], words & ~bit[..., None], words)
