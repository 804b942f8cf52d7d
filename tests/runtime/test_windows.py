"""Windows, painted cells and packed planes against cutting and stacking cell by cell."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.runtime.egocentric_windows import (
    fill,
    look_fields,
    look_number,
    paint,
    planes_of,
    windows,
)

from . import references

pytestmark = pytest.mark.usefixtures("form")

CUT = jax.jit(windows, static_argnames=("ahead", "behind", "left", "right"))
PAINT = jax.jit(paint)

# frame (rows, cols), then cells seen ahead, behind, to the left and to the right
VIEWS = [
    ((9, 9), (3, 1, 2, 2)),
    ((9, 14), (3, 1, 2, 2)),
    ((13, 8), (0, 2, 3, 1)),
    ((7, 20), (3, 0, 0, 3)),
    ((5, 5), (0, 0, 0, 0)),
    ((16, 11), (5, 3, 1, 4)),
]


def naive(
    plane: np.ndarray, row: int, col: int, heading: int, view: tuple[int, int, int, int]
) -> np.ndarray:
    ahead, behind, left, right = view
    window = np.zeros((ahead + 1 + behind, left + 1 + right), plane.dtype)
    for r in range(window.shape[0]):
        for c in range(window.shape[1]):
            window[r, c] = plane[references.seen_cell(row, col, heading, ahead - r, c - left)]
    return window


@pytest.mark.parametrize(("frame", "view"), VIEWS)
def test_windows_from_every_cell_and_heading(
    frame: tuple[int, int], view: tuple[int, int, int, int]
) -> None:
    """Every cell that far from the frame's edge, in all four headings, each cell of the frame with its own value."""
    rows, cols = frame
    ahead, behind, left, right = view
    plane = np.arange(rows * cols, dtype=np.uint8).reshape(frame)
    far = max(view)
    poses = [
        (r, c, h) for r in range(far, rows - far) for c in range(far, cols - far) for h in range(4)
    ]
    assert poses
    row, col, heading = np.array(poses).T
    found = CUT(
        jnp.asarray(plane),
        jnp.asarray(row * cols + col, jnp.int32),
        jnp.asarray(heading, jnp.int32),
        ahead=ahead,
        behind=behind,
        left=left,
        right=right,
    )
    assert found.dtype == jnp.uint8
    np.testing.assert_array_equal(
        found, np.stack([naive(plane, *pose, view).reshape(-1) for pose in poses])
    )


def test_forward_is_up_and_right_is_right() -> None:
    """A hand-made case: what one who looks east has around it."""
    plane = jnp.array(
        [[0, 0, 0, 0, 0], [0, 1, 2, 3, 0], [0, 4, 5, 6, 0], [0, 7, 8, 9, 0], [0, 0, 0, 0, 0]],
        jnp.uint8,
    )
    seen = CUT(plane, jnp.array([12]), jnp.array([1]), ahead=1, behind=1, left=1, right=1)
    assert seen.reshape(3, 3).tolist() == [[3, 6, 9], [2, 5, 8], [1, 4, 7]]


@pytest.mark.parametrize("length", [1, 3, 4, 9])
def test_fill_alone_and_in_batches(length: int) -> None:
    """Short runs and long ones, at both ends and side by side with one cell between."""
    cells = np.array([c for c in range(40) if c % (length + 1) != length], np.int32)
    planes, values = (
        np.arange(120, dtype=np.uint8).reshape(3, 40),
        200 + np.arange(3 * cells.size, dtype=np.uint8).reshape(3, -1) % 50,
    )
    wanted = planes.copy()
    wanted[:, cells] = values
    alone = jax.jit(lambda plane, value: fill(plane, cells, value))
    np.testing.assert_array_equal(alone(jnp.asarray(planes[0]), jnp.asarray(values[0])), wanted[0])
    both = jax.jit(jax.vmap(lambda plane, value: fill(plane, cells, value)))
    np.testing.assert_array_equal(both(planes, values), wanted)
    of_values = jax.jit(jax.vmap(lambda value: fill(jnp.asarray(planes[0]), cells, value)))
    constant = np.asarray(of_values(jnp.asarray(values)))
    np.testing.assert_array_equal(constant[:, cells], values)
    np.testing.assert_array_equal(
        constant[1], np.where(np.isin(np.arange(40), cells), wanted[1], planes[0])
    )
    many = of_values(np.tile(values, (10, 1)))
    np.testing.assert_array_equal(many, np.tile(constant, (10, 1)))
    of_planes = jax.jit(jax.vmap(lambda plane: fill(plane, cells, jnp.asarray(values[0]))))
    np.testing.assert_array_equal(
        np.asarray(of_planes(np.tile(planes, (10, 1))))[-3:, cells], values[[0] * 3]
    )
    twice = jax.vmap(both)(jnp.asarray([planes, planes]), jnp.asarray([values, values]))
    np.testing.assert_array_equal(twice, [wanted, wanted])


def test_paint_adds_bits() -> None:
    plane = jnp.array([1, 2, 4, 8, 0], jnp.uint8)
    assert PAINT(plane, jnp.array([1, 3, 1], jnp.int32), 4).tolist() == [1, 6, 4, 12, 0]
    assert (
        PAINT(plane, jnp.array([2, 2], jnp.int32), 4).tolist() == plane.tolist()
    )  # what is there already stays once
    assert PAINT(
        plane, jnp.array([4, 0], jnp.int32), jnp.array([0x70, 0x80], jnp.uint8)
    ).tolist() == [0x81, 2, 4, 8, 0x70]
    assert PAINT(plane, jnp.zeros(3, jnp.int32), 128).tolist() == [129, 2, 4, 8, 0]
    assert PAINT(plane, jnp.array([], jnp.int32), 128).tolist() == plane.tolist()


@pytest.mark.parametrize("number", range(1, 10))
def test_planes_side_by_side(number: int) -> None:
    planes = np.random.default_rng(number).integers(1, 256, (number, 3, 35)).astype(np.uint8)
    found = planes_of((5, 7), None, *(jnp.asarray(p) for p in planes))
    assert found.dtype == jnp.uint8
    np.testing.assert_array_equal(found, np.stack(planes, axis=1).reshape(3, number, 5, 7))
    without = planes_of((5, 7), jnp.array([True, False, True]), *(jnp.asarray(p) for p in planes))
    np.testing.assert_array_equal(
        without, np.where([[[[True]]], [[[False]]], [[[True]]]], found, 0)
    )


@pytest.mark.parametrize(
    ("first", "sizes"), [(3, (3, 3, 10)), (0, (2,)), (200, (7, 8)), (93, (163,))]
)
def test_looks_are_numbered_and_taken_apart(first: int, sizes: tuple[int, ...]) -> None:
    """Each combination of values has its number, in the order in which they are counted; all other numbers are no looks of the kind."""
    values = np.indices(sizes).reshape(len(sizes), -1)
    numbers = jax.jit(look_number, static_argnums=(0, 1))(first, sizes, *map(jnp.asarray, values))
    assert numbers.dtype == jnp.uint8
    assert numbers.tolist() == list(range(first, first + values.shape[1]))
    there, *found = jax.jit(look_fields, static_argnums=(1, 2))(
        jnp.arange(256, dtype=jnp.uint8), first, sizes
    )
    assert np.flatnonzero(there).tolist() == numbers.tolist()
    assert [np.asarray(f)[np.asarray(there)].tolist() for f in found] == values.tolist()
