"""The maps for 20 agents: what they change, cell by cell, and that 20 agents find room at the start and when they are sent home."""

import pytest

from sjdsl.compiler import build
from sjdsl.compiler.syntax.read import read_source
from sjdsl.library.games_folder import find_game

from .map_reading import Cells, box, find, read_map, regions, span

# Melting Pot maps, Commons Harvest: outer starts fill the same trapezoid in the closed and partnership maps as in the open one.
TRAPEZOID = box([13], span(2, 19)) | box([14], span(1, 20)) | box([15], span(0, 21))
# ours: the starts that are new, and what was there.
NEW = {
    "harvest_closed": (TRAPEZOID - find("harvest_closed", "P"), "."),
    "harvest_partnership": (TRAPEZOID - find("harvest_partnership", "P"), "."),
    "clean_up": (frozenset({(12, 8)}), "."),
    "coop_mining": (frozenset({(8, 17), (20, 9)}), "O"),
    "gift_refinement": (frozenset({(7, 16), (19, 8)}), "T"),
}
CROWD = 20  # paper: the larger number of agents of its speed table
SENT_HOME = ("harvest_open", "harvest_closed", "harvest_partnership", "clean_up")


@pytest.mark.parametrize(
    ("game", "cells", "before"), [(game, *change) for game, change in NEW.items()]
)
def test_only_these_cells_are_new_starts(game: str, cells: Cells, before: str) -> None:
    """All else is as on the game's own map, so what is known of that holds here too."""
    pairs = zip(read_map(game), read_map(f"{game}_crowd"), strict=True)
    changed = {
        (r, c): (a, b)
        for r, (old, new) in enumerate(pairs)
        for c, (a, b) in enumerate(zip(old, new, strict=True))
        if a != b
    }
    assert changed == dict.fromkeys(cells, (before, "P"))


@pytest.mark.parametrize("game", ["clean_up", "coop_mining", "gift_refinement"])
def test_starts_stay_apart(game: str) -> None:
    """Ours: as on the games' own maps, no start touches another, not even at a corner."""
    starts = find(f"{game}_crowd", "P")
    assert len(regions(starts, diagonal=True)) == len(starts)


@pytest.mark.parametrize("game", [*NEW, "harvest_open", "mushrooms"])
def test_twenty_agents_have_room(game: str) -> None:
    """At the start, and where hit agents are sent to even if all are hit at once."""
    source = read_source(find_game(game))
    made = build(source, ("crowd",)).game
    assert made.agents.number == CROWD
    cells = "".join(made.rows)
    starts = cells.count("P") + cells.count("Q") if game != "mushrooms" else cells.count(".")
    assert starts >= CROWD
    if game in SENT_HOME:
        assert cells.count("P") >= CROWD


@pytest.mark.parametrize("game", NEW)
def test_the_variant_has_the_crowded_map_of_its_game(game: str) -> None:
    assert build(read_source(find_game(game)), ("crowd",)).game.rows == read_map(f"{game}_crowd")
