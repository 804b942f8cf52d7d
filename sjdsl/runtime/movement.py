"""Movement of all agents at once: collisions are settled at random, swaps are blocked."""

from functools import partial

import jax.numpy as jnp
from jax import Array, lax

from sjdsl.runtime.bits import unpack_number
from sjdsl.runtime.forms import by_platform
from sjdsl.runtime.reductions import sum_of
from sjdsl.runtime.varying import settled

PACKED = 32  # agents up to which a GPU follows chains of movers in a few words of 32 bits


def resolve(position: Array, target: Array, draws: Array, exchange: bool = False) -> Array:
    """Returns the cells of all agents after they have moved at once.

    Of several movers to one cell the one with the largest rank wins. Two agents can't swap their
    cells unless `exchange`. A mover whose target stays occupied stays. Following, and cycles of
    three or more, are possible.

    Args:
      position: `[N]` int32, different cells, except that agents that are away have cell 0.
      target: `[N]` int32, the cell each agent wants, its position if it stays.
      draws: `[N]` uint32, random; the rank of an agent is its draw with the low 8 bits replaced by
        its number.

    Returns:
      `[N]` int32.
    Source: the resolver of SocialJax 1.2, stated in the manual ("Movement").
    """
    n = position.shape[0]
    if n == 1:
        return target
    if n > PACKED:
        return _by_spreading(position, target, draws, exchange)
    by_spreading = partial(_by_spreading, exchange=exchange)
    by_walking = partial(_by_walking, exchange=exchange)
    return by_platform(by_spreading, by_walking, position, target, draws)


def _wishes(position: Array, target: Array, draws: Array) -> tuple[Array, Array, Array]:
    """Returns who wants to move, and which agents are in whose way. The arguments: see `resolve`.

    Returns:
      `[N]` bool, who wants to move;
      `[N, N]` bool, entry i, j: whether i wants the cell on which j is;
      `[N, N]` bool, entry i, j: whether j wants the cell that i wants, with a larger rank.
    """
    numbers = jnp.arange(position.shape[0], dtype=jnp.uint32)
    rank = (draws & jnp.uint32(0xFFFFFF00)) | numbers
    moving = target != position
    into = (target[:, None] == position[None, :]) & moving[:, None]
    has_same_target = (target[:, None] == target[None, :]) & moving[None, :]
    is_outranked = rank[None, :] > rank[:, None]
    return moving, into, has_same_target & is_outranked


def _by_walking(position: Array, target: Array, draws: Array, exchange: bool) -> Array:
    """The form for GPUs: each agent walks along the chain of those it waits for.

    It moves unless somebody in the chain stays. Each agent's entry of a table has, in its lower
    bits, the agent on whose cell it wants to go (itself if nobody is there), and above them whether
    it stays for a reason of its own. The table is kept in a few words.
    """
    n = position.shape[0]
    numbers = jnp.arange(n, dtype=jnp.uint32)
    moving, into, loses = _wishes(position, target, draws)
    if not exchange:
        into_mine = (target[None, :] == position[:, None]) & moving[None, :]
        loses = loses | (into & into_mine)
    # One sum for two values: in the low 8 bits the agent that is waited for, plus 1; above them the
    # number of reasons to stay.
    waited_for = jnp.where(into, numbers[None, :] + 1, jnp.uint32(0))
    reasons = jnp.where(loses, jnp.uint32(256), jnp.uint32(0))
    sums = sum_of(waited_for + reasons, axis=1)
    next_plus_one = sums & 255
    follows = jnp.where(next_plus_one == 0, numbers, next_plus_one - 1)
    stays = ((sums >= 256) | ~moving).astype(jnp.uint32)
    bits = max(1, (n - 1).bit_length())  # of an agent's number
    packed = follows | (stays << bits)
    entry = lax.optimization_barrier(packed.astype(jnp.uint8)).astype(jnp.uint32)
    per_word = 32 // (bits + 1)
    shifts = jnp.arange(per_word, dtype=jnp.uint32) * (bits + 1)
    table = []
    for first in range(0, n, per_word):
        shifted = entry[first : first + per_word] << shifts[: n - first]
        table.append(sum_of(shifted))
    agent = numbers  # where in its chain each agent has come
    stuck = jnp.zeros(n, jnp.uint32)
    for _ in range(n):
        entry_of_agent = unpack_number(table, agent, bits + 1, per_word)
        stuck = stuck | (entry_of_agent >> bits)
        agent = entry_of_agent & ((1 << bits) - 1)
    return jnp.where(stuck != 0, position, target)


def _by_spreading(position: Array, target: Array, draws: Array, exchange: bool) -> Array:
    """The form for CPUs: all who wait for somebody that stays are marked, until no more are."""
    moving, into, loses = _wishes(position, target, draws)
    if not exchange:
        loses = loses | (into & into.T)
    has_reason = ~moving | jnp.any(loses, axis=1)
    stays = _with_waiting(into, has_reason)
    return jnp.where(stays, position, target)


def _with_waiting(into: Array, stays: Array) -> Array:
    """Returns who stays, and who waits for one of them, directly or through others: `[N]` bool.

    Args:
      into: `[N, N]` bool, entry i, j: whether i waits for j.
      stays: `[N]` bool.
    """
    n = stays.shape[0]
    if n > 31:

        def spread_once(_: int, stays: Array) -> Array:
            return stays | jnp.any(into & stays[None, :], axis=1)

        spread: Array = lax.fori_loop(0, n, spread_once, settled(partial(spread_once, 0), stays))
        return spread
    # The same with sets of agents as bits of one number.
    bit = jnp.uint32(1) << jnp.arange(n, dtype=jnp.uint32)
    waits_for = jnp.sum(jnp.where(into, bit[None, :], jnp.uint32(0)), axis=1, dtype=jnp.uint32)
    staying = jnp.sum(jnp.where(stays, bit, jnp.uint32(0)), dtype=jnp.uint32)

    def spread_bits_once(_: int, staying: Array) -> Array:
        waiting = jnp.where((waits_for & staying) != 0, bit, jnp.uint32(0))
        return staying | jnp.sum(waiting, dtype=jnp.uint32)

    start = settled(partial(spread_bits_once, 0), staying)
    staying = lax.fori_loop(0, n - 1, spread_bits_once, start)
    result: Array = (staying & bit) != 0
    return result
