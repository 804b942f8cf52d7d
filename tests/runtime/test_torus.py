"""Maps that wrap: tables and kernels against loops over rows and columns taken modulo the size of the map."""

import itertools

import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.runtime import geometry
from sjdsl.runtime.egocentric_windows import windows
from sjdsl.runtime.path_search import board, wrapped
from sjdsl.runtime.steering import gains
from sjdsl.runtime.torus import cells_on, joined_edges, shorter_way

DIRECTIONS = ((-1, 0), (0, 1), (1, 0), (0, -1))
SIZES = [(1, 1), (1, 4), (2, 3), (4, 5)]
PAD = 6


def number(row: int, col: int, size: tuple[int, int]) -> int:
    """Returns the cell of the padded frame at a place of the map, which may lie beyond its edges."""
    return (row % size[0] + PAD) * (size[1] + 2 * PAD) + col % size[1] + PAD


def places(size: tuple[int, int]) -> list[tuple[int, int]]:
    return list(itertools.product(range(size[0]), range(size[1])))


def blank(size: tuple[int, int]) -> tuple[str, ...]:
    return tuple("." * size[1] for _ in range(size[0]))


def steps(a: int, b: int, length: int) -> int:
    """Returns how often one must step, one way or the other, until b is reached."""
    return min(next(n for n in range(length) if (a + way * n) % length == b) for way in (1, -1))


@pytest.mark.parametrize("length", range(1, 8))
def test_the_shorter_way(length: int) -> None:
    found = shorter_way(jnp.arange(-length + 1, length), length)
    for difference, way in zip(range(-length + 1, length), np.asarray(found), strict=True):
        assert (way - difference) % length == 0
        assert abs(way) == steps(0, difference % length, length)
        assert 2 * way != -length  # of two equal ways the positive one


@pytest.mark.parametrize("size", SIZES)
def test_cells_on_and_next_cells(size: tuple[int, int]) -> None:
    rows = blank(size)
    table = geometry.next_cells(rows, PAD, "#", wraps=True)
    starts = jnp.array([number(row, col, size) for row, col in places(size)])
    found = cells_on(
        starts[:, None, None], jnp.arange(4)[None, :, None], jnp.arange(9)[None, None], *size, PAD
    )
    for at, (row, col) in enumerate(places(size)):
        for heading, by in enumerate(DIRECTIONS):
            assert table[4 * number(row, col, size) + heading] == number(
                row + by[0], col + by[1], size
            )
            assert found[at, heading].tolist() == [
                number(row + n * by[0], col + n * by[1], size) for n in range(9)
            ]


@pytest.mark.parametrize("size", SIZES)
def test_no_shape_has_a_cell_twice(size: tuple[int, int]) -> None:
    """Each lane goes on at the other side, until it would come to a cell of the shape, or to where it begins."""
    shape = [(a, c) for c in (-2, 0, 2) for a in range(1, 6)]
    rows = blank(size)
    around = geometry.around_edges(rows, PAD)
    offsets = geometry.shape_offsets(rows, PAD, shape, wraps=True)
    for (row, col), heading in itertools.product(places(size), range(4)):
        ahead, right = DIRECTIONS[heading], DIRECTIONS[(heading + 1) % 4]
        wanted: list[int] = []
        for a, c in shape:
            cell = number(
                row + a * ahead[0] + c * right[0], col + a * ahead[1] + c * right[1], size
            )
            wanted.append(1 if cell in (number(row, col, size), *wanted) else cell)
        assert around[number(row, col, size) + offsets[heading]].tolist() == wanted


def test_walls_end_lanes_round_the_edge() -> None:
    rows, lanes = ("..#.",), [5]
    offsets = geometry.shape_offsets(rows, PAD, [(n, 0) for n in range(1, 6)], wraps=True)
    reach = geometry.lane_reach(rows, PAD, offsets, lanes, "#", wraps=True)
    west = reach[4 * number(0, 1, (1, 4)) + 3]  # columns 0, 3, 2; not 1, where it began
    assert [n for n in range(5) if west >> n & 1] == [0, 1, 2]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("heading", range(4))
def test_windows_repeat_the_map(size: tuple[int, int], heading: int) -> None:
    cells = np.arange(1, 1 + size[0] * size[1], dtype=np.uint8).reshape(size)
    frame = np.zeros((size[0] + 2 * PAD, size[1] + 2 * PAD), np.uint8)
    frame[PAD:-PAD, PAD:-PAD] = cells
    view = {"ahead": 5, "behind": 1, "left": 2, "right": 3}
    own = geometry.own_cells(blank(size), **view)
    far = geometry.view_steps_around(blank(size), **view)
    ahead, right = DIRECTIONS[heading], DIRECTIONS[(heading + 1) % 4]
    row, col = places(size)[-1]
    seen = windows(
        joined_edges(jnp.asarray(frame), PAD),
        jnp.array([number(row, col, size)]),
        jnp.array([heading]),
        **view,
    )
    offsets = [(a, c) for a in range(5, -2, -1) for c in range(-2, 4)]
    for at, (a, c) in enumerate(offsets):
        place = (
            (row + a * ahead[0] + c * right[0]) % size[0],
            (col + a * ahead[1] + c * right[1]) % size[1],
        )
        assert int(seen[0, at]) == cells[place]
        assert own[heading, at] == (place == (row, col))
        assert far[heading, at] == steps(row, place[0], size[0]) + steps(col, place[1], size[1])


@pytest.mark.parametrize("size", SIZES)
def test_what_movers_gain_by_a_step(size: tuple[int, int]) -> None:
    here, goals = places(size)[0], places(size)
    cells = jnp.array([[number(*goal, size)] for goal in goals])
    start = jnp.full(len(goals), number(*here, size))
    found = np.asarray(gains(start, cells, jnp.ones_like(cells, bool), size[1] + 2 * PAD, size))
    for goal, gained in zip(goals, found, strict=True):

        def far(row: int, col: int, goal: tuple[int, int] = goal) -> int:
            return steps(row % size[0], goal[0], size[0]) + steps(col % size[1], goal[1], size[1])

        assert gained.tolist() == [
            far(here[0] + r, here[1] + c) - far(*here) for r, c in DIRECTIONS
        ]


@pytest.mark.parametrize("size", [(3, 4), (2, 33), (5, 64)])
def test_boards_are_rolled(size: tuple[int, int]) -> None:
    cells = np.random.default_rng(0).random(size) < 0.3
    for rows, cols in ((0, 1), (-1, 0), (2, -3), (7, 70)):
        rolled = board(jnp.asarray(np.roll(cells, (rows, cols), (0, 1))))
        np.testing.assert_array_equal(
            wrapped(board(jnp.asarray(cells)), rows, cols, size[1]), rolled
        )
