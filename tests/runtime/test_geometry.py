"""Tables of a map against loops over its cells, on random maps."""

import numpy as np
import pytest

from sjdsl.runtime import geometry

from . import references
from .references import DIRECTIONS, cells

PADS = (2, 5)
Lanes = list[list[tuple[int, int]]]  # (ahead, right), nearest first
BEAM: Lanes = [[(1, -1)], [(1, 0), (2, 0)], [(1, 1)]]
FAR: Lanes = [
    [(0, -1), (1, -1)],
    [(1, 0), (2, 0)],
    [(0, 1), (1, 1)],
    [(-1, 0), (-2, 0)],
    [(2, 2)],
    [(1, -2)],
]


def maps() -> list[tuple[str, ...]]:
    random = np.random.default_rng(0)
    sizes = [(1, 1), (1, 6), (6, 1), (3, 3), (4, 7), (8, 5)]
    return [tuple("".join(row) for row in random.choice(list("..#AB"), size)) for size in sizes]


MAPS = pytest.mark.parametrize("rows", maps(), ids=lambda rows: f"{len(rows)}x{len(rows[0])}")
EACH_PAD = pytest.mark.parametrize("pad", PADS)


def number(rows: tuple[str, ...], pad: int, row: int, col: int) -> int:
    """Returns the cell of the padded frame."""
    return (row + pad) * (len(rows[0]) + 2 * pad) + col + pad


def is_inside(rows: tuple[str, ...], row: int, col: int) -> bool:
    return 0 <= row < len(rows) and 0 <= col < len(rows[0])


@MAPS
@EACH_PAD
def test_cells_of_kinds(rows: tuple[str, ...], pad: int) -> None:
    height, width = geometry.frame_size(rows, pad)
    assert (height, width) == (len(rows) + 2 * pad, len(rows[0]) + 2 * pad)
    found = geometry.cells_of(rows, pad, "AB")
    assert found.dtype == np.int32
    assert found.tolist() == [number(rows, pad, r, c) for r, c, g in cells(rows) if g in "AB"]
    on_map, walls = np.zeros(height * width, bool), np.zeros(height * width, bool)
    looks = np.zeros(height * width, np.uint8)
    for r, c, g in cells(rows):
        on_map[number(rows, pad, r, c)] = True
        walls[number(rows, pad, r, c)] = g == "#"
        looks[number(rows, pad, r, c)] = 1 + ".#AB".index(g)
    np.testing.assert_array_equal(geometry.inside(rows, pad), on_map)
    np.testing.assert_array_equal(geometry.blocking(rows, pad, "#"), walls)
    np.testing.assert_array_equal(
        geometry.painted(rows, pad, {g: 1 + i for i, g in enumerate(".#AB")}), looks
    )
    assert geometry.painted(rows, pad, dict.fromkeys(".#AB", 1)).dtype == np.uint8


@MAPS
@EACH_PAD
def test_site_numbers(rows: tuple[str, ...], pad: int) -> None:
    """Cells of the kind count from 0 in reading order; all others have the number past the end."""
    kind = geometry.cells_of(rows, pad, "A")
    table = geometry.site_numbers(rows, pad, kind)
    numbers = iter(range(len(kind)))
    expected = dict.fromkeys(range(table.size), len(kind)) | {
        number(rows, pad, r, c): next(numbers) for r, c, g in cells(rows) if g == "A"
    }
    assert table.tolist() == [expected[cell] for cell in range(table.size)]


@MAPS
def test_numbers_of_a_group(rows: tuple[str, ...]) -> None:
    """A group's cells in reading order: each one's number among a kind, and its place if the kinds follow each other."""
    group = [g for _, _, g in cells(rows) if g in "AB"]
    of_a = iter(range(len(group)))
    expected = [next(of_a) if g == "A" else group.count("A") for g in group]
    assert geometry.numbers_among(rows, "AB", "A").tolist() == [*expected, group.count("A")]
    together = [
        (g, i) for kind in "BA" for i, g in enumerate(group) if g == kind
    ]  # first all of B, then all of A
    assert geometry.reading_order(rows, ("B", "A")).tolist() == [
        together.index((g, i)) for i, g in enumerate(group)
    ]


def test_values_of_glyphs() -> None:
    assert geometry.values_of(("AB.", "BA#"), {"A": 0, "B": 3}, "uint8").tolist() == [0, 3, 3, 0]


@MAPS
@EACH_PAD
def test_next_cells(rows: tuple[str, ...], pad: int) -> None:
    """One cell on, but not off the map and not into a wall; who stands in a wall can leave it; the padding leads nowhere."""
    table = geometry.next_cells(rows, pad, "#").reshape(-1, 4)
    for cell in np.flatnonzero(~geometry.inside(rows, pad)):
        assert table[cell].tolist() == [cell] * 4
    for r, c, _ in cells(rows):
        for heading, (dr, dc) in enumerate(DIRECTIONS):
            to = (r + dr, c + dc)
            free = is_inside(rows, *to) and rows[to[0]][to[1]] != "#"
            assert table[number(rows, pad, r, c), heading] == number(
                rows, pad, *(to if free else (r, c))
            )


def expected_reach(rows: tuple[str, ...], lanes: Lanes, pose: tuple[int, int, int]) -> list[bool]:
    """Returns for each shape cell whether it is on the map and not behind a wall of its lane."""
    seen = []
    for lane in lanes:
        open_ = True
        for ahead, right in lane:
            r, c = references.seen_cell(*pose, ahead, right)
            there = is_inside(rows, r, c)
            seen.append(open_ and there)
            open_ = open_ and not (there and rows[r][c] == "#")
    return seen


@MAPS
@pytest.mark.parametrize(("lanes", "dtype"), [(BEAM, np.uint8), (FAR, np.uint32)])
def test_lanes_of_a_shape(rows: tuple[str, ...], lanes: Lanes, dtype: type) -> None:
    """Offsets for each heading, and which cells are reached; up to 8 cells are kept in a byte."""
    pad, flat = 5, [cell for lane in lanes for cell in lane]
    offsets = geometry.shape_offsets(rows, pad, flat)
    table = geometry.lane_reach(rows, pad, offsets, [len(lane) for lane in lanes], "#")
    assert table.dtype == dtype
    bits = table.reshape(-1, 4)
    for r, c, _ in cells(rows):
        here = number(rows, pad, r, c)
        for heading in range(4):
            wanted = [
                number(rows, pad, *references.seen_cell(r, c, heading, ahead, right))
                for ahead, right in flat
            ]
            assert (here + offsets[heading]).tolist() == wanted
            reach = [bool(bits[here, heading] >> k & 1) for k in range(len(flat))]
            assert reach == expected_reach(rows, lanes, (r, c, heading))
    assert not bits[~geometry.inside(rows, pad)].any()


@MAPS
def test_neighbours_and_their_masks(rows: tuple[str, ...]) -> None:
    """The 12 cells of a disc of radius 2: which are of the kind, walls between or not."""
    pad = 3
    disc = [(a, c) for a in range(2, -3, -1) for c in range(-2, 3) if 0 < a * a + c * c <= 4]
    kind = geometry.cells_of(rows, pad, "A")
    around = geometry.neighbours(
        kind, geometry.site_numbers(rows, pad, kind), geometry.shape_offsets(rows, pad, disc)
    )
    assert around.shape == (len(kind), 12)
    places = [(r, c) for r, c, g in cells(rows) if g == "A"]
    masks = geometry.near_masks(around, len(kind))
    for site, (r, c) in enumerate(places):
        near = {i for i, (r2, c2) in enumerate(places) if 0 < (r - r2) ** 2 + (c - c2) ** 2 <= 4}
        assert {int(n) for n in around[site] if n < len(kind)} == near
        assert {
            i for i in range(len(kind)) if masks[i // 32, site] >> np.uint32(i % 32) & np.uint32(1)
        } == near
