"""The map files show the published figures: sizes, cells of each kind, places, and what lies near what."""

from collections import Counter
from typing import NamedTuple

import pytest

from .map_reading import MAPS, Cell, box, disc, find, read_map, regions, span

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


# Clean Up: the river


def test_clean_up_river_is_one_body_of_167_cells_that_reaches_the_orchard():
    # SocialJax map, Clean Up: the dirt fraction is taken over all 167 river cells.
    river = find("clean_up", "HFS")
    assert len(river) == 167
    assert regions(river) == [river]
    assert max(river) == (14, 20)


# Walls: Coop Mining and PD Arena


# Passages, starts and resources


def test_gift_refinement_is_coop_mining_without_its_border():
    # SocialJax map, Gift Refinement: the same plan, tokens where the other game has ore.
    inside = [line[1:-1].replace("O", "T") for line in read_map("coop_mining")[1:-1]]
    assert list(read_map("gift_refinement")) == inside
