"""On the maps for 20 agents, all of them find room at the start and when they are sent home."""

import pytest

from sjdsl.compiler import build
from sjdsl.compiler.syntax.read import read_source
from sjdsl.library.games_folder import find_game

from .map_reading import read_map

CROWDED = ("harvest_closed", "harvest_partnership", "clean_up", "coop_mining", "gift_refinement")
CROWD = 20  # paper: the larger number of agents of its speed table
SENT_HOME = ("harvest_open", "harvest_closed", "harvest_partnership", "clean_up")


@pytest.mark.parametrize("game", [*CROWDED, "harvest_open", "mushrooms"])
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


@pytest.mark.parametrize("game", CROWDED)
def test_the_variant_has_the_crowded_map_of_its_game(game: str) -> None:
    assert build(read_source(find_game(game)), ("crowd",)).game.rows == read_map(f"{game}_crowd")
