"""The variant `socialjax` tells apart what the released observation tells apart."""

import pytest

from sjdsl.compiler import build, ir
from sjdsl.compiler.syntax.read import read_source
from sjdsl.interpreter.planes import planes
from sjdsl.library.games_folder import find_game

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


def released_game(name: str) -> ir.Game:
    """Returns the rules of a game as released."""
    return build(read_source(find_game(name)), ("socialjax",)).game


@pytest.mark.parametrize("game", LOOKS)
def test_looks_and_planes_are_the_released_ones(game: str) -> None:
    shown = planes(released_game(game))
    assert set(shown[0].labels) == {"outside", *LOOKS[game]}
    assert [plane.name for plane in shown] == PLANES.get(
        game, ["content", "agent", "marks", "agent.heading"]
    )
