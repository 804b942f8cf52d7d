"""How many agents a game can have: the same as by trying every number, with few tries."""

import pytest

from sjdsl.compiler import build_composition
from sjdsl.compiler.compose import Composition, compose
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.elaborate import Overrides
from sjdsl.library.agent_range import agent_range

GAME = """sj 1
game small "Small" {
  size most : count = 7
  size players : count = 4 in LIMITS
  episode 10
  kind floor "."
  kind gate "g"
  map { "gggggggggg....." }
  agents players { acts stay }
  phase start { each agent as a { send a to PLACE } }
  schedule tick
  MORE
}
"""


def small(limits: str, place: str = "floor", more: str = "") -> Composition:
    return compose(Source("small.sj", GAME.replace("LIMITS", limits).replace("PLACE", place).replace("MORE", more)))


def by_trying_all(game: Composition, most: int = 16) -> list[int]:
    """Returns every number of agents that compiles, of those up to one that no map here has room for."""

    def compiles(number: int) -> bool:
        try:
            return build_composition(game, Overrides(num_agents=number)).game.agents.number == number
        except CompileError:
            return False

    return [number for number in range(1, most + 1) if compiles(number)]


@pytest.mark.parametrize(
    ("game", "expected"),
    [
        (small("1 .. 9"), (1, 5)),
        (small("2 .. 5"), (2, 5)),
        (small("4 .. 4"), (4, 4)),
        (small("2 .. most", "gate"), (2, 7)),
        (small("most - 4 .. 2 * most", "gate"), (3, 10)),
        (small("1 .. 9", "gate", "checks { require players % 2 == 0 }"), (2, 8)),
        (small("1 .. 64", "gate", "checks { require players > 2 }"), (3, 10)),
        (small("1 .. 64", "floor where floor.row == 0"), (1, 5)),
        (small("1 .. 64", "gate where a.index == 0 or gate.col > 3"), (1, 6)),
    ],
)
def test_small_games(game: Composition, expected: tuple[int, int]) -> None:
    accepted = by_trying_all(game)
    assert (min(accepted), max(accepted)) == expected
    assert agent_range(game) == ("players", *expected)
