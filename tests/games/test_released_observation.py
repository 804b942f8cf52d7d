"""The variant `socialjax` tells apart what the released observation tells apart, and the page of the games lists what else is different."""

from pathlib import Path

import pytest

from sjdsl.compiler import build, ir
from sjdsl.compiler.lower import token_planes
from sjdsl.compiler.syntax.read import read_source
from sjdsl.interop.socialjax_table import NOT_HERE, Entry, channels_of, entries
from sjdsl.interpreter.planes import planes
from sjdsl.library.games_folder import find_game
from sjdsl.runtime.planes import channel_names

PAGE = Path(__file__).parent.parent.parent / "docs" / "games.md"
# How cells look, beside what is outside the map or a wall, alike there. Source: tile channels of the released code; `floor` and `grass`
# are cells without any, `covered` those under agents, where something is that would be seen.
LOOKS = {
    "coins": {"floor", "mine", "theirs"},
    **{f"harvest_{form}": {"floor", "apple"} for form in ("open", "closed", "partnership")},
    "clean_up": {"grass", "apple", "channel", "water state=clean", "water state=dirty", "covered"},
    "coop_mining": {
        "rock ore=none",
        "camp",
        "rock ore=iron",
        "rock ore=gold",
        "rock ore=partial",
        "covered",
    },
    "mushrooms": {f"ground grows={kind}" for kind in ("none", "red", "green", "blue", "orange")},
    "gift_refinement": {"floor", "token"},
    "pd_arena": {"floor", "coop", "defect"},
}
# Released code: beams leave marks, but not the ray of miners; of agents only the bags of the arena are shown. Ours: one's own heading, of
# which the released window tells a half.
PLANES = {
    "coins": ["content", "agent", "agent.heading"],
    "coop_mining": ["content", "agent", "agent.heading"],
    "pd_arena": [
        "content",
        "agent",
        "marks",
        *(f"everyone[{agent}].bag[{word}]" for word in ("coop", "defect") for agent in range(4)),
        "agent.heading",
    ],
}
HEADINGS = (
    "agent: self",
    "agent: other same heading",
    "agent: other turned right",
    "agent: other opposite",
    "agent: other turned left",
)
OWN_HEADING = tuple(
    f"agent.heading: {way}" for way in ("north", "east", "south", "west")
)  # in the page's row on windows


def released_game(name: str) -> ir.Game:
    """Returns the rules of a game as released."""
    return build(read_source(find_game(name)), ("socialjax",)).game


def unread(entry: Entry, game: ir.Game) -> list[str]:
    """Returns our channels that say more than the released ones."""
    read = {
        name
        for source in [*entry.tiles, *entry.rest]
        for name in channels_of(source, game.agents.number)
    }
    read |= {name for layer in entry.layers for name in layer}
    known = {
        *read,
        *HEADINGS,
        *OWN_HEADING,
        "agent: none",
        *(f"content: {look}" for look in entry.plain),
    }
    return [name for name in channel_names(token_planes(game)) if name not in known]


@pytest.mark.parametrize("game", LOOKS)
def test_looks_and_planes_are_the_released_ones(game: str) -> None:
    shown = planes(released_game(game))
    assert set(shown[0].labels) == {"outside", *LOOKS[game]}
    assert [plane.name for plane in shown] == PLANES.get(
        game, ["content", "agent", "marks", "agent.heading"]
    )


@pytest.mark.parametrize("theirs", entries())
def test_every_channel_is_in_the_table_or_in_the_program(theirs: str) -> None:
    entry = entries()[theirs]
    game = released_game(entry.game)
    read = [
        name
        for source in [*entry.tiles, *entry.rest]
        for name in channels_of(source, game.agents.number)
    ]
    assert set(read) <= set(channel_names(token_planes(game)))
    assert len(set(read)) == len(read)
    assert unread(entry, game) == []
    less = {"tiles": entry.tiles[1:]} if entry.tiles else {"layers": entry.layers[:-1]}
    assert unread(entry.model_copy(update=less), game) != []


def test_the_page_has_what_no_channel_of_ours_shows() -> None:
    page = PAGE.read_text(encoding="utf-8")
    for entry in entries().values():
        for source in entry.rest:
            assert (
                f"| {source.removeprefix(NOT_HERE)} | shown | not shown |" in page
                or not source.startswith(NOT_HERE)
            )
