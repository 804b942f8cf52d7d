"""Sending agents to free cells, choosing members at random, pairing agents."""

import jax.numpy as jnp
from jax import Array, lax


def place(cells: Array, ranks: Array, position: Array, sent: Array) -> tuple[Array, Array]:
    """Returns the cells after sending agents, in id order, to the free cells of largest rank.

    Args:
      cells: `[S]` int32, the destination.
      ranks: `[S]` uint32, larger first, 0 for cells that are not free.
      position: `[N]` int32; sent: `[N]` bool.
    Returns:
      `[N]` int32 new positions, and `[N]` bool who was placed (False also if the cells ran out).
    """
    if cells.shape[0] == 0:
        return position, jnp.zeros_like(sent)
    index = jnp.arange(position.shape[0], dtype=jnp.int32)

    def waiting(state: tuple[Array, Array, Array, Array]) -> Array:
        return jnp.any(state[0])

    def place_one(state: tuple[Array, Array, Array, Array]) -> tuple[Array, Array, Array, Array]:
        left, ranks, position, placed = state
        first = index == jnp.argmax(left).astype(jnp.int32)
        best = jnp.argmax(ranks)
        there = first & left & (ranks[best] > 0)
        ranks = ranks.at[best].set(jnp.uint32(0), mode="promise_in_bounds")
        return left & ~first, ranks, jnp.where(there, cells[best], position), placed | there

    # a turn for each agent sent, not for each agent: most steps send nobody
    start = (sent, ranks, position, jnp.zeros_like(sent))
    return lax.while_loop(waiting, place_one, start)[2:]


def choose(ranks: Array, number: Array) -> Array:
    """Returns which members are among the `number` of largest rank.

    Args:
      ranks: `[..., S]` uint32, 0 for what is no member; equal ranks: the earlier first.
      number: `[...]` int32.
    Returns:
      `[..., S]` bool.
    """
    if ranks.shape[-1] == 0:
        return jnp.zeros(ranks.shape, bool)
    index = jnp.arange(ranks.shape[-1]).reshape((1,) * (ranks.ndim - 1) + (-1,))

    def more(state: tuple[Array, Array, Array]) -> Array:
        turn, left, _ = state
        return jnp.any((turn < number) & (jnp.max(left, axis=-1) > 0))

    def take(state: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
        turn, left, chosen = state
        best = jnp.argmax(left, axis=-1)[..., None]
        hit = (index == best) & (left > 0) & (turn < number)[..., None]
        return turn + 1, jnp.where(hit, jnp.uint32(0), left), chosen | hit

    start = (jnp.int32(0), ranks, jnp.zeros(ranks.shape, bool))
    return lax.while_loop(more, take, start)[2]


def pair(ranks: Array, alike: bool) -> Array:
    """Returns each left member's partner when pairs are taken in the order of their ranks.

    Args:
      ranks: `[L, R]` uint32, 0 where the two are no pair; equal ranks: the earlier first.
      alike: both sides are the agents, so a member taken on one side is not free on the other.
    Returns:
      `[L]` int32, R for those without a partner.
    """
    left, right = ranks.shape
    if left == 0 or right == 0:
        return jnp.full(left, right, jnp.int32)
    rows, cols = jnp.arange(left), jnp.arange(right)

    def take(_: int, state: tuple[Array, Array]) -> tuple[Array, Array]:
        live, partner = state
        best = jnp.argmax(live.reshape(-1))
        a, b = best // right, best % right
        found = live.reshape(-1)[best] > 0
        partner = jnp.where(found & (rows == a), b.astype(jnp.int32), partner)
        gone_row = (rows == a) | (rows == b) if alike else rows == a
        gone_col = (cols == a) | (cols == b) if alike else cols == b
        gone = gone_row[:, None] | gone_col[None, :]
        return jnp.where(found & gone, jnp.uint32(0), live), partner

    most = left // 2 if alike else min(left, right)
    start = (ranks, jnp.full(left, right, jnp.int32))
    return lax.fori_loop(0, most, take, start)[1]


def pair_reached(reached: Array, ranks: Array, right: int, alike: bool) -> Array:
    """Returns what `pair` returns, from the few right members that each left member reaches.

    Args:
      reached: `[L, K]` int32, numbers of right members, 0 .. right - 1 where the rank is not 0; one may stand there twice.
      ranks: `[L, K]` uint32, 0 where there is no pair; equal ranks: the smaller left, then the smaller right number first.
      right: number of right members.
      alike: both sides are the agents, so a member taken on one side is not free on the other.
    Returns:
      `[L]` int32, `right` for those without a partner.
    """
    left = reached.shape[0]
    if right == 0 or 0 in reached.shape:
        return jnp.full(left, right, jnp.int32)
    rows = jnp.arange(left, dtype=jnp.int32)
    numbers = rows[:, None] * right + reached

    def more(state: tuple[Array, Array]) -> Array:
        return jnp.any(state[0] > 0)

    def take(state: tuple[Array, Array]) -> tuple[Array, Array]:
        live, partner = state
        number = jnp.min(jnp.where(live == jnp.max(live), numbers, left * right))
        a, b = number // right, number % right
        gone = (rows == a)[:, None] | (reached == b)
        if alike:
            gone = gone | (rows == b)[:, None] | (reached == a)
        return jnp.where(gone, jnp.uint32(0), live), jnp.where(rows == a, b, partner)

    return lax.while_loop(more, take, (ranks, jnp.full(left, right, jnp.int32)))[1]
