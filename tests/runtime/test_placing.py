"""Sending, choosing and pairing against sorted lists."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.runtime.actions import ANY_HEADING, SAME_HEADING
from sjdsl.runtime.forms import forced
from sjdsl.runtime.placing import (
    choose,
    come_back,
    member_of,
    pair,
    pair_reached,
    pick,
    pick_of_set,
    pick_of_sets,
    place,
)
from sjdsl.runtime.random_bits import random_bits

from . import references

PLACE = jax.jit(jax.vmap(place, in_axes=(None, 0, 0, 0, 0)))
PLACE_FITTING = jax.jit(jax.vmap(place, in_axes=(None, 0, 0, 0, 0, 0)))
CHOOSE = jax.jit(jax.vmap(choose))


def same_in_both_forms(kernel: Callable[..., Any], *arrays: Any) -> list[np.ndarray]:
    """Returns what a kernel gives in the form for CPUs, and compares that for GPUs with it."""
    found = [np.asarray(array) for array in kernel(*arrays)]
    with forced("gpu"):
        for array, expected in zip(kernel(*arrays), found, strict=True):
            np.testing.assert_array_equal(array, expected)
    return found


def sizes(usual: list[tuple], more: list[tuple]) -> list:
    """Returns parameters: small, large and uneven sizes; more of them come with the thorough tests."""
    return [*usual, *(pytest.param(*size, marks=pytest.mark.thorough) for size in more)]


def random_ranks(random: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    """Returns ranks of which a third are 0 (not free) and many are equal."""
    few = random.integers(1, 4, shape)
    return np.choose(
        random.integers(0, 3, shape),
        [np.zeros(shape, int), few, random.integers(1, 2**31 + 1, shape)],
    )


@pytest.mark.parametrize(
    ("cells", "agents"),
    sizes([(4, 2), (60, 7)], [(1, 1), (1, 3), (3, 5), (6, 6), (9, 20), (200, 20), (300, 3)]),
)
def test_place(cells: int, agents: int) -> None:
    """Distinct free cells, for agents in id order, each by its own word; who finds none stays."""
    random = np.random.default_rng(100 * cells + agents)
    cases = 150
    site = np.sort(random.permutation(400)[:cells]) + 1
    free = random.random((cases, cells)) < random.choice([0, 0.1, 0.7, 1], (cases, 1))
    word = random.integers(0, 2**32, (cases, agents))
    position = random.integers(500, 600, (cases, agents))
    sent = random.random((cases, agents)) < random.choice([0, 0.5, 1], (cases, 1))
    arrays = (
        jnp.asarray(free),
        jnp.asarray(word, jnp.uint32),
        jnp.asarray(position, jnp.int32),
        jnp.asarray(sent),
    )
    found, placed = same_in_both_forms(PLACE, jnp.asarray(site, jnp.int32), *arrays)
    assert (found.dtype, placed.dtype) == (jnp.int32, jnp.bool_)
    for case in range(cases):
        expected = references.place(
            site.tolist(), *(x[case].tolist() for x in (free, word, position, sent))
        )
        assert (found[case].tolist(), placed[case].tolist()) == expected


@pytest.mark.parametrize(("cells", "agents"), [(1, 3), (3, 5), (60, 7)])
def test_place_fitting(cells: int, agents: int) -> None:
    """Each agent chooses among the free cells that fit it."""
    random = np.random.default_rng(100 * cells + agents)
    cases = 60
    site = np.arange(cells) + 1
    free = random.random((cases, cells)) < 0.7
    own = random.random((cases, agents, cells)) < random.choice([0.1, 0.5, 1], (cases, 1, 1))
    word = random.integers(0, 2**32, (cases, agents))
    position = random.integers(500, 600, (cases, agents))
    sent = random.random((cases, agents)) < 0.7
    arrays = [
        jnp.asarray(x) for x in (free, word.astype(np.uint32), position.astype(np.int32), sent, own)
    ]
    found, placed = same_in_both_forms(PLACE_FITTING, jnp.asarray(site, jnp.int32), *arrays)
    for case in range(cases):
        left, expected, done = free[case].copy(), position[case].tolist(), [False] * agents
        for agent in np.flatnonzero(sent[case]):
            fitting = np.flatnonzero(left & own[case, agent]).tolist()
            if fitting:
                cell = references.turn_of(int(word[case, agent]), fitting)
                left[cell], expected[agent], done[agent] = False, int(site[cell]), True
        assert (found[case].tolist(), placed[case].tolist()) == (expected, done)
    everything = jnp.ones_like(own)
    same = PLACE_FITTING(jnp.asarray(site, jnp.int32), *arrays[:-1], jnp.asarray(everything))
    assert all(
        (x == y).all()
        for x, y in zip(same, PLACE(jnp.asarray(site, jnp.int32), *arrays[:-1]), strict=True)
    )


@pytest.mark.parametrize("dtype", [jnp.int32, jnp.uint8])
def test_come_back(dtype: jnp.dtype) -> None:
    """To the cells that `place` gives: with a drawn heading, the one it had, or one that was given; who finds none stays away."""
    cells, position = jnp.array([10, 20, 30], jnp.int32), jnp.array([0, 0, 0, 0, 7], jnp.int32)
    back, free, key = (
        jnp.array([True, True, True, True, False]),
        jnp.ones(3, bool),
        jnp.array([3, 4], jnp.uint32),
    )
    facing = jnp.array([ANY_HEADING, SAME_HEADING, 2, 2, 2], jnp.int32)
    words, turns = random_bits(key, 8, 5), random_bits(key, 9, 5)
    where = (words, turns, position, jnp.full(5, 1, dtype), facing)
    drawn = int(turns[0] >> 30)
    assert drawn != 1
    new, heading, placed = jax.jit(come_back)(cells, free, back, *where)
    assert new.tolist() == place(cells, free, words, position, back)[0].tolist()
    assert (heading.tolist(), placed.tolist()) == (
        [drawn, 1, 2, 1, 1],
        [True, True, True, False, False],
    )
    assert heading.dtype == dtype
    own = jnp.eye(5, 3, dtype=bool)[jnp.array([2, 0, 3, 1, 0])]
    new, _, placed = jax.jit(come_back)(cells, free, back, *where, own)
    assert (new.tolist(), placed.tolist()) == ([30, 10, 0, 20, 7], [True, True, False, True, False])


@pytest.mark.usefixtures("form")
@pytest.mark.parametrize(
    "members",
    [1, 33, 600, *(pytest.param(size, marks=pytest.mark.thorough) for size in (2, 6, 32, 147))],
)
def test_pick(members: int) -> None:
    """One of the members; nobody if there are none."""
    random = np.random.default_rng(members)
    member = random.random((200, members)) < random.choice([0, 0.05, 0.5, 1], (200, 1))
    word = np.concatenate([random.integers(0, 2**32, 196), [0, 1, 2**32 - 1, 2**31]])
    number, found = map(
        np.asarray, jax.jit(jax.vmap(pick))(jnp.asarray(member), jnp.asarray(word, jnp.uint32))
    )
    assert (number.dtype, found.dtype) == (jnp.int32, jnp.bool_)
    for case in range(200):
        there = np.flatnonzero(member[case]).tolist()
        assert bool(found[case]) == bool(there)
        assert not there or int(number[case]) == references.turn_of(int(word[case]), there)


@pytest.mark.parametrize("dtype", [jnp.uint8, jnp.uint32])
def test_pick_of_set(dtype: jnp.dtype) -> None:
    """A set kept as bits is the same as its members spelt out."""
    size = jnp.iinfo(dtype).bits
    random = np.random.default_rng(size)
    sets = np.concatenate([random.integers(0, 2**size, 300), [0, 1, 2 ** (size - 1), 2**size - 1]])
    word = jnp.asarray(random.integers(0, 2**32, len(sets)), jnp.uint32)
    number, found = jax.jit(pick_of_set)(jnp.asarray(sets, dtype), word)
    expected, there = jax.jit(pick)(jnp.asarray((sets[:, None] >> np.arange(size)) & 1 != 0), word)
    assert found.tolist() == there.tolist()
    assert (
        np.asarray(number)[np.asarray(there)].tolist()
        == np.asarray(expected)[np.asarray(there)].tolist()
    )


@pytest.mark.thorough
@pytest.mark.parametrize("batched", ["no", "sets", "keys", "both", "twice"])
@pytest.mark.parametrize(
    ("several", "form"), [(None, "cpu"), (5, "cpu"), (40, "cpu"), (69, "cpu"), (40, "gpu")]
)
def test_pick_of_many_sets(several: int | None, form: str, batched: str) -> None:
    """As one set at a time with its word, whether words are drawn or not, whichever set has several, whatever of a batch differs."""
    size = 70
    random = np.random.default_rng(size)
    sets = random.choice([0, 1, 2, 4, 128], (3, size))
    sets[1, 5] = 8
    if several is not None:
        sets[1, several] = 0b1011
    keys = jnp.asarray(random.integers(0, 2**32, (3, 2)), jnp.uint32)
    draw = lambda key: random_bits(key, 0x1234, size)  # noqa: E731
    picked = lambda members, key: pick_of_sets(members, key, draw)  # noqa: E731
    sets = jnp.asarray(sets, jnp.uint8)
    axes = {"sets": (0, None), "keys": (None, 0), "both": (0, 0), "twice": (0, 0)}.get(batched)
    function = picked if axes is None else jax.vmap(picked, in_axes=axes)
    function = jax.vmap(function) if batched == "twice" else function
    given_sets = sets if axes and axes[0] == 0 else sets[1]
    given_keys = keys if axes and axes[1] == 0 else keys[1]
    if batched == "twice":
        given_sets, given_keys = given_sets[None], given_keys[None]
    with forced(form):
        alone = jax.jit(function)(given_sets, given_keys).reshape(-1, size)
    number, found = np.asarray(jax.jit(member_of)(alone)), np.asarray(alone) != 0
    one = jax.jit(lambda members, key: pick_of_set(members, draw(key)))
    for row in range(len(number)):
        mine, key = (
            given_sets.reshape(-1, size)[row % given_sets.reshape(-1, size).shape[0]],
            given_keys.reshape(-1, 2)[row % given_keys.reshape(-1, 2).shape[0]],
        )
        expected, there = one(mine, key)
        assert found[row].tolist() == there.tolist()
        assert number[row][found[row]].tolist() == np.asarray(expected)[np.asarray(there)].tolist()
    assert alone.dtype == np.uint8


@pytest.mark.parametrize(
    ("members", "turns"), sizes([(1, 1), (6, 3), (40, 8)], [(2, 5), (100, 20)])
)
def test_choose(members: int, turns: int) -> None:
    random = np.random.default_rng(members)
    cases = 200
    member = random.random((cases, members)) < random.choice([0, 0.3, 1], (cases, 1))
    word, number = random.integers(0, 2**32, (cases, turns)), random.integers(-1, turns + 1, cases)
    arrays = jnp.asarray(member), jnp.asarray(word, jnp.uint32), jnp.asarray(number, jnp.int32)
    (found,) = same_in_both_forms(lambda *given: (CHOOSE(*given),), *arrays)
    for case in range(cases):
        assert found[case].tolist() == references.choose(
            member[case].tolist(), word[case].tolist(), int(number[case])
        )


@pytest.mark.parametrize(("members", "turns"), sizes([(6, 3), (40, 8)], [(100, 20)]))
def test_choose_by_chance(members: int, turns: int) -> None:
    """Those that `choose` picks draw the numbers that they would draw if all members did."""
    random = np.random.default_rng(members)
    cases, stream = 100, 0xC1BDC6E0
    member, keys = random.random((cases, members)) < 0.7, random.integers(0, 2**32, (cases, 2))
    word, number, limit = (
        random.integers(0, 2**32, (cases, turns)),
        random.integers(-1, turns + 1, cases),
        random.integers(0, 2**31 + 1, cases),
    )
    by_chance = jax.vmap(lambda *given: choose(*given[:-1], stream, given[-1]))
    types = (bool, jnp.uint32, jnp.int32, jnp.uint32, jnp.uint32)
    arrays = [
        jnp.asarray(array, kind)
        for array, kind in zip((member, word, number, keys, limit), types, strict=True)
    ]
    (found,) = same_in_both_forms(lambda *given: (by_chance(*given),), *arrays)
    for case, key in enumerate(keys.tolist()):
        picked = references.choose(member[case].tolist(), word[case].tolist(), int(number[case]))
        drawn = [
            references.threefry(tuple(key), (stream, place // 2))[place % 2] // 2
            for place in range(members)
        ]
        assert found[case].tolist() == [
            one and less < limit[case] for one, less in zip(picked, drawn, strict=True)
        ]


@pytest.mark.parametrize(
    ("left", "right", "alike"),
    sizes(
        [(1, 1, False), (3, 5, False), (5, 5, True)],
        [(1, 1, True), (5, 3, False), (2, 2, True), (4, 4, True), (7, 7, True)],
    ),
)
def test_pair(left: int, right: int, alike: bool) -> None:
    """Best pair first, nobody twice, and no pair left over whose two sides are free."""
    random = np.random.default_rng(10 * left + right)
    cases = 150
    rank = random_ranks(random, (cases, left, right)) * (
        random.random((cases, left, right)) < random.choice([0.3, 1], (cases, 1, 1))
    )
    if alike:
        rank = rank * ~np.eye(left, dtype=bool)
    paired = jax.jit(jax.vmap(lambda r: (pair(r, alike),)))
    (found,) = same_in_both_forms(paired, jnp.asarray(rank, jnp.uint32))
    for case in range(cases):
        assert found[case].tolist() == references.pair(rank[case].tolist(), alike)


@pytest.mark.parametrize(
    ("left", "right", "alike"),
    sizes(
        [(3, 5, False), (5, 5, True)], [(1, 1, False), (6, 3, False), (2, 2, True), (7, 7, True)]
    ),
)
@pytest.mark.parametrize("few", [1, 3])
def test_pair_reached_is_pair(left: int, right: int, alike: bool, few: int) -> None:
    """With the ranks of those who are reached: often the same, some reached twice, some places empty."""
    random = np.random.default_rng(100 * left + 10 * right + few)
    cases = 200
    reached = random.integers(0, right + 1, (cases, left, few))  # `right` is nobody
    table = np.concatenate(
        [random_ranks(random, (cases, left, right)), np.zeros((cases, left, 1), np.int64)], axis=2
    )
    if alike:
        table[:, range(left), range(left)] = 0
    rank = np.take_along_axis(table, reached, axis=2)
    paired = jax.jit(jax.vmap(lambda b, r: (pair_reached(b, r, right, alike),)))
    (found,) = same_in_both_forms(
        paired, jnp.asarray(reached, jnp.int32), jnp.asarray(rank, jnp.uint32)
    )
    for case in range(cases):
        pairs = [
            [int(table[case, a, b]) if b in reached[case, a] else 0 for b in range(right)]
            for a in range(left)
        ]
        assert found[case].tolist() == references.pair(pairs, alike)
