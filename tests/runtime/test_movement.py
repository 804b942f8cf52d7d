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


def test_every_move_of_three_agents_on_four_cells() -> None:
    cases = [
        (p, t, w)
        for p in [(1, 2, 3)]
        for t in itertools.product(range(1, 5), repeat=3)
        for w in itertools.permutations((256, 512, 768))
    ]
    position, target, word = (np.array(column) for column in zip(*cases, strict=True))
    assert_equal_to_reference(position, target, word)


@pytest.mark.parametrize("agents", [8, 20, 31, 32, 33])
def test_a_train_of_all_agents_is_stopped_by_its_head(agents: int) -> None:
    """The longest way that standing still can spread, in either numbering."""
    line = list(range(1, agents + 1))
    stopped = [*line[1:], line[-1]]
    assert moved(line, stopped) == line
    assert moved(line[::-1], stopped[::-1]) == line[::-1]
    assert moved(line, [c + 1 for c in line]) == [c + 1 for c in line]


# Position, target, words (None: the first has the highest), and where they are then.
MOVES: dict[str, tuple[list[int], list[int], list[int] | None, list[int]]] = {
    "a train follows its head": ([1, 2, 3, 4], [2, 3, 4, 5], None, [2, 3, 4, 5]),
    "and its other end": ([4, 3, 2, 1], [5, 4, 3, 2], None, [5, 4, 3, 2]),
    "or stands with it": ([1, 2, 3, 4], [2, 3, 4, 4], None, [1, 2, 3, 4]),
    "three go round": ([1, 2, 3], [2, 3, 1], None, [2, 3, 1]),
    "four go round": ([1, 2, 3, 4], [2, 3, 4, 1], None, [2, 3, 4, 1]),
    "two do not change places": ([1, 2], [2, 1], None, [1, 2]),
    "and hold up those behind": ([1, 2, 3, 4], [2, 1, 2, 3], None, [1, 2, 3, 4]),
    # agent 2 loses cell 1, so 0 and 1 stay, so 2 cannot enter
    "a stronger rival breaks a cycle": ([1, 2, 3, 4], [2, 3, 1, 1], [1, 2, 3, 4], [1, 2, 3, 4]),
    "a weaker one does not": ([1, 2, 3, 4], [2, 3, 1, 1], [1, 2, 4, 3], [2, 3, 1, 4]),
    "the winner makes room": ([1, 2, 3], [5, 5, 1], [2, 1, 0], [5, 2, 1]),
    "the loser does not": ([1, 2, 3], [5, 5, 1], [1, 2, 0], [1, 5, 3]),
    # the winner of a cell that turns out to be taken keeps the others off it, too
    "losers have no second chance": ([1, 2, 3, 4], [1, 1, 4, 4], [0, 1, 2, 3], [1, 2, 3, 4]),
    "nor after who stays": ([1, 2, 3], [2, 2, 2], [3, 1, 2], [1, 2, 3]),
    "who are nowhere stop nobody": ([0, 0, 5, 0, 6], [0, 0, 6, 0, 7], None, [0, 0, 6, 0, 7]),
}


@pytest.mark.parametrize(("position", "target", "word", "after"), MOVES.values(), ids=MOVES)
def test_moves_by_hand(
    position: list[int], target: list[int], word: list[int] | None, after: list[int]
) -> None:
    assert moved(position, target, word) == after
