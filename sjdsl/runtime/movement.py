"""Movement of all agents at once: collisions are settled at random, swaps are blocked."""

from functools import partial

import jax.numpy as jnp
from jax import Array, lax

from sjdsl.runtime.bits import field
from sjdsl.runtime.forms import by_platform
from sjdsl.runtime.reductions import sum_of
from sjdsl.runtime.varying import settled

PACKED = 32  # agents up to which a GPU follows chains of movers in a few words of 32 bits


def resolve(position: Array, target: Array, word: Array, exchange: bool = False) -> Array:
    """Returns the cells after all agents have moved at once.

    Of several movers to one cell the one with the largest rank wins. Swaps are blocked unless
    `exchange`. A mover whose target stays occupied stays. Following, and cycles of three or more,
    are possible.

    Args:
      position: `[N]` int32, different cells, except that agents that are away have cell 0.
      target: `[N]` int32, the cell each agent wants, its position if it stays.
      word: `[N]` uint32, one random number an agent; the rank is the number with its low 8 bits
        replaced by the agent's id.

    Returns:
      `[N]` int32.
    Source: the resolver of SocialJax 1.2, stated in the manual ("Movement").
    """
    n = position.shape[0]
    if n == 1:
        return target
    if n > PACKED:
        return _by_spreading(position, target, word, exchange)
    return by_platform(
        partial(_by_spreading, exchange=exchange),
        partial(_by_walking, exchange=exchange),
        position,
        target,
        word,
    )


def _wishes(position: Array, target: Array, rank: Array) -> tuple[Array, Array, Array]:
    """Returns who wants to move, and which agents are in whose way.

    Args:
      position, target: as of `resolve`.
      rank: `[N]` uint32.

    Returns:
      `[N]` bool, who moves; `[N, N]` bool, entry i, j whether i moves to the cell of j; and
      `[N, N]` bool, entry i, j whether j moves to the target of i and has a larger rank.
    """
    moving = target != position
    into = (target[:, None] == position[None, :]) & moving[:, None]
    has_target = (target[:, None] == target[None, :]) & moving[None, :]
    return moving, into, has_target & (rank[None, :] > rank[:, None])


def _by_walking(position: Array, target: Array, word: Array, exchange: bool) -> Array:
    """The form for GPUs: each agent follows the chain of those it waits for, in a table of bits."""
    n = position.shape[0]
    index = jnp.arange(n, dtype=jnp.uint32)
    moving, into, lost = _wishes(position, target, (word & jnp.uint32(0xFFFFFF00)) | index)
    if not exchange:
        into_mine = (target[None, :] == position[:, None]) & moving[None, :]
        lost = lost | (into & into_mine)
    # One sum for two values: in the low 8 bits the agent that is waited for, plus 1; above them the
    # number of reasons to stay.
    waited_for = jnp.where(into, index[None, :] + 1, jnp.uint32(0))
    reasons = jnp.where(lost, jnp.uint32(256), jnp.uint32(0))
    sums = sum_of(waited_for + reasons, axis=1)
    bits = max(1, (n - 1).bit_length())
    follows = jnp.where((sums & 255) == 0, index, (sums & 255) - 1)
    stays = ((sums >= 256) | ~moving).astype(jnp.uint32)
    stored = lax.optimization_barrier((follows | (stays << bits)).astype(jnp.uint8))
    entry = stored.astype(jnp.uint32)
    per_word = 32 // (bits + 1)
    shifts = jnp.arange(per_word, dtype=jnp.uint32) * (bits + 1)
    table = []
    for first in range(0, n, per_word):
        shifted = entry[first : first + per_word] << shifts[: n - first]
        table.append(sum_of(shifted))
    agent = index
    stuck = jnp.zeros(n, jnp.uint32)
    for _ in range(n):
        entry_of_agent = field(table, agent, bits + 1, per_word)
        stuck = stuck | (entry_of_agent >> bits)
        agent = entry_of_agent & ((1 << bits) - 1)
    return jnp.where(stuck != 0, position, target)


def _by_spreading(position: Array, target: Array, word: Array, exchange: bool) -> Array:
    """The form for CPUs: all who wait for somebody that stays are marked, until no more are."""
    index = jnp.arange(position.shape[0], dtype=jnp.uint32)
    moving, into, outranked = _wishes(position, target, (word & jnp.uint32(0xFFFFFF00)) | index)
    lost = ~moving | jnp.any(outranked if exchange else outranked | (into & into.T), axis=1)
    lost = _spread(into, lost)
    return jnp.where(lost, position, target)


def _spread(into: Array, lost: Array) -> Array:
    """Returns `lost` and all who wait, directly or through others, for one of them: `[N]` bool."""
    n = lost.shape[0]
    if n > 31:

        def spread_once(_: int, out: Array) -> Array:
            return out | jnp.any(into & out[None, :], axis=1)

        spread: Array = lax.fori_loop(0, n, spread_once, settled(partial(spread_once, 0), lost))
        return spread
    bit = jnp.uint32(1) << jnp.arange(n, dtype=jnp.uint32)
    waits = jnp.sum(jnp.where(into, bit[None, :], jnp.uint32(0)), axis=1, dtype=jnp.uint32)
    stays = jnp.sum(jnp.where(lost, bit, jnp.uint32(0)), dtype=jnp.uint32)

    def waiting(_: int, stays: Array) -> Array:
        return stays | jnp.sum(
            jnp.where((waits & stays) != 0, bit, jnp.uint32(0)), dtype=jnp.uint32
        )

    stays = lax.fori_loop(0, n - 1, waiting, settled(partial(waiting, 0), stays))
    result: Array = (stays & bit) != 0
    return result
