"""Movement of all agents at once: a collision on a cell is settled at random, swaps are blocked, chains and cycles work."""

import jax.numpy as jnp
from jax import Array, lax


def resolve(position: Array, target: Array, word: Array, exchange: bool = False) -> Array:
    """Returns the cells after all agents have moved at once.

    Stayers keep their cells; of several movers to one cell the one with the largest rank wins; swaps are blocked unless `exchange`; a
    mover whose target stays occupied stays. Following, and cycles of three or more, work.

    Args:
      position: `[N]` int32, different cells (agents that are nowhere share cell 0 and have target 0).
      target: `[N]` int32, the cell each agent wants; its own for a stayer.
      word: `[N]` uint32, one random number an agent; the rank is the number with its low 8 bits replaced by the agent's id.
    Returns:
      `[N]` int32.
    Source: the resolver of SocialJax 1.2, stated in the manual ("Movement").
    """
    n = position.shape[0]
    if n == 1:
        return target
    index = jnp.arange(n, dtype=jnp.uint32)
    rank = (word & jnp.uint32(0xFFFFFF00)) | index
    moving = target != position
    into = (target[:, None] == position[None, :]) & moving[:, None]  # [i, j]: i wants the cell of j
    rival = (target[:, None] == target[None, :]) & moving[None, :] & (rank[None, :] > rank[:, None])
    lost = ~moving | jnp.any(rival if exchange else rival | (into & into.T), axis=1)
    lost = _spread(into, lost)
    return jnp.where(lost, position, target)


def _spread(into: Array, lost: Array) -> Array:
    """Returns `lost` with all who wait, directly or through others, for the cell of one who stays: `[N]` bool."""
    n = lost.shape[0]
    if n > 31:
        spread: Array = lax.fori_loop(0, n, lambda _, out: out | jnp.any(into & out[None, :], axis=1), lost)
        return spread
    bit = (jnp.uint32(1) << jnp.arange(n, dtype=jnp.uint32)).astype(jnp.uint32)
    waits = jnp.sum(jnp.where(into, bit[None, :], jnp.uint32(0)), axis=1, dtype=jnp.uint32)
    stays = jnp.sum(jnp.where(lost, bit, jnp.uint32(0)), dtype=jnp.uint32)
    stays = lax.fori_loop(0, n - 1, lambda _, s: s | _waiting(waits, bit, s), stays)
    result: Array = (stays & bit) != 0
    return result


def _waiting(waits: Array, bit: Array, stays: Array) -> Array:
    return jnp.sum(jnp.where((waits & stays) != 0, bit, jnp.uint32(0)), dtype=jnp.uint32)
