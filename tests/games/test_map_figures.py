"""The map files show every figure that is known about the maps of the published games, and of those with more starts."""

from collections import Counter
from itertools import product
from typing import NamedTuple

import pytest

from .map_reading import MAPS, Cell, Cells, box, disc, find, read_map, region, regions, span

HARVESTS = ("harvest_open", "harvest_closed", "harvest_partnership")
ROOMED = ("harvest_closed", "harvest_partnership")

# Every map: size, number of cells of each kind, one connected field


class Figures(NamedTuple):
    rows: int
    cols: int
    glyphs: dict[str, int]


FIGURES = {
    # SocialJax map, Coins: 174 coin cells and two starts, no walls.
    "coins": Figures(16, 11, {"C": 174, "P": 2}),
    # SocialJax maps, Harvest: 64 apples, 2 inner starts; 60 outer starts in Open and 19 in the others; 0, 68, 54 walls.
    "harvest_open": Figures(16, 22, {"A": 64, "P": 60, "Q": 2, ".": 226}),
    "harvest_closed": Figures(16, 22, {"A": 64, "P": 19, "Q": 2, "#": 68, ".": 199}),
    "harvest_partnership": Figures(16, 22, {"A": 64, "P": 19, "Q": 2, "#": 54, ".": 213}),
    # SocialJax map, Clean Up: 147 dirt-capable cells, 79 of them dirty, 20 plain river, 122 orchard cells, 19 starts.
    "clean_up": Figures(19, 28, {"H": 68, "F": 79, "S": 20, "B": 122, "P": 19, ".": 224}),
    # SocialJax map, Coop Mining: 104 border and 69 interior walls, 538 ore cells, 18 starts, no plain floor.
    "coop_mining": Figures(27, 27, {"#": 104 + 69, "O": 538, "P": 18}),
    # SocialJax map, Mushrooms: 3 red, 3 green, 3 blue, 1 orange, no walls.
    "mushrooms": Figures(12, 23, {"R": 3, "G": 3, "B": 3, "O": 1, ".": 266}),
    # SocialJax map, Gift Refinement: Coop Mining's plan without its border, nor the two stray columns.
    "gift_refinement": Figures(25, 25, {"#": 69, "T": 538, "P": 18}),
    # SocialJax map, PD Arena: 94 border and 15 interior walls, 64 starts, 6 cooperate and 6 defect resources.
    "pd_arena": Figures(24, 25, {"#": 94 + 15, "P": 64, "C": 6, "D": 6, ".": 415}),
    # Melting Pot maps, Commons Harvest Closed and Partnership: 60 outer starts, all else as above.
    "harvest_closed_crowd": Figures(16, 22, {"A": 64, "P": 60, "Q": 2, "#": 68, ".": 158}),
    "harvest_partnership_crowd": Figures(16, 22, {"A": 64, "P": 60, "Q": 2, "#": 54, ".": 172}),
    # ours: 20 starts for the 20 agents of the paper's speed table, the one or two cells more taken from the plain or growing ones.
    "clean_up_crowd": Figures(19, 28, {"H": 68, "F": 79, "S": 20, "B": 122, "P": 20, ".": 223}),
    "coop_mining_crowd": Figures(27, 27, {"#": 104 + 69, "O": 536, "P": 20}),
    "gift_refinement_crowd": Figures(25, 25, {"#": 69, "T": 536, "P": 20}),
}
PUBLISHED = [game for game in FIGURES if not game.endswith("_crowd")]


def test_no_map_of_these_games_is_forgotten():
    """Other games have their figures with their own tests."""
    assert len(PUBLISHED) == 9
    assert {
        path.stem for path in MAPS.iterdir() if path.stem.removesuffix("_crowd") in PUBLISHED
    } == set(FIGURES)


@pytest.mark.parametrize(("game", "figures"), FIGURES.items())
def test_size_and_line_ends(game: str, figures: Figures):
    lines = (MAPS / f"{game}.txt").read_bytes().split(b"\n")
    assert [len(line) for line in lines] == [figures.cols] * figures.rows + [0]


@pytest.mark.parametrize(("game", "figures"), FIGURES.items())
def test_number_of_cells_of_each_kind(game: str, figures: Figures):
    assert Counter("".join(read_map(game))) == figures.glyphs


@pytest.mark.parametrize("game", FIGURES)
def test_all_free_cells_are_connected(game: str):
    free = find(game, "".join(FIGURES[game].glyphs).replace("#", ""))
    assert regions(free) == [free]


# Cells whose place is known one by one

CLOSED_GATES = box([13], range(2, 19, 2)) | box([14], range(1, 20, 2))
DOORWAYS = frozenset({(10, 9), (10, 12)})
FUNNEL = (
    box([8], span(6, 15))
    | box([9, 11], [10, 11])
    | (box([10], span(0, 21)) - DOORWAYS)
    | box([12], span(2, 19))
)
THIN_ORCHARD = box([14], [*range(1, 18, 2), 23, 25, 27])
ORCHARD = THIN_ORCHARD | box(span(15, 18), span(0, 27)) - box([15], [19, 20])
CLEAN_UP_GATES = {
    6: (3, 8), 7: (5, 11, 15, 24), 8: (13, 17), 9: (3, 8, 25), 10: (15, 22), 11: (5, 17), 12: (11, 23), 13: (2, 16),
}  # fmt: skip
FOUR_CORNERS = box([*span(1, 4), *span(19, 22)], [*span(1, 4), *span(20, 23)])

PLACES = [
    # SocialJax map, Coins: the starts are one cell in from two opposite corners.
    ("coins", "P", {(1, 1), (14, 9)}),
    # SocialJax maps, Harvest: inner starts beside the side diamonds, the same in all three.
    *((game, "Q", {(6, 6), (6, 15)}) for game in HARVESTS),
    # SocialJax map, Harvest Open: outer starts fill a trapezoid at the far side.
    ("harvest_open", "P", box([13], span(2, 19)) | box([14], span(1, 20)) | box([15], span(0, 21))),
    # SocialJax maps, Harvest Closed and Partnership: outer starts on alternate cells of two rows.
    *((game, "P", CLOSED_GATES) for game in ROOMED),
    # SocialJax map, Harvest Closed: a double wall between the rooms, a shared lower part.
    ("harvest_closed", "#", box(span(0, 7), [10, 11]) | FUNNEL),
    # SocialJax map, Harvest Partnership: of the double wall only one row stays.
    ("harvest_partnership", "#", box([6], [10, 11]) | FUNNEL),
    # SocialJax map, Clean Up: dirt-capable water is rows 0 to 4 and part of row 5.
    ("clean_up", "HF", box(span(0, 4), span(0, 27)) | box([5], span(16, 22))),
    # SocialJax map, Clean Up: the channel runs from the water down to the orchard.
    ("clean_up", "S", {(5, 15), (6, 21)} | box(span(6, 14), [19, 20])),
    # SocialJax map, Clean Up: the orchard fills the bottom five rows, thinly in row 14, but for the channel's mouth.
    ("clean_up", "B", ORCHARD),
    # SocialJax map, Clean Up: starts on the sand between water and orchard.
    ("clean_up", "P", {(row, col) for row, cols in CLEAN_UP_GATES.items() for col in cols}),
    # SocialJax map, PD Arena: four blocks of 4 x 4 starts just inside the corners.
    ("pd_arena", "P", FOUR_CORNERS),
]


@pytest.mark.parametrize(("game", "glyphs", "cells"), PLACES)
def test_cells_of_known_place(game: str, glyphs: str, cells: set[Cell]):
    assert find(game, glyphs) == cells


# Harvest: patches, rooms, mirror

DIAMONDS = (
    (2, 7),
    (2, 14),
    (7, 2),
    (7, 19),
)  # SocialJax maps, Harvest: centres of the four 13-cell patches
CORNERS = ((0, 0), (0, 21))  # SocialJax maps, Harvest: the two 6-cell patches


@pytest.mark.parametrize("game", HARVESTS)
def test_harvest_apples_are_four_diamonds_and_two_corner_triangles(game: str):
    on_map = box(span(0, 15), span(0, 21))
    patches = [disc(centre, 2) & on_map for centre in DIAMONDS + CORNERS]
    assert [len(patch) for patch in patches] == [13, 13, 13, 13, 6, 6]
    apples = find(game, "A")
    assert apples == frozenset().union(*patches)
    # SocialJax maps, Harvest: no apple has a neighbour in another patch, so an emptied patch stays empty.
    assert not [cell for patch in patches for cell in patch if disc(cell, 2) & (apples - patch)]


@pytest.mark.parametrize("game", HARVESTS)
def test_harvest_neighbours_of_a_full_map(game: str):
    apples = find(game, "A")
    near = Counter(len(disc(cell, 2) & apples) - 1 for cell in apples)
    # SocialJax maps, Harvest: apples within distance 2, centre left out: number of such cells.
    assert near == {3: 4, 4: 20, 5: 4, 7: 32, 12: 4}


class Room(NamedTuple):
    game: str
    inside: Cell
    size: int
    apples: int
    doorways: set[Cell]


ROOMS = [
    # SocialJax map, Harvest Closed: two rooms of 96 free cells and 32 apples, one doorway each.
    Room("harvest_closed", (0, 0), 96, 32, {(10, 9)}),
    Room("harvest_closed", (0, 21), 96, 32, {(10, 12)}),
    # SocialJax map, Harvest Partnership: one room of 206 free cells with every apple, two doorways.
    Room("harvest_partnership", (0, 0), 206, 64, {(10, 9), (10, 12)}),
    # SocialJax maps, Harvest Closed and Partnership: starts and corridors are 90 free cells, the bottom row included.
    Room("harvest_closed", (15, 0), 90, 0, {(10, 9), (10, 12)}),
    Room("harvest_partnership", (15, 0), 90, 0, {(10, 9), (10, 12)}),
]


@pytest.mark.parametrize("room", ROOMS, ids=lambda room: f"{room.game}-{room.inside}")
def test_harvest_rooms_and_their_doorways(room: Room):
    free = find(room.game, ".APQ")
    assert free >= DOORWAYS
    cells = region(free - DOORWAYS, room.inside)
    assert len(cells) == room.size
    assert len(cells & find(room.game, "A")) == room.apples
    assert {door for door in DOORWAYS if disc(door, 1) & cells} == room.doorways


@pytest.mark.parametrize(
    ("game", "glyphs"),
    [
        ("harvest_open", "AQP"),
        # SocialJax maps, Harvest: the two halves mirror each other (the alternate outer starts cannot).
        ("harvest_closed", "AQ#"),
        ("harvest_partnership", "AQ#"),
        ("mushrooms", "RGBO"),  # ours: no side is the better one
    ],
)
def test_left_and_right_mirror_each_other(game: str, glyphs: str):
    last = FIGURES[game].cols - 1
    for glyph in glyphs:
        cells = find(game, glyph)
        assert {(row, last - col) for row, col in cells} == cells


# Clean Up: the river

# SocialJax map, Clean Up: clean and dirty cells of each water row at the start.
WATER_ROWS = [(0, 12, 16), (1, 13, 15), (2, 13, 15), (3, 13, 15), (4, 11, 17), (5, 6, 1)]


@pytest.mark.parametrize(("row", "clean", "dirty"), WATER_ROWS)
def test_clean_up_dirt_of_each_row(row: int, clean: int, dirty: int):
    line = Counter(read_map("clean_up")[row])
    assert (line["H"], line["F"]) == (clean, dirty)


def test_clean_up_dirt_alternates_and_is_denser_at_both_ends():
    # SocialJax map, Clean Up: roughly every second column dirty, more at the ends; in row 5 only the first water cell.
    lines = read_map("clean_up")[:5]
    assert not [line for line in lines if "HH" in line]
    ends = [
        Counter("".join(line[part] for line in lines))["F"] for part in (slice(0, 4), slice(24, 28))
    ]
    middle = Counter("".join(line[4:24] for line in lines))["F"]
    assert min(ends) / 20 > middle / 100
    assert read_map("clean_up")[5][16] == "F"


def test_clean_up_river_is_one_body_of_167_cells_that_reaches_the_orchard():
    # SocialJax map, Clean Up: the dirt fraction is taken over all 167 river cells.
    river = find("clean_up", "HFS")
    assert len(river) == 167
    assert regions(river) == [river]
    assert max(river) == (14, 20)


# Walls: Coop Mining and PD Arena


class Wall(NamedTuple):
    """One interior wall: our drawing of the shape described, and the rows and columns it keeps to."""

    drawing: tuple[str, ...]
    rows: range
    cols: range
    times: int = 1

    def is_drawn_by(self, piece: Cells) -> bool:
        """Tells whether a piece of wall has this shape and lies in this part of the map."""
        top, left = min(row for row, _ in piece), min(col for _, col in piece)
        lines = enumerate(self.drawing, start=top)
        drawn = {
            (row, col)
            for row, line in lines
            for col, mark in enumerate(line, start=left)
            if mark == "#"
        }
        return piece == drawn and piece <= box(self.rows, self.cols)


HOOK = ("#.....", "#.....", "#....#", "#....#", "#....#", "######")
STEP_AND_DIAGONAL = (
    "###.....",
    "..##....",
    "...##...",
    "....##..",
    ".....##.",
    "......##",
    ".......#",
)
DIAGONAL_AND_BAR = ("#......", ".#.....", "..#....", "...####")
CROSS = ("...#...", "#######", "...#...", "...#...", "...#...")

# SocialJax map, Coop Mining: ten groups of interior walls, each with its shape, size and part of the 27 x 27 cells.
MINING_WALLS = {
    "hook of 14, upper left of the centre": Wall(HOOK, span(3, 12), span(4, 13)),
    "step and diagonal of 14, left of the centre": Wall(
        STEP_AND_DIAGONAL, span(9, 18), span(3, 12)
    ),
    "short diagonal and bar, near the centre": Wall(DIAGONAL_AND_BAR, span(10, 16), span(10, 18)),
    "cross, lower right": Wall(CROSS, span(14, 24), span(14, 24)),
    "flat bar of 8, right of the centre": Wall(("########",), span(9, 17), span(14, 24)),
    "upright bar of 4, near the right side": Wall(("#",) * 4, span(3, 23), span(20, 23)),
    "upright bar of 3, near the right side": Wall(("#",) * 3, span(3, 23), span(20, 23)),
    "upright bar of 3, lower left": Wall(("#",) * 3, span(14, 23), span(3, 12)),
    "flat bar of 3": Wall(("###",), span(3, 23), span(3, 23)),
    "flat bar of 2": Wall(("##",), span(3, 23), span(3, 23)),
}

# SocialJax map, PD Arena: eight pieces of interior wall in 24 x 25 cells, row 0 and column 0 being border.
ARENA_WALLS = {
    "two stubs, top centre": Wall(("#",), span(1, 1), span(8, 16), times=2),
    "flat pair, left of the centre": Wall(("##",), span(7, 16), span(5, 11)),
    "upright pair, near the centre": Wall(("#", "#"), span(9, 14), span(9, 15)),
    "corner, on the left border": Wall(("#.", "##"), span(6, 17), span(1, 2)),
    "pair, on the right border": Wall(("##",), span(6, 17), span(22, 23)),
    "L of three, lower right": Wall(("#.", "##"), span(13, 22), span(13, 22)),
    "one cell, near the bottom": Wall(("#",), span(19, 22), span(5, 19)),
}

WALLS = [("coop_mining", MINING_WALLS), ("pd_arena", ARENA_WALLS)]


def border(game: str) -> Cells:
    """Returns the outermost ring of a map."""
    rows, cols = FIGURES[game].rows, FIGURES[game].cols
    return box(range(rows), range(cols)) - box(range(1, rows - 1), range(1, cols - 1))


def inner_walls(game: str) -> list[Cells]:
    """Returns the pieces of wall inside the border; cells that touch at a corner belong together."""
    return regions(find(game, "#") - border(game), diagonal=True)


@pytest.mark.parametrize("game", ["coop_mining", "pd_arena"])
def test_border_is_closed(game: str):
    assert border(game) <= find(game, "#")


@pytest.mark.parametrize(
    ("game", "name", "wall"), [(game, *item) for game, walls in WALLS for item in walls.items()]
)
def test_inner_wall_is_as_described(game: str, name: str, wall: Wall):
    assert len([piece for piece in inner_walls(game) if wall.is_drawn_by(piece)]) == wall.times, (
        name
    )


@pytest.mark.parametrize(
    ("game", "sizes"),
    [
        ("coop_mining", [2, 3, 3, 3, 4, 7, 8, 11, 14, 14]),  # SocialJax map, Coop Mining
        ("pd_arena", [1, 1, 1, 2, 2, 2, 3, 3]),  # SocialJax map, PD Arena
    ],
)
def test_sizes_of_the_inner_walls(game: str, sizes: list[int]):
    assert sorted(len(piece) for piece in inner_walls(game)) == sizes


# Passages, starts and resources


def test_coop_mining_has_wide_passages():
    # SocialJax map, Coop Mining: passages are wide; ours: a block of two by two cells can go everywhere.
    free = find("coop_mining", "OP")
    blocks = frozenset(
        cell for cell in free if box(span(cell[0], cell[0] + 1), span(cell[1], cell[1] + 1)) <= free
    )
    assert regions(blocks) == [blocks]
    assert {
        (row + down, col + right) for row, col in blocks for down in (0, 1) for right in (0, 1)
    } == free


def test_coop_mining_starts():
    # SocialJax map, Coop Mining: 5 starts in the second free column from the left, 6 from the right, 7 between.
    starts = find("coop_mining", "P")
    columns = Counter({2: "left", 24: "right"}.get(col, "between") for _, col in starts)
    assert columns == {"left": 5, "right": 6, "between": 7}
    # SocialJax map, Coop Mining: none adjacent to another; ours: nor across a corner, and some in every quarter.
    assert len(regions(starts, diagonal=True)) == 18
    assert {(row < 13, col < 13) for row, col in starts if 3 < col < 23} == set(
        product([True, False], repeat=2)
    )


def test_gift_refinement_is_coop_mining_without_its_border():
    # SocialJax map, Gift Refinement: the same plan, tokens where the other game has ore.
    inside = [line[1:-1].replace("O", "T") for line in read_map("coop_mining")[1:-1]]
    assert list(read_map("gift_refinement")) == inside


def test_mushrooms_are_scattered():
    # SocialJax map, Mushrooms: no two of the ten are adjacent; ours: not across a corner either.
    mushrooms = find("mushrooms", "RGBO")
    assert len(regions(mushrooms, diagonal=True)) == 10


def test_pd_arena_resources_are_two_stacked_pairs_of_rows():
    # SocialJax map, PD Arena: right of centre defect over cooperate; a bit left of it and lower cooperate over defect.
    lines = enumerate(read_map("pd_arena"))
    found = [
        (run, row, line.find(run)) for row, line in lines for run in ("CCC", "DDD") if run in line
    ]
    runs, rows, cols = zip(*found)
    assert runs == ("DDD", "CCC", "CCC", "DDD")
    assert (rows[1] - rows[0], rows[3] - rows[2]) == (1, 1)
    assert cols[0] == cols[1] > 12
    assert cols[0] - 4 <= cols[2] == cols[3] < cols[0]
    # SocialJax map, PD Arena: in the middle; ours: the middle third of the rows and columns.
    assert find("pd_arena", "CD") <= box(span(8, 15), span(8, 17))
