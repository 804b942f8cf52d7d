"""Random programs use every alternative of the grammar, and their typed rules every node and every choice of a node."""

from contextlib import suppress
from random import Random

import pytest

from sjdsl.compiler import build
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from tests.fuzz.coverage import Grammar, rule_parts, rule_parts_used
from tests.fuzz.judge import written
from tests.fuzz.programs import program
from tests.fuzz.sides import on_some_side

NEVER = {
    "call: NAME LPAR RPAR": "whatever is called takes values",
    **{
        f"draw: DRAW NAME FROM different {values}": "only the entries of a row are different"
        for values in ("sum DOTS sum", "table", "words")
    },
    **{
        f"draw: DRAW NAME by FROM {values}": "the generator draws no rows: tests/cases/deals.sj"
        for values in (
            "different sum DOTS sum",
            "different table",
            "different words",
            "sum DOTS sum",
            "table",
            "words",
        )
    },
    "game: GAME NAME LBRACE RBRACE": "a game has a map",
    "game: GAME NAME title LBRACE RBRACE": "a game has a map",
    "phase: PHASE NAME names moment block": "a phase at the start takes no arguments",
    "send: SEND path TO held_cell": "the message says to write `otherwise stay`",
    "send: SEND path TO held_cell after": "the message says to write `otherwise stay`",
    "send: SEND path TO held_cell after facing": "the message says to write `otherwise stay`",
    "send: SEND path TO held_cell facing": "the message says to write `otherwise stay`",
    "shift: SEND path BY sum direction": "the message says to write `otherwise stay`",
    "shift: SEND path BY sum direction facing": "the message says to write `otherwise stay`",
    "task_field: FIELD NAME COLON different type": "only the entries of a row are different",
}
NO_PART = {
    "Bearing.fn = steps_right": "no mirror keeps it; tests/runtime/test_bearings.py has it",
    "Mix": "the generator does not write mixes",
    "Look.what = mover": "the generator does not write looks of movers",
    "Game.chosen has some": "no variant is chosen",
    "EventTotal.word is given": "counted by the word",
    "Send.facing is given": "counted by the heading",
    "Shift.facing is given": "counted by the heading",
}
# Seeds of programs that use all of it together; where the programs have changed, others are tried after them.
SEEDS = "5 10 14 22 23 24 29 31 36 45 47 56 66 70 98 100 116 121 128 135 152 247"
ENOUGH = [int(seed) for seed in SEEDS.split()]


@pytest.mark.thorough
def test_every_alternative_of_the_grammar_is_used() -> None:
    grammar = Grammar()
    assert set(NEVER) <= set(grammar.alternatives)
    for seed in (*ENOUGH, *range(1000)):
        grammar.read(program(Random(seed)))
        if not set(grammar.missing()) - set(NEVER):
            break
    assert set(grammar.missing()) == set(NEVER)
    assert len(grammar.alternatives) > 300


@pytest.mark.thorough
def test_every_part_of_typed_rules_is_in_an_accepted_program() -> None:
    left = {part for part in rule_parts() if not part.endswith(" is empty")} - set(NO_PART)
    for seed in range(600):
        if left:
            with written(program(Random(seed))) as source, suppress(CompileError):
                left -= set(rule_parts_used(on_some_side(build(source).game, seed)))
    assert left == set()
