"""Streams of draws: made from the phase use and the text of a statement, one for each, whatever else a game says."""

import hashlib
from functools import cache
from pathlib import Path

import pytest

from sjdsl.compiler import build, ir
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.read import read_source
from sjdsl.library.games_folder import find_game, main_games
from tests.verify_ir import verify

FILES = [*map(find_game, main_games()), *sorted((Path(__file__).parents[1] / "cases").glob("*.sj"))]

# Draws of every sort, and the lines that their streams are made of by section 5 of docs/semantics.md.
DRAWING = """sj 1
game drawing {
  size players : count = 2
  param odds : probability = 0.5
  episode 9
  kind grass "." { field grown : { no, yes } = no }
  kind den "D"
  map { "...D" "...." }
  agents players { acts forward, stay  field bag : 0 .. 9 = 0  field lair : cell of den = nowhere }
  movers deer 1 "d"
  field dice : 1 .. 6 = 1
  phase start { each agent { send agent to grass where grass.grown is no  # free
  }  each deer { send deer to grass } }
  schedule tick -> roll(3) -> roll(3) -> roam -> home
  phase roll(n) {
    draw a from 1 .. n
    draw a2 from { 1: 0.5, 2: 0.5 }
    when a > 2 { set dice = 1 } otherwise when a2 >= 2 {
      chance odds { set dice = 2 } otherwise chance 0.1 { draw c from 1 .. 6  set dice = c }
    } otherwise { pick 1 agent { chance odds { give 1 to agent } chance odds { give 2 to agent } } }
  }
  phase roam { move each deer at random }
  phase home {
    each agent as x where x.lair is not nowhere { send x to x.lair otherwise stay }
    each agent as x where x.lair is nowhere { send x by 1 ahead otherwise stay }
  }
}
"""
ROLLED = (
    ("draw a from 1 .. n", "1"),
    ("draw a2 from { 1 : 0.5 , 2 : 0.5 }", "1"),
    ("when a > 2 otherwise when a2 >= 2", "chance odds", "1"),
    (
        "when a > 2 otherwise when a2 >= 2",
        "chance odds otherwise chance 0.1",
        "draw c from 1 .. 6",
        "1",
    ),
    ("when a > 2 otherwise when a2 >= 2 otherwise otherwise", "pick 1 agent", "1"),
    ("when a > 2 otherwise when a2 >= 2 otherwise otherwise", "pick 1 agent", "chance odds", "1"),
    ("when a > 2 otherwise when a2 >= 2 otherwise otherwise", "pick 1 agent", "chance odds", "2"),
)
TO_LAIR = "send x to x . lair otherwise stay"
STREAM_LINES = (
    ("start", "send to", "grass where grass . grown is no"),
    ("start", "heading of those sent to", "grass where grass . grown is no"),
    ("start", "send to", "grass of deer"),
    ("start", "heading of those sent to", "grass of deer"),
    *(("roll(3)", *lines) for lines in ROLLED),
    *(("roll(3) #2", *lines) for lines in ROLLED),
    ("roam", "move each deer at random", "1"),
    ("roam", "move each deer at random", "which way", "1"),
    ("home", "each agent as x where x . lair is not nowhere", TO_LAIR, "1"),
    ("home", "each agent as x where x . lair is not nowhere", f"heading of {TO_LAIR}", "1"),
    ("home", "each agent as x where x . lair is nowhere", "send x by 1 ahead otherwise stay", "1"),
)


@cache
def game_of(path: Path) -> ir.Game:
    return build(read_source(path)).game


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_draw_has_a_stream_of_its_own(path: Path) -> None:
    verify(game_of(path))


def test_streams_are_made_as_the_semantics_say() -> None:
    game = build(Source("drawing.sj", DRAWING)).game
    expected = [
        int(hashlib.sha256("\n".join(lines).encode()).hexdigest()[:8], 16) for lines in STREAM_LINES
    ]
    names = ("stream", "cell_stream", "heading_stream")
    streams = [getattr(node, name, None) for node in ir.walk(game) for name in names]
    assert sorted(expected) == sorted(stream for stream in streams if stream is not None)
