"""`resolve` against the manual's rules carried out agent by agent."""

import itertools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.runtime.forms import forced
from sjdsl.runtime.movement import resolve

from . import references

RESOLVE = jax.jit(jax.vmap(resolve))
ONE = jax.jit(resolve)
LAST = 2**32 - 1


def moved(position: list[int], target: list[int], word: list[int] | None = None) -> list[int]:
    """Returns the kernel's cells, for one case."""
    word = list(range(len(position), 0, -1)) if word is None else [w << 8 for w in word]
    return ONE(
        jnp.array(position, jnp.int32), jnp.array(target, jnp.int32), jnp.array(word, jnp.uint32)
    ).tolist()


def assert_equal_to_reference(position: np.ndarray, target: np.ndarray, word: np.ndarray) -> None:
    """Compares the form for CPUs with the reference, and that for GPUs with it."""
    given = (
        jnp.asarray(position, jnp.int32),
        jnp.asarray(target, jnp.int32),
        jnp.asarray(word, jnp.uint32),
    )
    found = np.asarray(RESOLVE(*given))
    with forced("gpu"):
        np.testing.assert_array_equal(RESOLVE(*given), found)
    for case in range(len(position)):
        said = position[case].tolist(), target[case].tolist(), word[case].tolist()
        assert found[case].tolist() == references.resolve(*said), said


def random_words(random: np.random.Generator, shape: tuple[int, int]) -> np.ndarray:
    """Returns words of which a third are the smallest, a third the largest but for their low bits: many equal ranks."""
    low = random.integers(0, 256, shape)
    return np.choose(
        random.integers(0, 3, shape), [low, LAST - low, random.integers(0, 2**32, shape)]
    )


@pytest.mark.parametrize(
    ("agents", "cases"),
    [(1, 50), *((n, 1500) for n in range(2, 9)), (13, 600), (20, 300), (33, 120)],
)
def test_random_moves(agents: int, cases: int) -> None:
    """Agents on a ring little longer than they are many, each wanting a cell beside its own, its own, or any: crowds, cycles."""
    random = np.random.default_rng(agents)
    length = agents + 1 + agents // 4
    position = np.array([random.permutation(length)[:agents] for _ in range(cases)]) + 1
    step = random.choice([-1, 0, 1, 1], (cases, agents))
    near = (position - 1 + step) % length + 1
    target = np.where(
        random.random((cases, agents)) < 0.7, near, random.integers(1, length + 1, (cases, agents))
    )
    assert_equal_to_reference(position, target, random_words(random, (cases, agents)))


@pytest.mark.parametrize("agents", [4, 7])
def test_random_moves_on_a_grid(agents: int) -> None:
    """Neighbour cells of a crowded 3 x 3 board, as in a game."""
    random = np.random.default_rng(40 + agents)
    cases = 1500
    position = np.array([random.permutation(9)[:agents] for _ in range(cases)])
    row, col = position // 3, position % 3
    heading = random.integers(0, 5, (cases, agents))
    d_row, d_col = np.array([-1, 0, 1, 0, 0])[heading], np.array([0, 1, 0, -1, 0])[heading]
    inside = (row + d_row >= 0) & (row + d_row < 3) & (col + d_col >= 0) & (col + d_col < 3)
    target = np.where(inside, (row + d_row) * 3 + col + d_col, position)
    assert_equal_to_reference(position + 5, target + 5, random_words(random, (cases, agents)))


def test_every_move_of_three_agents_on_four_cells() -> None:
    cases = [
        (p, t, w)
        for p in [(1, 2, 3)]
        for t in itertools.product(range(1, 5), repeat=3)
        for w in itertools.permutations((256, 512, 768))
    ]
    position, target, word = (np.array(column) for column in zip(*cases, strict=True))
    assert_equal_to_reference(position, target, word)


def test_following() -> None:
    """A train moves if its head does, and stands if its head does."""
    assert moved([1, 2, 3, 4], [2, 3, 4, 5]) == [2, 3, 4, 5]
    assert moved([1, 2, 3, 4], [2, 3, 4, 4]) == [1, 2, 3, 4]
    assert moved([4, 3, 2, 1], [5, 4, 3, 2]) == [5, 4, 3, 2]


@pytest.mark.parametrize("agents", [8, 20, 31, 32, 33])
def test_a_train_of_all_agents_is_stopped_by_its_head(agents: int) -> None:
    """The longest way that standing still can spread, in either numbering."""
    line = list(range(1, agents + 1))
    stopped = [*line[1:], line[-1]]
    assert moved(line, stopped) == line
    assert moved(line[::-1], stopped[::-1]) == line[::-1]
    assert moved(line, [c + 1 for c in line]) == [c + 1 for c in line]


def test_cycles() -> None:
    """Three and more go round; two do not change places, and hold up those behind them."""
    assert moved([1, 2, 3], [2, 3, 1]) == [2, 3, 1]
    assert moved([1, 2, 3, 4], [2, 3, 4, 1]) == [2, 3, 4, 1]
    assert moved([1, 2], [2, 1]) == [1, 2]
    assert moved([1, 2, 3, 4], [2, 1, 2, 3]) == [1, 2, 3, 4]


def test_a_cycle_is_broken_by_a_stronger_rival() -> None:
    assert moved([1, 2, 3, 4], [2, 3, 1, 1], [1, 2, 3, 4]) == [
        1,
        2,
        3,
        4,
    ]  # 3 loses cell 1, so 0 and 1 stay, so 3 can not enter
    assert moved([1, 2, 3, 4], [2, 3, 1, 1], [1, 2, 4, 3]) == [2, 3, 1, 4]


def test_a_cell_is_not_entered_when_the_winner_came_from_it() -> None:
    assert moved([1, 2, 3], [5, 5, 1], [2, 1, 0]) == [5, 2, 1]
    assert moved([1, 2, 3], [5, 5, 1], [1, 2, 0]) == [1, 5, 3]


def test_losers_have_no_second_chance() -> None:
    """The winner of a cell that turns out to be taken keeps the others off it, too."""
    assert moved([1, 2, 3, 4], [1, 1, 4, 4], [0, 1, 2, 3]) == [1, 2, 3, 4]
    assert moved([1, 2, 3], [2, 2, 2], [3, 1, 2]) == [1, 2, 3]


def test_agents_who_are_nowhere_stop_nobody() -> None:
    """Several are at cell 0, with cell 0 as their target."""
    assert moved([0, 0, 5, 0, 6], [0, 0, 6, 0, 7]) == [0, 0, 6, 0, 7]
