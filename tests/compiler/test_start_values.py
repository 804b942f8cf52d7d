"""Conditions at the start: what is decided once for all cells of one character is so for each of them."""

from pathlib import Path

import pytest

from sjdsl.compiler import build, ir
from sjdsl.compiler.checks.start_values import holds_at_start, places, reads_only_fields
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.ir.queries import phases_of
from sjdsl.compiler.syntax.read import read_source

CASES = ("destinations", "sending", "wrapping", "groups")

GAME = """sj 1
game rooms "Rooms" {
  episode 10
  kind floor "." { field open : { no, yes } = no  glyph "o" with open = yes }
  map { "..o" "oo." }
  agents 2 { acts stay  field bag by { nut, leaf } : 0 .. 9 = 2  field pace : reward = 1.5 }
  phase start { each agent { send agent to floor } }
  schedule tick -> go
  phase go { each agent as a { send a to floor as f where WHERE otherwise stay } }
}
"""


def sends(phase: ir.Phase) -> list[ir.Send]:
    return [
        node for statement in phase.body for node in ir.walk(statement) if isinstance(node, ir.Send)
    ]


@pytest.mark.parametrize("case", CASES)
def test_cells_of_one_character_are_alike(case: str) -> None:
    game = build(read_source(Path(__file__).parents[1] / f"cases/{case}.sj")).game
    for send in (found for phase in phases_of(game) for found in sends(phase)):
        where, name = send.domain.where, send.domain.var.name
        if where is None or not reads_only_fields(where, name):
            continue
        for agent in range(game.agents.number):
            known = {send.who.name: agent} if isinstance(send.who, ir.Member) else {}
            found: dict[str, set[bool | None]] = {}
            for place in places(game, send.domain.var.kinds):
                found.setdefault(place.glyph, set()).add(
                    holds_at_start(where, {**known, name: place}, game)
                )
            assert all(len(verdicts) == 1 for verdicts in found.values())


@pytest.mark.parametrize(
    ("where", "expected"),
    [
        ("f.open is yes", True),
        ("f.open is yes and nobody on f", True),
        ("a.index == 0 and f.open is no", True),
        ("f.row == 0", False),
        ("f.open is no or f.col == a.index", False),
    ],
)
def test_what_asks_for_the_place_is_decided_for_each(where: str, expected: bool) -> None:
    game = build(Source("rooms.sj", GAME.replace("WHERE", where))).game
    domain = next(
        send for phase in phases_of(game) for send in sends(phase) if send.domain.where is not None
    ).domain
    assert domain.where is not None
    assert reads_only_fields(domain.where, domain.var.name) is expected


@pytest.mark.parametrize(
    ("where", "cells"),
    [
        ("f.open is yes and step < 1", 3),
        ("a.index in 1 .. 2 or f.row == 0", 3),
        ("case f.open { yes: f.col, no: 0 } == 2", 1),
        ("a.bag[leaf] + 2 > 3 and a.bag[leaf] - 2 == 0", 6),
        ("sum(a.bag) == 4", 6),
        ("lowest(a.bag) is nut and a.pace > 1", 6),
        ("a.index > 0 and quotient(6, a.index) == 6", 0),
        ("a.pace * 2 > 1", None),
        ("f.open is yes or a.moved", None),
    ],
)
def test_what_is_declared_and_drawn_decides(where: str, cells: int | None) -> None:
    """In how many cells the condition holds for agent 0; None: that isn't known of all cells."""
    game = build(Source("rooms.sj", GAME.replace("WHERE", where))).game
    domain = sends(phases_of(game)[1])[0].domain
    assert domain.where is not None
    verdicts = [
        holds_at_start(domain.where, {"a": 0, "f": place}, game)
        for place in places(game, ("floor",))
    ]
    assert (None if None in verdicts else verdicts.count(True)) == cells
