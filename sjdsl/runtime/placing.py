"""Random choices: picks members, places agents on free cells (spawn and respawn), brings back who was away, and forms pairs."""

from collections.abc import Callable
from functools import partial, reduce

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax
from jax.custom_batching import custom_vmap

from sjdsl.runtime import bits
from sjdsl.runtime.actions import ANY_HEADING, SAME_HEADING
from sjdsl.runtime.counting import in_rows, size_of_set
from sjdsl.runtime.forms import by_platform
from sjdsl.runtime.random_bits import below, random_bits_at
from sjdsl.runtime.reductions import any_of
from sjdsl.runtime.varying import either, settled


def pick(member: Array, word: Array) -> tuple[Array, Array]:
    """Returns one member, all equally likely: number floor(word * members / 2^32) of them.

    Args:
      member: `[..., S]` bool.
      word: `[...]` uint32.
    Returns:
      `[...]` int32 its number among all S, and `[...]` bool whether there is a member at all.
    """
    packed = bits.pack(member)
    number = bits.count(packed)
    return bits.nth(packed, below(word, number)), number > 0


def pick_of_set(members: Array, word: Array) -> tuple[Array, Array]:
    """Returns one agent of each set that is kept as bits: as `pick`, from `[...]` unsigned; `word` may have more axes: draws from one set."""
    number = size_of_set(members)
    return bits.nth_bit(members, below(word, number)), jnp.broadcast_to(number > 0, word.shape)


def pick_of_large_set(members: Array, word: Array) -> tuple[Array, Array]:
    """Returns one agent of each set that is kept as bits in several words: as `pick`, from `[..., W]` uint32."""
    number = bits.count(members)
    return bits.nth(members, below(word, number)), jnp.broadcast_to(number > 0, word.shape)


def pick_of_sets(members: Array, key: Array, draw: Callable[[Array], Array]) -> Array:
    """Returns one agent of each of many sets, as a set: as `pick_of_set`, but random numbers are drawn only if some set has several members.

    A set with one member needs no random draw: floor(word * 1 / 2^32) is 0. For a batch, numbers are drawn if one of its environments
    needs some. A second `vmap` around turns that choice back into a select. The agents are the same.

    Args:
      members: `[..., S]` unsigned, the sets as bits.
      key: two uint32 words.
      draw: the key to the words, uint32 of the shape of `members`.
    Returns:
      `[..., S]` of the same dtype: sets of one agent, or of none where there is none. `member_of` says which.
    """

    def chosen(members: Array, key: Array) -> Array:
        agent, found = pick_of_set(members, draw(key))
        return jnp.where(
            found, members.dtype.type(1) << agent.astype(members.dtype), members.dtype.type(0)
        )

    @custom_vmap
    def picked(members: Array, key: Array) -> Array:
        result: Array = either(_several(members), lambda: chosen(members, key), lambda: members)
        return result

    @picked.def_vmap
    def batched(
        size: int, in_batched: list[bool], members: Array, key: Array
    ) -> tuple[Array, bool]:
        axes = tuple(0 if batched else None for batched in in_batched)
        each = jax.vmap(chosen, in_axes=axes, axis_size=size)
        as_they_are = (
            members if in_batched[0] else jnp.broadcast_to(members, (size, *members.shape))
        )
        return either(_several(members), lambda: each(members, key), lambda: as_they_are), True

    result: Array = by_platform(
        picked, chosen, members, key
    )  # a GPU draws in any case: a branch would wait for the host
    return result


def member_of(one: Array) -> Array:
    """Returns the agent of each set of one: `[...]` unsigned -> `[...]` int32, anything where there is none."""
    return lax.population_count(one - 1).astype(jnp.int32)


def _several(members: Array) -> Array:
    """Returns whether some set has more than one member. The sets without their lowest members are joined, row by row.

    XLA makes vector instructions of that, but of nothing along the last axis (docs/performance.md).
    """
    rows = in_rows(members)
    rows[-1] = members[
        ..., -rows[0].shape[-1] :
    ]  # as long as the others: some sets are looked at twice
    joined = reduce(lambda one, other: one | other, [row & (row - 1) for row in rows])
    while joined.ndim > 1:
        joined = lax.reduce(joined, joined.dtype.type(0), lax.bitwise_or, (0,))
    return jnp.any(joined != 0)


def choose(member: Array, words: Array, number: Array) -> Array:
    """Returns which members are picked when so many are, one after the other, none twice.

    Args:
      member: `[..., S]` bool.
      words: `[..., T]` uint32, one for each turn; `number` is never more than T while members are left.
      number: `[...]` int32.
    Returns:
      `[..., S]` bool.
    """
    if 0 in (member.shape[-1], words.shape[-1]):
        return jnp.zeros(member.shape, bool)
    chosen = _chosen(bits.pack(member), words, number)
    result: Array = bits.unpack(chosen, member.shape[-1])
    return result


def choose_by_chance(
    member: Array, words: Array, number: Array, key: Array, stream: int, limit: Array
) -> Array:
    """Returns which of the members that `choose` picks draw less than a limit; only members that are picked draw.

    Args:
      member, words, number: as of `choose`.
      key: `[2]` uint32.
      stream: of the draws; member i draws number i of it.
      limit: uint32, of `random_bits.threshold`.
    Returns:
      `[..., S]` bool.
    """
    if 0 in (member.shape[-1], words.shape[-1]):
        return jnp.zeros(member.shape, bool)
    packed = bits.pack(member)
    chosen = _chosen_by_chance(packed, words, number, key, jnp.uint32(stream), limit)
    result: Array = bits.unpack(chosen, member.shape[-1])
    return result


@jax.jit  # one function of the program for each shape, however many rules pick
def _chosen(packed: Array, words: Array, number: Array) -> Array:
    return _chosen_that(lambda _: jnp.bool_(True), packed, words, number)


@jax.jit  # as above
def _chosen_by_chance(
    packed: Array, words: Array, number: Array, key: Array, stream: Array, limit: Array
) -> Array:
    def draw_less(members: Array) -> Array:
        return (random_bits_at(key, stream, members.astype(jnp.uint32)) >> 1) < limit

    return _chosen_that(draw_less, packed, words, number)


MOST_TURNS = 128  # turns that are unrolled


def _chosen_that(
    passes: Callable[[Array], Array], packed: Array, words: Array, number: Array
) -> Array:
    """Returns which members are picked and pass, `[..., W]` uint32. passes: the numbers of members, `[...]` or `[..., T]`, to which do."""
    one_by_one, at_once = partial(_chosen_turn_by_turn, passes), partial(_chosen_at_once, passes)
    if words.shape[-1] > MOST_TURNS:
        return one_by_one(packed, words, number)
    return by_platform(one_by_one, at_once, packed, words, number)


def _chosen_at_once(
    passes: Callable[[Array], Array], packed: Array, words: Array, number: Array
) -> Array:
    """The form for GPUs: each turn makes what it drew among those left a number among all, turn by turn backwards."""
    words = lax.optimization_barrier(words)
    left = [
        jnp.broadcast_to(one[..., None], words.shape) for one in bits.apart(packed)
    ]  # each turn finds all that it needs by itself
    total = reduce(lax.add, map(size_of_set, left))
    turn = np.arange(words.shape[-1], dtype=np.int32).reshape((1,) * number.ndim + (-1,))
    place = below(words, total - turn)
    for earlier, word in reversed(list(enumerate(bits.apart(words)))):
        place = place + (
            (turn > earlier) & (place >= below(word[..., None], total - earlier))
        ).astype(jnp.int32)
    at, bit = bits.nth_of(left, place)
    one = at * bits.WIDTH + bit
    picked = (turn < jnp.minimum(number[..., None], total)) & passes(one)
    return bits.set_of(jnp.where(picked, one, -1), packed.shape[-1] * bits.WIDTH)


def _chosen_turn_by_turn(
    passes: Callable[[Array], Array], packed: Array, words: Array, number: Array
) -> Array:
    """The form for CPUs: as many turns as are taken."""
    total = bits.count(packed)
    wanted = jnp.minimum(
        number, total
    )  # a turn takes one: after `turn` of them, total - turn are left

    def more(state: tuple[Array, Array, Array]) -> Array:
        return jnp.any(state[0] < wanted)

    def take(state: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
        turn, left, taken = state
        word = lax.dynamic_index_in_dim(words, turn, axis=-1, keepdims=False)
        one = bits.nth(left, below(word, total - turn))
        others = bits.without(left, one)
        picked = (turn < wanted) & passes(one)
        return turn + 1, others, jnp.where(picked[..., None], taken | (left & ~others), taken)

    start = (jnp.int32(0), packed, jnp.zeros_like(packed))
    result: Array = lax.while_loop(more, take, settled(take, start))[2]
    return result


def place(
    cells: Array, free: Array | None, words: Array, position: Array, sent: Array
) -> tuple[Array, Array]:
    """Returns the places after sending agents, in id order, each to one of the cells that are still free, all equally likely.

    Args:
      cells: `[S]` int32, the destination.
      free: `[S]` bool; None: all are.
      words: `[N]` uint32, one for each agent.
      position: `[N]` int32; sent: `[N]` bool.
    Returns:
      `[N]` int32 new positions, and `[N]` bool who was placed (False also if the cells ran out).
    """
    return _place_among(cells, free, None, words, position, sent)


def place_fitting(
    cells: Array, free: Array | None, own: Array, words: Array, position: Array, sent: Array
) -> tuple[Array, Array]:
    """Returns the places after sending agents as `place` does, each to one of the free cells that fit it.

    Args:
      own: `[N, S]` bool, which cells fit each agent; cells, free, words, position, sent: as in `place`.
    Returns:
      as `place`: an agent for whom no fitting cell is left was not placed.
    """
    return _place_among(cells, free, own, words, position, sent)


LONG = 16_384  # agents times cells from which on placing would be too long a program if it were unrolled


def _place_among(
    cells: Array,
    free: Array | None,
    own: Array | None,
    words: Array,
    position: Array,
    sent: Array,
) -> tuple[Array, Array]:
    """Places agents as `place_fitting` does; own: None: all cells fit all."""
    if cells.shape[0] == 0:
        return position, jnp.zeros_like(sent)
    packed = bits.pack_all(cells.shape[0]) if free is None else bits.pack(free)
    result: tuple[Array, Array] = _placed(cells, packed, own, words, position, sent)
    return result


@jax.jit  # as above
def _placed(
    cells: Array, free: Array, own: Array | None, words: Array, position: Array, sent: Array
) -> tuple[Array, Array]:
    agents, size = position.shape[0], cells.shape[0]
    if agents > bits.WIDTH or agents * size > LONG:
        return _one_by_one(cells, free, own, words, position, sent)
    return by_platform(_one_by_one, _unrolled, cells, free, own, words, position, sent)


def _one_by_one(
    cells: Array, free: Array, own: Array | None, words: Array, position: Array, sent: Array
) -> tuple[Array, Array]:
    """The form for CPUs: a loop with a turn for each agent that is sent, not for each agent: most steps send nobody."""
    index = jnp.arange(position.shape[0], dtype=jnp.int32)
    fitting = None if own is None else bits.pack(own)

    def waiting(state: tuple[Array, Array, Array, Array]) -> Array:
        return jnp.any(state[0])

    def place_one(state: tuple[Array, Array, Array, Array]) -> tuple[Array, Array, Array, Array]:
        left, free, position, placed = state
        who = jnp.argmax(left).astype(jnp.int32)
        among = free if fitting is None else free & _entry(fitting, who)
        number = bits.count(among)
        cell = bits.nth(among, below(_entry(words, who), number))
        there = (index == who) & left & (number > 0)
        free = (
            bits.without(free, cell)
            if fitting is None
            else jnp.where(number > 0, bits.without(free, cell), free)
        )
        return (
            left & (index != who),
            free,
            jnp.where(there, _entry(cells, cell), position),
            placed | there,
        )

    start = (sent, free, position, jnp.zeros_like(sent))
    return lax.while_loop(waiting, place_one, settled(place_one, start))[2:]


AT_ONCE = 8  # agents that one kernel places on many cells: with 12, it takes minutes to compile
FEW_WORDS = 4  # words of 32 cells: on so few, one kernel places all agents


def _unrolled(
    cells: Array, free: Array, own: Array | None, words: Array, position: Array, sent: Array
) -> tuple[Array, Array]:
    """The form for GPUs: one agent after the other, on scalars, none of which is written to memory."""
    fitting = None if own is None else bits.pack(own)
    agents = position.shape[0]
    index = jnp.arange(agents, dtype=jnp.int32)
    left = bits.apart(free)
    stops = range(AT_ONCE - 1, agents - 1, AT_ONCE) if len(left) > FEW_WORDS else ()
    going = bits.as_bits(sent, jnp.uint32)
    given = [
        jnp.uint32(0) for _ in range(0, agents, 2)
    ]  # half a word for each agent: the number of its cell, one up; 0: none
    for who in range(agents):
        among = (
            left
            if fitting is None
            else [one & fit for one, fit in zip(left, bits.apart(fitting[who]), strict=True)]
        )
        total = reduce(lax.add, map(size_of_set, among))
        number, bit = bits.nth_of(among, below(words[who], total))
        there = (((going >> who) & 1) != 0) & (total > 0)
        taken = jnp.where(there, jnp.uint32(1) << bit.astype(jnp.uint32), jnp.uint32(0))
        kept = lax.bitwise_not(taken)
        left = [
            lax.select(lax.eq(number, np.int32(place)), lax.bitwise_and(one, kept), one)
            for place, one in enumerate(left)
        ]
        found = jnp.where(there, number * bits.WIDTH + bit + 1, 0).astype(jnp.uint32)
        given[who // 2] = given[who // 2] | (found << (who % 2 * 16))
        if who in stops:
            left, given = lax.optimization_barrier((left, given))
    given = lax.optimization_barrier(
        given
    )  # stored, or the lane of each agent would compute them all
    site = bits.field(given, index, 16, 2).astype(jnp.int32) - 1
    placed = site >= 0
    return jnp.where(placed, _entry(cells, jnp.maximum(site, 0)), position), placed


def come_back(
    cells: Array,
    free: Array | None,
    back: Array,
    words: Array,
    turns: Array,
    position: Array,
    heading: Array,
    away_facing: Array,
    own: Array | None = None,
) -> tuple[Array, Array, Array]:
    """Returns the positions and headings after some come back, in id order, each to one of the cells that are still free; and who did.

    Args:
      back: `[N]` bool, who is due; who finds no cell stays away.
      words, turns: `[N]` uint32, the random bits that cells and headings are drawn by.
      heading: `[N]` integers; away_facing: `[N]` int32, the heading each will have, ANY_HEADING or SAME_HEADING.
      cells, free, position: as of `place`; own: as of `place_fitting`, None if each cell fits everybody.
    """
    position, placed = _place_among(cells, free, own, words, position, back)
    facing = jnp.where(away_facing == ANY_HEADING, below(turns, 4), away_facing).astype(
        heading.dtype
    )
    facing = jnp.where(away_facing == SAME_HEADING, heading, facing)
    return position, jnp.where(placed, facing, heading), placed


def _entry(values: Array, number: Array) -> Array:
    """Returns an entry of the first axis, of a number past the end the last one.

    `number` is not negative, which saves the question whether it counts from the end.
    """
    return values.at[number].get(mode="promise_in_bounds", wrap_negative_indices=False)


def pair(ranks: Array, alike: bool) -> Array:
    """Returns each left member's partner when pairs are taken in the order of their ranks.

    Args:
      ranks: `[L, R]` uint32, 0 where the two are no pair; equal ranks: the earlier first.
      alike: both sides are the same members, so one taken on one side is not free on the other.
    Returns:
      `[L]` int32, R for those without a partner.
    """
    left, right = ranks.shape
    if left == 0 or right == 0:
        return jnp.full(left, right, jnp.int32)
    most = left // 2 if alike else min(left, right)
    in_turn = partial(_paired_in_turn, alike=alike, most=most)
    if most > MOST_PAIRS:
        return in_turn(ranks)

    def unrolled(
        ranks: Array,
    ) -> Array:  # as of `pair_reached`, whose left members all reach everybody
        everybody = jnp.broadcast_to(jnp.arange(right, dtype=jnp.int32)[None], ranks.shape)
        return _paired_unrolled(everybody, ranks, right, alike, most)

    return by_platform(in_turn, unrolled, ranks)


MOST_PAIRS = 16  # whose turns are unrolled
FEW_PAIRS = 64  # pairs times turns up to which a GPU takes up each pair by itself


def _paired_unrolled(reached: Array, ranks: Array, right: int, alike: bool, most: int) -> Array:
    """The form of `pair_reached` for GPUs: as many turns as there may be pairs; of few pairs all on scalars, none of which is stored."""
    left = ranks.shape[0]
    rows = jnp.arange(left, dtype=jnp.int32)
    arrays = lax.optimization_barrier(ranks), jnp.broadcast_to(rows[:, None], ranks.shape), reached
    few = ranks.size * most <= FEW_PAIRS
    live, lefts, rights = (bits.apart(array.reshape(-1)) if few else [array] for array in arrays)
    partner = jnp.full(left, right, jnp.int32)
    for _ in range(most):
        pairs = list(zip(live, lefts, rights, strict=True))
        rank, a, b = reduce(_better, pairs) if few else lax.optimization_barrier(_first(*pairs[0]))
        partner = jnp.where((rows == a) & (rank > 0), b, partner)
        gone = (_gone(one, other, a, b, alike) for one, other in zip(lefts, rights, strict=True))
        live = [jnp.where(out, jnp.uint32(0), rank) for out, rank in zip(gone, live, strict=True)]
    return partner


Pair = tuple[
    Array, Array, Array
]  # a rank and two members: to decode a pair's number, XLA would add a kernel


def _first(*pairs: Array) -> Pair:
    """Returns the pair that comes first; where all ranks are 0, some pair of rank 0."""
    past = jnp.int32(np.iinfo(np.int32).max)
    rank, a, b = lax.reduce(pairs, (jnp.uint32(0), past, past), _better, (0, 1))
    return rank, a, b


def _better(one: Pair, other: Pair) -> Pair:
    """Returns which of two pairs comes first."""
    (rank, a, b), (other_rank, other_a, other_b) = one, other
    first = (rank > other_rank) | (
        (rank == other_rank) & ((a < other_a) | ((a == other_a) & (b < other_b)))
    )
    return (
        jnp.where(first, rank, other_rank),
        jnp.where(first, a, other_a),
        jnp.where(first, b, other_b),
    )


def _gone(lefts: Array, rights: Array, a: Array, b: Array, alike: bool) -> Array:
    """Returns which pairs of a left and a right member can't be any more, since `a` and `b` are one."""
    gone = (lefts == a) | (rights == b)
    return gone | (lefts == b) | (rights == a) if alike else gone


def _paired_in_turn(ranks: Array, alike: bool, most: int) -> Array:
    """The form of `pair` for CPUs."""
    left, right = ranks.shape
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

    start = (ranks, jnp.full(left, right, jnp.int32))
    result: Array = lax.fori_loop(0, most, take, settled(partial(take, 0), start))[1]
    return result


def pair_reached(reached: Array, ranks: Array, right: int, alike: bool) -> Array:
    """Returns what `pair` returns, from the few right members that each left member reaches.

    Args:
      reached: `[L, K]` int32, numbers of right members, 0 .. right - 1 where the rank is not 0; one may stand there twice.
      ranks: `[L, K]` uint32, 0 where there is no pair; equal ranks: the smaller left, then the smaller right number first.
      right: number of right members.
      alike: both sides are the same members, so one taken on one side is not free on the other.
    Returns:
      `[L]` int32, `right` for those without a partner.
    """
    left = reached.shape[0]
    if right == 0 or 0 in reached.shape:
        return jnp.full(left, right, jnp.int32)
    if reached.shape[1] == 1 and not alike:
        return _reached_at_once(reached[:, 0], ranks[:, 0], right)
    most = min(left, right) // (2 if alike else 1)
    in_turn = partial(_reached_paired_in_turn, right=right, alike=alike)
    if most > MOST_PAIRS:
        return in_turn(reached, ranks)
    unrolled = partial(_paired_unrolled, right=right, alike=alike, most=most)
    return by_platform(in_turn, unrolled, reached, ranks)


def _reached_at_once(reached: Array, ranks: Array, right: int) -> Array:
    """Returns what `pair_reached` returns if each left member reaches one right member: only those who reach the same one compete."""
    rows = jnp.arange(reached.shape[0], dtype=jnp.int32)
    earlier = (ranks[None] > ranks[:, None]) | (
        (ranks[None] == ranks[:, None]) & (rows[None] < rows[:, None])
    )
    outdone = any_of((reached[None] == reached[:, None]) & earlier, axis=1)
    return jnp.where((ranks > 0) & ~outdone, reached, right)


def _reached_paired_in_turn(reached: Array, ranks: Array, right: int, alike: bool) -> Array:
    """The form of `pair_reached` for CPUs: as many turns as there are pairs."""
    left = reached.shape[0]
    rows = jnp.arange(left, dtype=jnp.int32)
    numbers = rows[:, None] * right + reached

    def more(state: tuple[Array, Array]) -> Array:
        return jnp.any(state[0] > 0)

    def take(state: tuple[Array, Array]) -> tuple[Array, Array]:
        live, partner = state
        number = jnp.min(jnp.where(live == jnp.max(live), numbers, left * right))
        a, b = number // right, number % right
        return jnp.where(
            _gone(rows[:, None], reached, a, b, alike), jnp.uint32(0), live
        ), jnp.where(rows == a, b, partner)

    start = (ranks, jnp.full(left, right, jnp.int32))
    return lax.while_loop(more, take, settled(take, start))[1]


def outranking(place: Array, rank: Array, best: Array) -> Array:
    """Returns the ranks of those that are greater than any that another statement has drawn for their place, and 0 for the others.

    Args:
      place: `[M]` int32. rank: `[M]` uint32. best: `[size]` uint32, see `best_ranks`.
    """
    return jnp.where(rank > best[place], rank, jnp.uint32(0))


def best_ranks(place: Array, rank: Array, best: Array) -> Array:
    """Returns the greatest rank drawn for each place so far, `[size]` uint32, of `best` and those given; 0 where nobody writes."""
    return best.at[place].max(rank)


def drawn_by_lot(place: Array, rank: Array, size: int) -> Array:
    """Returns which of M writers write: of those with one place the one of the greatest rank, of equal ones the first.

    Args:
      place: `[M]` int32, 0 .. size - 1. rank: `[M]` uint32, 0 for those who do not write.
    Returns:
      `[M]` bool.
    """
    number = jnp.arange(place.shape[0], dtype=jnp.int32)
    best = jnp.zeros(size, jnp.uint32).at[place].max(rank)
    top = (rank > 0) & (rank == best[place])
    first = (
        jnp.full(size, place.shape[0], jnp.int32)
        .at[place]
        .min(jnp.where(top, number, place.shape[0]))
    )
    result: Array = number == first[place]
    return result
