"""Streams of draws: made from the phase use and the text of a statement, one for each, whatever else a game says."""

from collections import Counter
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sjdsl.compiler import build, ir
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.compiler.elaborate import statements
from sjdsl.compiler.elaborate.streams import PhaseUse
from sjdsl.compiler.syntax.read import read_source
from sjdsl.library.games_folder import find_game, games_folder, main_games
from tests.fuzz.together import moments, on_numpy, plain, random_play
from tests.verify_ir import verify

FILES = [*map(find_game, main_games()), *sorted((Path(__file__).parents[1] / "cases").glob("*.sj"))]
# Harvest with statements that change nothing: it must play exactly as Harvest.
DULL = """sj 1
game dull "Harvest with idle statements" extends "harvest_open.sj" {
  kind marsh "~" { field depth : { low, high } = low }
  shape far = line(9)
  phase eat {
    each agent on soil where soil.fruit is ripe and 1 < 2 {
      let idle = count(soil as other)
      draw idle_too from 1 .. 6
      chance 0 { give 9 to agent } otherwise chance 1 {
        set soil.fruit = none
        give apple to agent
        tally eaten for agent
      }
    }
    each marsh where marsh.depth is low { set marsh.depth = high }
    when 1 > 2 { give 7 to all }
  }
}
"""


@cache
def game_of(path: Path) -> ir.Game:
    return build(read_source(path)).game


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_draw_has_a_stream_of_its_own(path: Path) -> None:
    verify(game_of(path))


def test_no_statement_is_elaborated_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each time counts as a repeat of its text, so that a second one would change the draws of all that follow with the same text."""
    seen, elaborate = Counter[tuple[int, Span]](), statements.stmt
    uses: list[PhaseUse] = []  # kept, so that no other gets the same id

    def counted(s: Any, scope: Any, use: PhaseUse) -> Any:
        uses.append(use)
        seen[id(use), s.span] += 1
        return elaborate(s, scope, use)

    monkeypatch.setattr(statements, "stmt", counted)
    for path in FILES:
        build(read_source(path))
    assert len(seen) > 500 and set(seen.values()) == {1}


def test_idle_statements_change_no_draw() -> None:
    """Nor do kinds that are not on the map, shapes that no rule uses, and branches that never happen."""
    harvest = game_of(find_game("harvest_open"))
    play = random_play(harvest, seed=3, steps=200)
    ours, theirs = (on_numpy(game) for game in (harvest, build(Source("dull.sj", DULL, games_folder())).game))
    eaten = 0.0
    for (state, _, _, given), (other, _, _, given_there) in zip(moments(ours, play, 200), moments(theirs, play, 200), strict=True):
        here, there = plain(ours, state), plain(theirs, other)
        for name in ("position", "heading", "soil_fruit"):
            np.testing.assert_array_equal(np.asarray(here[name]), np.asarray(there[name]))
        if given is not None:
            np.testing.assert_array_equal(np.asarray(given[0]), np.asarray(given_there[0]))
            eaten += float(np.asarray(given[0]).sum())
    assert eaten > 0
