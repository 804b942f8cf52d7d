"""Counts members near each cell and sets with a member, and finds which cells are occupied."""

from functools import partial, reduce

import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.bits import WIDTH, pack, size_of_set, unpack_number
from sjdsl.runtime.forms import by_platform, one_function
from sjdsl.runtime.reductions import any_of, sum_of
from sjdsl.runtime.rows import one_hot


def count_near(member: Array, masks: Array) -> Array:
    """Returns how many members each cell has near it.

    Args:
      member: `[M]` bool, which cells are members.
      masks: `[W, S]` uint32 of `geometry.near_masks`: the cells near each of S cells, as bits.
    Returns:
      `[S]` int32.
    """
    return sum_of(size_of_set(pack(member)[:, None] & masks), axis=0)


def segment_sum(amounts: Array, numbers: Array, size: int) -> Array:
    """Returns the sum of the amounts for each number, as `jax.ops.segment_sum` does: `[size]`.

    Each number is compared with all: for few amounts far cheaper than a scatter, which XLA makes
    one entry at a time on a CPU.

    Args:
      amounts: a shape; of booleans it is counted how many hold, int32.
      numbers: integers of the same shape; what has a number outside 0 .. size - 1 counts for none.
    """
    counts_for = one_hot(numbers, size)
    axes = tuple(range(amounts.ndim))
    if amounts.dtype == bool:
        return sum_of(counts_for & amounts[..., None], axes, jnp.int32)
    return sum_of(jnp.where(counts_for, amounts[..., None], 0), axes, amounts.dtype)


@partial(one_function, static=("agents",))
def times_in(sets: Array, agents: int) -> Array:
    """Returns how many of the sets each agent is in.

    Args:
      sets: any shape, unsigned; bit i for agent i.
      agents: at most as many as the sets have bits.
    Returns:
      `[agents]` int32.
    """
    return by_platform(
        partial(_added_in_rows, agents=agents),
        partial(_added_at_once, agents=agents),
        sets.reshape(-1),
    )


def _added_at_once(sets: Array, agents: int) -> Array:
    """The form for GPUs: each set becomes words with a field for each agent, which are then added.

    A field has the bit of its agent, and is wide enough for the sum. A product with `copies` puts
    bit i of some agents' bits, which are next to each other, into the lowest bit of field i.
    """
    width = max(2, sets.size.bit_length())  # of a field
    per_word = min(WIDTH // width, width - 1)  # fields
    copies = sum(1 << place * (width - 1) for place in range(per_word))
    lowest_bits = sum(1 << place * width for place in range(per_word))
    bits_of_agents = []
    for first in range(0, agents, per_word):
        bits_of_agents.append((sets >> first).astype(jnp.uint32) & ((1 << per_word) - 1))
    totals = []
    for bits in bits_of_agents:
        fields = (bits * jnp.uint32(copies)) & jnp.uint32(lowest_bits)
        totals.append(jnp.sum(fields, dtype=jnp.uint32))
    number = jnp.arange(agents, dtype=jnp.int32)
    return unpack_number(totals, number, width, per_word).astype(jnp.int32)


def _added_in_rows(sets: Array, agents: int) -> Array:
    """The form for CPUs: adds rows of 32 sets, a few at a time, then along a row, all in bytes.

    XLA compiles this to vector instructions of 32 bytes, a sum along all sets to none, and a sum of
    bytes as int32 to shorter ones (docs/research/performance.md).
    """
    agent = jnp.arange(agents, dtype=sets.dtype)[:, None]

    def members(row: Array) -> Array:
        """Returns 1 where a set of the row has an agent, else 0: `[agents, 32]` uint8."""
        result: Array = ((row[None] >> agent) & sets.dtype.type(1)).astype(jnp.uint8)
        return result

    rows = in_rows(sets)
    num_full = sets.size // LANES
    full_rows = rows[:num_full]
    starts = range(0, num_full, _ROWS_AT_ONCE)
    parts = [full_rows[start : start + _ROWS_AT_ONCE] for start in starts]
    if num_full < len(rows):
        parts.append(rows[num_full:])  # a shorter row
    counts = jnp.zeros(agents, jnp.int32)
    for part in parts:
        added = reduce(jnp.add, map(members, part))
        counts = counts + jnp.sum(added, axis=1, dtype=jnp.uint8).astype(jnp.int32)
    return counts


def in_rows(values: Array) -> list[Array]:
    """Returns the last axis in pieces of LANES, what is left over last.

    Work on such a piece is one vector instruction.
    """
    return [values[..., first : first + LANES] for first in range(0, values.shape[-1], LANES)]


LANES = 32  # bytes of a vector register
_ROWS_AT_ONCE = 4  # at most 7: a byte holds 7 * 32; 6 are as fast, 2 and 7 slower


@partial(one_function, static=("size",))
def occupied(site: Array, size: int) -> Array:
    """Returns which cells have an agent on them.

    Args:
      site: `[N]` int32, the number of each agent's cell, `size` for elsewhere.

    Returns:
      `[size]` bool.
    """
    return by_platform(partial(_marked, size=size), partial(_compared, size=size), site)


def _compared(site: Array, size: int) -> Array:
    """The form for GPUs: each cell compares itself with all of them, wherever it is asked for."""
    return any_of(site[None] == jnp.arange(size, dtype=jnp.int32)[:, None], axis=1)


def _marked(site: Array, size: int) -> Array:
    """The form for CPUs: a scatter."""
    return jnp.zeros(size, bool).at[site].set(True, mode="drop", wrap_negative_indices=False)
