"""Random choices: picks members, places agents on free cells, brings them back, and forms pairs.

A draw is a random uint32. Of n members, a draw d chooses number floor(d * n / 2^32), which `below`
computes. Many kernels keep sets as bits: `bits.py`.
"""

from collections.abc import Callable
from functools import partial, reduce

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax
from jax.custom_batching import custom_vmap

from sjdsl.runtime import bits
from sjdsl.runtime.actions import ANY_HEADING, SAME_HEADING
from sjdsl.runtime.counting import in_rows
from sjdsl.runtime.forms import by_platform, one_function
from sjdsl.runtime.random_bits import below, random_bits_at
from sjdsl.runtime.reductions import any_of
from sjdsl.runtime.rows import entries_in_bounds, on_last_axis
from sjdsl.runtime.varying import either, settled


def pick(member: Array, draw: Array) -> tuple[Array, Array]:
    """Returns one member of each set, all equally likely.

    Args:
      member: `[..., S]` bool, which of S candidates are members.
      draw: `[...]` uint32, random.

    Returns:
      `[...]` int32, its number among the candidates, undefined if there is no member; and `[...]`
      bool, whether there is one.
    """
    return pick_of_large_set(bits.pack(member), draw)


def pick_of_set(sets: Array, draw: Array) -> tuple[Array, Array]:
    """Returns what `pick` does, of sets kept as bits.

    Args:
      sets: `[...]` unsigned.
      draw: uint32 of that shape, or with more axes, for several draws from one set.
    """
    size = bits.size_of_set(sets)
    member = bits.nth_bit(sets, below(draw, size))
    return member, jnp.broadcast_to(size > 0, draw.shape)


def pick_of_large_set(sets: Array, draw: Array) -> tuple[Array, Array]:
    """Returns what `pick_of_set` does, of sets kept as bits in several words: `[..., W]` uint32."""
    size = bits.size_of_large_set(sets)
    member = bits.nth(sets, below(draw, size))
    return member, jnp.broadcast_to(size > 0, draw.shape)


def pick_of_sets(members: Array, key: Array, draws_of: Callable[[Array], Array]) -> Array:
    """Returns one agent of each of many sets, as a set; it draws only if it must.

    The agents are those of `pick_of_set`. A set with one member needs no draw d, since
    floor(d * 1 / 2^32) is 0. For a batch, all draw if one of its environments needs to. A second
    `vmap` around turns that choice back into a select.

    Args:
      members: `[..., S]` unsigned, the sets as bits.
      key: two uint32 words.
      draws_of: the key -> a draw for each set, uint32 of the shape of `members`.

    Returns:
      `[..., S]` of the same dtype: sets of one agent, which `member_of` returns, or empty ones.
    """

    def chosen(members: Array, key: Array) -> Array:
        agent, has_member = pick_of_set(members, draws_of(key))
        bit = members.dtype.type(1) << agent.astype(members.dtype)
        return jnp.where(has_member, bit, members.dtype.type(0))

    @custom_vmap
    def picked(members: Array, key: Array) -> Array:
        return either(_several(members), lambda: chosen(members, key), lambda: members)

    @picked.def_vmap
    def batched(
        size: int, in_batched: list[bool], members: Array, key: Array
    ) -> tuple[Array, bool]:
        """Picks of the sets of a batch `[B, ..., S]`."""
        members_batched, key_batched = in_batched
        axes = (0 if members_batched else None, 0 if key_batched else None)
        chosen_of_each = jax.vmap(chosen, in_axes=axes, axis_size=size)
        if members_batched:
            unchanged = members
        else:
            unchanged = jnp.broadcast_to(members, (size, *members.shape))
        # One branch for the whole batch: under `vmap`, each set would compute both.
        has_several = _several(members)
        return either(has_several, lambda: chosen_of_each(members, key), lambda: unchanged), True

    # A GPU draws in any case: a branch would wait for the host.
    result: Array = by_platform(picked, chosen, members, key)
    return result


def member_of(set_of_one: Array) -> Array:
    """Returns the agent of each set of one: `[...]` unsigned -> `[...]` int32.

    It is undefined for an empty set.
    """
    lower_bits = set_of_one - 1  # as many as the agent's number
    return lax.population_count(lower_bits).astype(jnp.int32)


def _several(members: Array) -> Array:
    """Returns whether some set has more than one member: bool scalar.

    The sets without their lowest members are joined, row by row. XLA makes vector instructions of
    that, but of nothing along the last axis (docs/research/performance.md).
    """
    rows = in_rows(members)
    # The last row is as long as the others, so some sets are in two rows.
    rows[-1] = members[..., -rows[0].shape[-1] :]
    without_lowest = [row & (row - 1) for row in rows]
    joined = reduce(lambda one, other: one | other, without_lowest)
    while joined.ndim > 1:
        joined = lax.reduce(joined, joined.dtype.type(0), lax.bitwise_or, (0,))
    return jnp.any(joined != 0)


def choose(
    member: Array,
    draws: Array,
    number: Array,
    key: Array | None = None,
    stream: int = 0,
    limit: Array | None = None,
) -> Array:
    """Returns which members are picked when some are, one after the other, none twice.

    With a limit, only those of them whose own draw is below it.

    Args:
      member: `[..., S]` bool, which of S candidates are members.
      draws: `[..., T]` uint32, random, one for each turn; `number` is never more than T while
        members are left.
      number: `[...]` int32, how many are picked.
      key, stream: `[2]` uint32, and a stream, of which candidate i draws number i.
      limit: uint32, of `random_bits.threshold`.

    Returns:
      `[..., S]` bool.
    """
    if 0 in (member.shape[-1], draws.shape[-1]):
        return jnp.zeros(member.shape, bool)
    chosen = _chosen(bits.pack(member), draws, number, key, jnp.uint32(stream), limit)
    return bits.unpack(chosen, member.shape[-1])


MOST_TURNS = 128  # turns that are unrolled


@one_function
def _chosen(
    packed: Array,
    draws: Array,
    number: Array,
    key: Array | None,
    stream: Array,
    limit: Array | None,
) -> Array:
    """Returns what `choose` does, of sets kept as bits: `[..., W]` uint32."""

    def passes(members: Array) -> Array:
        """Returns which members, `[...]` or `[..., T]` numbers, have a draw below the limit."""
        if key is None or limit is None:
            return jnp.asarray(True)
        return (random_bits_at(key, stream, members.astype(jnp.uint32)) >> 1) < limit

    one_by_one = partial(_chosen_turn_by_turn, passes)
    at_once = partial(_chosen_at_once, passes)
    if draws.shape[-1] > MOST_TURNS:
        return one_by_one(packed, draws, number)
    return by_platform(one_by_one, at_once, packed, draws, number)


def _chosen_at_once(
    passes: Callable[[Array], Array], packed: Array, draws: Array, number: Array
) -> Array:
    """The form for GPUs: each turn computes its member by itself.

    A turn draws a place among the members that earlier turns have left. Going back through these
    turns, it makes that a place among all members.
    """
    draws = lax.optimization_barrier(draws)
    all_members = [jnp.broadcast_to(word[..., None], draws.shape) for word in bits.apart(packed)]
    total = reduce(lax.add, map(bits.size_of_set, all_members))
    turn = on_last_axis(np.arange(draws.shape[-1], dtype=np.int32), draws.ndim)
    place = below(draws, total - turn)
    for earlier_turn, draw in reversed(list(enumerate(bits.apart(draws)))):
        is_later = turn > earlier_turn
        place_taken = below(draw[..., None], total - earlier_turn)
        is_behind = is_later & (place >= place_taken)
        place = place + is_behind.astype(jnp.int32)
    word_number, bit = bits.nth_of(all_members, place)
    member = word_number * bits.WIDTH + bit
    picked = (turn < jnp.minimum(number[..., None], total)) & passes(member)
    return bits.set_of(jnp.where(picked, member, -1), packed.shape[-1] * bits.WIDTH)


def _chosen_turn_by_turn(
    passes: Callable[[Array], Array], packed: Array, draws: Array, number: Array
) -> Array:
    """The form for CPUs: a loop with as many turns as some set needs."""
    total = bits.size_of_large_set(packed)
    wanted = jnp.minimum(number, total)

    def has_turns_left(state: tuple[Array, Array, Array]) -> Array:
        turn, _, _ = state
        return jnp.any(turn < wanted)

    def take_turn(state: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
        """Picks the next member of each set, and keeps it if its draw is below the limit."""
        turn, left, chosen = state
        draw = lax.dynamic_index_in_dim(draws, turn, axis=-1, keepdims=False)
        member = bits.nth(left, below(draw, total - turn))  # each turn before has taken one
        others = bits.without(left, member)
        picked = (turn < wanted) & passes(member)
        with_member = chosen | (left & ~others)
        chosen = jnp.where(picked[..., None], with_member, chosen)
        return turn + 1, others, chosen

    start = (jnp.int32(0), packed, jnp.zeros_like(packed))
    _, _, chosen = lax.while_loop(has_turns_left, take_turn, settled(take_turn, start))
    return chosen


LONG = 16_384  # agents times cells: with more, placing would be too long a program if unrolled


def place(
    cells: Array,
    free: Array | None,
    draws: Array,
    position: Array,
    sent: Array,
    fitting: Array | None = None,
) -> tuple[Array, Array]:
    """Returns the positions after some agents are sent to cells.

    In the order of their numbers each is sent to one of the cells that are still free and fit it,
    all equally likely.

    Args:
      cells: `[S]` int32, the destination.
      free: `[S]` bool, which of them are free; None: all are.
      draws: `[N]` uint32, random, one for each agent.
      position: `[N]` int32, before.
      sent: `[N]` bool, who is sent.
      fitting: `[N, S]` bool, which cells fit each agent; None: all do.

    Returns:
      `[N]` int32 new positions, and `[N]` bool who was placed (False also if no cell was left).
    """
    if cells.shape[0] == 0:
        return position, jnp.zeros_like(sent)
    free_bits = bits.pack_all(cells.shape[0]) if free is None else bits.pack(free)
    return _placed(cells, free_bits, fitting, draws, position, sent)


@one_function
def _placed(
    cells: Array, free: Array, fitting: Array | None, draws: Array, position: Array, sent: Array
) -> tuple[Array, Array]:
    """Returns what `place` does. free: as bits, `[W]` uint32."""
    num_agents = position.shape[0]
    if num_agents > bits.WIDTH or num_agents * cells.shape[0] > LONG:
        return _one_by_one(cells, free, fitting, draws, position, sent)
    return by_platform(_one_by_one, _unrolled, cells, free, fitting, draws, position, sent)


def _one_by_one(
    cells: Array, free: Array, fitting: Array | None, draws: Array, position: Array, sent: Array
) -> tuple[Array, Array]:
    """The form for CPUs: a loop with a turn for each agent that is sent; most steps send nobody."""
    numbers = jnp.arange(position.shape[0], dtype=jnp.int32)
    fitting_bits = None if fitting is None else bits.pack(fitting)

    def somebody_waits(state: tuple[Array, Array, Array, Array]) -> Array:
        waiting, _, _, _ = state
        return jnp.any(waiting)

    def place_one(state: tuple[Array, Array, Array, Array]) -> tuple[Array, Array, Array, Array]:
        """Places the first agent that waits on one of the cells left, if there is one."""
        waiting, free, position, placed = state
        agent = jnp.argmax(waiting).astype(jnp.int32)
        possible = free if fitting_bits is None else free & entries_in_bounds(fitting_bits, agent)
        num_possible = bits.size_of_large_set(possible)
        site = bits.nth(possible, below(entries_in_bounds(draws, agent), num_possible))
        is_placed = (numbers == agent) & waiting & (num_possible > 0)
        others = bits.without(free, site)
        free = others if fitting_bits is None else jnp.where(num_possible > 0, others, free)
        waiting = waiting & (numbers != agent)
        position = jnp.where(is_placed, entries_in_bounds(cells, site), position)
        return waiting, free, position, placed | is_placed

    start = (sent, free, position, jnp.zeros_like(sent))
    _, _, position, placed = lax.while_loop(somebody_waits, place_one, settled(place_one, start))
    return position, placed


AT_ONCE = 8  # agents that one kernel places on many cells: with 12, it takes minutes to compile
FEW_WORDS = 4  # words of 32 cells: on so few, one kernel places all agents


def _unrolled(
    cells: Array, free: Array, fitting: Array | None, draws: Array, position: Array, sent: Array
) -> tuple[Array, Array]:
    """The form for GPUs: one agent after the other, on scalars that aren't written to memory."""
    fitting_bits = None if fitting is None else bits.pack(fitting)
    num_agents = position.shape[0]
    numbers = jnp.arange(num_agents, dtype=jnp.int32)
    free_words = bits.apart(free)
    stops = range(AT_ONCE - 1, num_agents - 1, AT_ONCE) if len(free_words) > FEW_WORDS else ()
    sent_bits = bits.as_bits(sent, jnp.uint32)
    # Half a word for each agent: 1 + the number of its cell among `cells`, 0 for none.
    halves = [jnp.uint32(0) for _ in range(0, num_agents, 2)]
    for agent in range(num_agents):
        possible = free_words
        if fitting_bits is not None:
            fitting_words = bits.apart(fitting_bits[agent])
            possible = [one & fit for one, fit in zip(free_words, fitting_words, strict=True)]
        num_possible = reduce(lax.add, map(bits.size_of_set, possible))
        number, bit = bits.nth_of(possible, below(draws[agent], num_possible))
        is_sent = ((sent_bits >> agent) & 1) != 0
        is_placed = is_sent & (num_possible > 0)
        taken = jnp.where(is_placed, jnp.uint32(1) << bit.astype(jnp.uint32), jnp.uint32(0))
        kept = lax.bitwise_not(taken)
        for place, word in enumerate(free_words):
            is_in_word = lax.eq(number, np.int32(place))
            free_words[place] = lax.select(is_in_word, lax.bitwise_and(word, kept), word)
        half = jnp.where(is_placed, number * bits.WIDTH + bit + 1, 0).astype(jnp.uint32)
        halves[agent // 2] = halves[agent // 2] | (half << (agent % 2 * 16))
        if agent in stops:
            free_words, halves = lax.optimization_barrier((free_words, halves))
    # They are stored, or the lane of each agent would compute them all.
    halves = lax.optimization_barrier(halves)
    site = bits.unpack_number(halves, numbers, 16, 2).astype(jnp.int32) - 1
    placed = site >= 0
    new = entries_in_bounds(cells, jnp.maximum(site, 0))
    return jnp.where(placed, new, position), placed


def come_back(
    cells: Array,
    free: Array | None,
    back: Array,
    draws: Array,
    heading_draws: Array,
    position: Array,
    heading: Array,
    away_facing: Array,
    fitting: Array | None = None,
) -> tuple[Array, Array, Array]:
    """Returns the positions and headings after some agents come back, and who did.

    In the order of their numbers, each comes to one of the cells that are still free.

    Args:
      back: `[N]` bool, who is due; who finds no cell stays away.
      draws, heading_draws: `[N]` uint32, random, for the cells and for the headings.
      heading: `[N]` integers, before.
      away_facing: `[N]` int32, the heading each will have, ANY_HEADING or SAME_HEADING.
      cells, free, position, fitting: as of `place`.

    Returns:
      `[N]` int32, `[N]` of the dtype of `heading`, and `[N]` bool.
    """
    position, placed = place(cells, free, draws, position, back, fitting)
    facing = jnp.where(away_facing == ANY_HEADING, below(heading_draws, 4), away_facing)
    facing = facing.astype(heading.dtype)
    facing = jnp.where(away_facing == SAME_HEADING, heading, facing)
    return position, jnp.where(placed, facing, heading), placed


def pair(ranks: Array, alike: bool) -> Array:
    """Returns each left member's partner when pairs are taken in the order of their ranks.

    A pair is taken if both members are still free.

    Args:
      ranks: `[L, R]` uint32, the greatest first, 0 where the two are no pair; of equal ranks the
        smaller left number is first, then the smaller right number.
      alike: whether both sides are the same members, so that one taken on one side is not free on
        the other.

    Returns:
      `[L]` int32, R for those without a partner.
    """
    num_right = ranks.shape[1]
    everybody = jnp.broadcast_to(jnp.arange(num_right, dtype=jnp.int32)[None], ranks.shape)
    return pair_reached(everybody, ranks, num_right, alike)


MOST_PAIRS = 16  # whose turns are unrolled
FEW_PAIRS = 64  # pairs times turns up to which a GPU has each pair as three scalars


def _paired_unrolled(reached: Array, ranks: Array, num_right: int, alike: bool, most: int) -> Array:
    """The form of `pair_reached` for GPUs: as many turns as there may be pairs.

    If pairs are few, each is a scalar, and none of these is written to memory.
    """
    num_left = ranks.shape[0]
    rows = jnp.arange(num_left, dtype=jnp.int32)
    ranks = lax.optimization_barrier(ranks)
    lefts = jnp.broadcast_to(rows[:, None], ranks.shape)
    are_few = ranks.size * most <= FEW_PAIRS
    # Ranks, left and right members: of all pairs in one entry, or of each pair as scalars.
    pairs: list[Pair] = [(ranks, lefts, reached)]
    if are_few:
        scalars = [bits.apart(array.reshape(-1)) for array in pairs[0]]
        pairs = list(zip(*scalars, strict=True))
    partner = jnp.full(num_left, num_right, jnp.int32)
    for _ in range(most):
        if are_few:
            rank, a, b = reduce(_better, pairs)
        else:
            rank, a, b = lax.optimization_barrier(_first(*pairs[0]))
        partner = jnp.where((rows == a) & (rank > 0), b, partner)
        for number, (rank, one, other) in enumerate(pairs):
            gone = _gone(one, other, a, b, alike)
            pairs[number] = (jnp.where(gone, jnp.uint32(0), rank), one, other)
    return partner


# A rank and two members: to decode a pair's number, XLA would add a kernel.
Pair = tuple[Array, Array, Array]


def _first(*pairs: Array) -> Pair:
    """Returns the pair that comes first; where all ranks are 0, some pair of rank 0."""
    past = jnp.int32(np.iinfo(np.int32).max)
    rank, a, b = lax.reduce(pairs, (jnp.uint32(0), past, past), _better, (0, 1))
    return rank, a, b


def _better(one: Pair, other: Pair) -> Pair:
    """Returns which of two pairs comes first."""
    rank, a, b = one
    other_rank, other_a, other_b = other
    has_more = rank > other_rank
    is_equal = rank == other_rank
    is_earlier = (a < other_a) | ((a == other_a) & (b < other_b))
    is_better = has_more | (is_equal & is_earlier)
    return (
        jnp.where(is_better, rank, other_rank),
        jnp.where(is_better, a, other_a),
        jnp.where(is_better, b, other_b),
    )


def _gone(lefts: Array, rights: Array, a: Array, b: Array, alike: bool) -> Array:
    """Returns which pairs of a left and a right member can't be any more once `a` has `b`."""
    gone = (lefts == a) | (rights == b)
    return gone | (lefts == b) | (rights == a) if alike else gone


def pair_reached(reached: Array, ranks: Array, num_right: int, alike: bool) -> Array:
    """Returns what `pair` returns, from the few right members that each left member reaches.

    Args:
      reached: `[L, K]` int32, numbers of right members where the rank is not 0; one may stand there
        twice.
      ranks: `[L, K]` uint32, as of `pair`, 0 where there is no pair.
      num_right: how many right members there are.
      alike: as of `pair`.

    Returns:
      `[L]` int32, `num_right` for those without a partner.
    """
    num_left = reached.shape[0]
    if num_right == 0 or 0 in reached.shape:
        return jnp.full(num_left, num_right, jnp.int32)
    if reached.shape[1] == 1 and not alike:
        return _reached_at_once(reached[:, 0], ranks[:, 0], num_right)
    most = min(num_left, num_right) // (2 if alike else 1)
    in_turn = partial(_paired_in_turn, num_right=num_right, alike=alike)
    if most > MOST_PAIRS:
        return in_turn(reached, ranks)
    unrolled = partial(_paired_unrolled, num_right=num_right, alike=alike, most=most)
    return by_platform(in_turn, unrolled, reached, ranks)


def _reached_at_once(reached: Array, ranks: Array, num_right: int) -> Array:
    """Returns what `pair_reached` returns if each left member reaches one right member.

    Only those who reach the same one compete.
    """
    rows = jnp.arange(reached.shape[0], dtype=jnp.int32)
    has_more = ranks[None] > ranks[:, None]
    is_equal = ranks[None] == ranks[:, None]
    is_earlier = rows[None] < rows[:, None]
    comes_first = has_more | (is_equal & is_earlier)
    outdone = any_of((reached[None] == reached[:, None]) & comes_first, axis=1)
    return jnp.where((ranks > 0) & ~outdone, reached, num_right)


def _paired_in_turn(reached: Array, ranks: Array, num_right: int, alike: bool) -> Array:
    """The form of `pair_reached` for CPUs: as many turns as there are pairs."""
    num_left = reached.shape[0]
    rows = jnp.arange(num_left, dtype=jnp.int32)
    numbers = rows[:, None] * num_right + reached  # of the pairs, in the order of equal ranks

    def has_pairs(state: tuple[Array, Array]) -> Array:
        ranks, _ = state
        return jnp.any(ranks > 0)

    def take(state: tuple[Array, Array]) -> tuple[Array, Array]:
        """Takes the pair with the greatest rank, of equal ones the first, and removes its members."""
        ranks, partner = state
        number = jnp.min(jnp.where(ranks == jnp.max(ranks), numbers, num_left * num_right))
        a = number // num_right
        b = number % num_right
        gone = _gone(rows[:, None], reached, a, b, alike)
        return jnp.where(gone, jnp.uint32(0), ranks), jnp.where(rows == a, b, partner)

    start = (ranks, jnp.full(num_left, num_right, jnp.int32))
    _, partner = lax.while_loop(has_pairs, take, settled(take, start))
    return partner


def outranking(place: Array, rank: Array, best: Array) -> Array:
    """Returns the ranks that are greater than those of other statements for their place, else 0.

    Of those who write one place in a phase, whoever has drawn the greatest rank writes it.

    Args:
      place: `[M]` int32.
      rank: `[M]` uint32.
      best: `[size]` uint32, of `best_ranks` of the other statements.
    """
    return jnp.where(rank > best[place], rank, jnp.uint32(0))


def best_ranks(place: Array, rank: Array, best: Array) -> Array:
    """Returns the greatest rank drawn for each place so far, 0 where nobody writes.

    Args:
      place: `[M]` int32.
      rank: `[M]` uint32.
      best: `[size]` uint32, the greatest ranks before these.

    Returns:
      `[size]` uint32.
    """
    return best.at[place].max(rank)


def drawn_by_lot(place: Array, rank: Array, size: int) -> Array:
    """Returns which of M writers write: for each place the one of the greatest rank.

    Of equal ranks it is the first.

    Args:
      place: `[M]` int32, 0 .. size - 1.
      rank: `[M]` uint32, 0 for those who do not write.

    Returns:
      `[M]` bool.
    """
    number = jnp.arange(place.shape[0], dtype=jnp.int32)
    best = jnp.zeros(size, jnp.uint32).at[place].max(rank)
    is_top = (rank > 0) & (rank == best[place])
    nobody = place.shape[0]
    of_nobody = jnp.full(size, nobody, jnp.int32)
    first = of_nobody.at[place].min(jnp.where(is_top, number, nobody))
    return number == first[place]
