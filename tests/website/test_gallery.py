"""The pages of the gallery: what a game's page says beside its board."""

import json
from pathlib import Path

from website import gallery

ROOT = Path(__file__).parents[2]


def page_of(name: str) -> str:
    (shown,) = (shown for shown in gallery.shown_games() if shown.name == name)
    return gallery.game_page(shown, ROOT)


def test_a_page_has_the_stored_figures_of_random_play() -> None:
    """Of Coins; the equality of its returns isn't defined, as some of them are negative."""
    stored = json.loads((ROOT / "docs/games.json").read_text("utf-8"))["coins"]
    page = page_of("coins")
    assert f"{stored['episodes']} episodes from seed {stored['seed']}" in page
    figures = stored["values"]["`own_coins`, in an episode, all agents"]
    mean, low, high = (f"{figures[end]:.1f}" for end in ("mean", "low", "high"))
    assert f"| `own_coins`, in an episode, all agents | {mean} [{low}, {high}] |" in page
    undefined = "not defined: some returns are negative, or all are 0"
    assert f"| equality of returns (1 - Gini) | {undefined} |" in page


def test_a_game_of_melting_pot_has_no_figures_of_random_play() -> None:
    stored = json.loads((ROOT / "docs/games.json").read_text("utf-8"))
    assert "daycare" not in stored
    assert "## Random play" not in page_of("daycare")


def test_a_substrate_has_a_title() -> None:
    """The game's, and which form of the game it is, unless that title says so."""
    page = gallery.gallery_page()
    assert "**[Boat Race: Eight Races](boat_race.md)**" in page
    assert "**[Chemistry: two metabolic cycles](chemistry.md#variant-two)**" in page
    assert "`" not in page
    assert "<code>" not in page
