"""Counting by bits, who stands where, rows and lanes, against loops."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.runtime.bits import (
    as_bits,
    from_bits,
    has_member,
    pack,
    size_of_large_set,
    size_of_set,
    unpack,
)
from sjdsl.runtime.counting import (
    count_near,
    occupied,
    segment_sum,
    times_in,
)
from sjdsl.runtime.geometry import near_masks
from sjdsl.runtime.line_of_sight import reached
from sjdsl.runtime.rows import entry, mix, one_hot


@pytest.mark.parametrize(
    ("members", "sites"), [(1, 1), (31, 4), (32, 5), (33, 6), (64, 64), (147, 20)]
)
def test_count_near(members: int, sites: int) -> None:
    """Any neighbours at all, also of cells of another kind; `members` stands for no neighbour."""
    random = np.random.default_rng(members)
    around = np.array([[*random.permutation(members)[:7], members, members] for _ in range(sites)])
    masks = near_masks(around, members)
    assert (masks.shape, masks.dtype) == ((-(-members // 32), sites), np.uint32)
    for _ in range(10):
        member = random.random(members) < random.random()
        found = count_near(jnp.asarray(member), jnp.asarray(masks))
        assert found.dtype == jnp.int32
        assert found.tolist() == [
            sum(bool(member[n]) for n in row if n < members) for row in around
        ]


@pytest.mark.usefixtures("form")
@pytest.mark.parametrize(
    "agents",
    [8, 32, *(pytest.param(agents, marks=pytest.mark.thorough) for agents in (1, 6, 9, 20))],
)
@pytest.mark.parametrize(
    "sets",
    [
        1,
        165,
        *(pytest.param(sets, marks=pytest.mark.thorough) for sets in (31, 32)),
        pytest.param(538, marks=pytest.mark.slow),
    ],
)
def test_times_in_sets(agents: int, sets: int) -> None:
    """Sparse sets, full ones (as many as bytes are added up to), in rows and what is left over, and batches."""
    member = (
        np.random.default_rng(agents * sets).random((3, sets, agents))
        < np.array([0.1, 0.6, 1.0])[:, None, None]
    )
    kept = (
        (member.astype(np.uint64) << np.arange(agents, dtype=np.uint64))
        .sum(axis=-1)
        .astype(np.uint8 if agents <= 8 else np.uint32)
    )
    wanted = np.array(
        [[sum(bool(row[agent]) for row in rows) for agent in range(agents)] for rows in member]
    )
    found = jax.jit(jax.vmap(lambda one: times_in(one, agents)))(kept)
    assert found.dtype == jnp.int32
    np.testing.assert_array_equal(found, wanted)
    np.testing.assert_array_equal(times_in(jnp.asarray(kept[1]), agents), wanted[1])
    np.testing.assert_array_equal(size_of_set(jnp.asarray(kept)), member.sum(axis=-1))


@pytest.mark.usefixtures("form")
def test_occupied() -> None:
    assert occupied(jnp.array([1, 3, 1, 4, 4], jnp.int32), 4).tolist() == [False, True, False, True]


@pytest.mark.usefixtures("form")
@pytest.mark.parametrize("dtype", ["bool", "int32", "float32"])
@pytest.mark.parametrize("shape", [(9,), (3, 4)])
def test_segment_sum(shape: tuple[int, ...], dtype: str) -> None:
    """Numbers that no segment has count for none."""
    random = np.random.default_rng(2)
    numbers, amounts = random.integers(-1, 6, shape), random.integers(0, 9, shape).astype(dtype)
    result = segment_sum(jnp.asarray(amounts), jnp.asarray(numbers, jnp.int32), 4)
    assert result.dtype == (jnp.int32 if dtype == "bool" else dtype)
    assert result.tolist() == [amounts[numbers == one].sum() for one in range(4)]


def test_one_hot() -> None:
    numbers = jnp.array([[2, 0], [5, 1]], jnp.uint8)
    np.testing.assert_array_equal(one_hot(numbers, 3), np.eye(6, 3, dtype=bool)[numbers])
    assert one_hot(1, 3).tolist() == [False, True, False]


@pytest.mark.parametrize("shape", [(), (3,), (2, 4)])
def test_entry(shape: tuple[int, ...]) -> None:
    random = np.random.default_rng(len(shape))
    row, key = random.integers(-9, 9, (*shape, 5)), random.integers(0, 5, shape)
    found = entry(jnp.asarray(row, jnp.int32), jnp.asarray(key, jnp.uint8))
    np.testing.assert_array_equal(found, np.take_along_axis(row, key[..., None], -1)[..., 0])


def test_mix() -> None:
    """Each share is a float32 quotient; a row of zeros is not asked for."""
    row = np.array([[1, 2], [0, 3], [100, 1]])
    expected = row.astype(np.float32) / row.sum(axis=1, keepdims=True).astype(np.float32)
    found = mix(jnp.asarray(row, jnp.int32))
    assert found.dtype == jnp.float32
    np.testing.assert_array_equal(found, expected)
    assert np.isfinite(mix(jnp.zeros((1, 2), jnp.int32))).all()


@pytest.mark.parametrize(("dtype", "most"), [(jnp.uint8, 8), (jnp.uint32, 32)])
def test_sets_as_bits_and_back(dtype: jnp.dtype, most: int) -> None:
    random = np.random.default_rng(most)
    for agents in (1, most - 1, most):
        members = random.random((6, agents)) < 0.5
        found = jax.jit(as_bits, static_argnums=1)(jnp.asarray(members), dtype)
        assert found.dtype == dtype
        assert found.tolist() == [sum(2**i for i in range(agents) if row[i]) for row in members]
        unpacked = jax.jit(from_bits, static_argnums=1)
        np.testing.assert_array_equal(unpacked(found, agents), members)
        np.testing.assert_array_equal(unpacked(found[0], agents), members[0])
    assert as_bits(jnp.ones(most, bool), dtype).tolist() == 2**most - 1


@pytest.mark.parametrize("agents", [33, 40, 64])
def test_large_sets(agents: int) -> None:
    """Sets kept in several words, against Python's; nobody, -1, is in none."""
    random = np.random.default_rng(agents)
    members = random.random((5, agents)) < 0.5
    words = jax.jit(pack)(jnp.asarray(members))
    assert (words.shape, words.dtype) == ((5, 2), jnp.uint32)
    together = [int(low) + (int(high) << 32) for low, high in np.asarray(words)]
    assert together == [sum(2**i for i in range(agents) if row[i]) for row in members]
    np.testing.assert_array_equal(jax.jit(unpack, static_argnums=1)(words, agents), members)
    assert jax.jit(size_of_large_set)(words).tolist() == members.sum(axis=1).tolist()
    everybody = jnp.arange(-1, agents, dtype=jnp.int32)
    contains = jax.jit(has_member)
    found = contains(words[:, None], everybody[None])
    np.testing.assert_array_equal(found, np.pad(members, ((0, 0), (1, 0))))
    assert contains(words[0], jnp.int32(agents - 1)).tolist() == members[0, -1]


@pytest.mark.parametrize(
    "lanes", [[1, 3, 2, 4], [20, 15, 5]], ids=["few", "more than a word has bits"]
)
def test_reached(lanes: list[int]) -> None:
    """Lane by lane: the blocking cell is the last one reached; a cell off the map neither is reached nor ends its lane."""
    random = np.random.default_rng(6)
    first = np.concatenate([[True] + [False] * (n - 1) for n in lanes])
    blocked, on_map = random.random((300, first.size)) < 0.3, random.random((300, first.size)) < 0.7
    found = np.asarray(
        jax.jit(lambda *of: reached(*of, first))(jnp.asarray(blocked), jnp.asarray(on_map))
    )
    for case in range(300):
        expected, number = [], 0
        for length in lanes:
            open_ = True
            for _ in range(length):
                expected.append(bool(open_ and on_map[case, number]))
                open_ = open_ and not (on_map[case, number] and blocked[case, number])
                number += 1
        assert found[case].tolist() == expected
