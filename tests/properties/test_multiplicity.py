"""How often a statement can run, which agents can stand apart, and paths around others, so that no trajectory is wasted."""

import math

import pytest

from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.state import Cell
from sjdsl.properties.distance import cheapest
from sjdsl.properties.multiplicity import is_always_once, most
from sjdsl.properties.preconditions import preconditions_of
from sjdsl.properties.reachability import least_moves, moves_until
from sjdsl.properties.shortest_paths import FAR
from sjdsl.properties.statements import leaf_statements

from .planted_faults import planted
from .small_games import small_game

HERE, THERE = Cell(0, 0), Cell(0, 1)


@pytest.mark.parametrize(("variant", "times"), [(None, 1), ("fault", 3)])
def test_a_statement_runs_as_often_as_its_quantifiers_allow(variant: str | None, times: int) -> None:
    """One pot and three cooks: `pick 1` takes one of them, `each` all."""
    game = planted("soup", variant).own
    taking = [leaf for leaf in leaf_statements(game) if leaf.statement_id[0] == "take"]
    assert {most(leaf.quantifiers, board_of(game)) for leaf in taking} == {times}


def test_a_move_of_all_is_one_statement_that_runs_once() -> None:
    (walk,) = (leaf for leaf in leaf_statements(planted("soup").own) if leaf.statement_id[0] == "walk")
    assert is_always_once(walk.quantifiers)


def test_statements_of_one_block_have_the_same_needs() -> None:
    taking = [
        precondition
        for precondition in preconditions_of(leaf_statements(planted("soup").own), planted("soup").own)
        if precondition.statement_id[0] == "take"
    ]
    assert len(taking) == 4
    assert len({precondition.block for precondition in taking}) == 1


@pytest.mark.parametrize(
    ("costs", "places", "number", "least"),
    [
        ([1.0, 2.0], [None, None], 2, 3.0),
        ([1.0, 2.0], [frozenset({HERE}), frozenset({HERE})], 1, 1.0),
        ([1.0, 2.0], [frozenset({HERE}), frozenset({HERE})], 2, math.inf),
        ([1.0, 2.0, 5.0], [frozenset({HERE}), frozenset({HERE}), frozenset({HERE, THERE})], 2, 6.0),
        ([1.0, math.inf], [None, None], 2, math.inf),
        ([1.0, 1.0], [frozenset(), None], 2, math.inf),
    ],
)
def test_those_who_do_something_together_stand_apart(
    costs: list[float], places: list[frozenset[Cell] | None], number: int, least: float
) -> None:
    assert cheapest(costs, places, number) == least


def test_paths_go_around_others() -> None:
    orchard = small_game("always eaten < 99").on(("...", "..."), 1)
    assert orchard is not None
    board = board_of(orchard)
    start, goal, between = 0, Cell(0, 2), Cell(0, 1)
    assert moves_until(board, goal, at=goal)[start] < moves_until(board, goal, at=goal, around=frozenset({between}))[start] < FAR
    assert moves_until(board, goal, at=goal, around=frozenset({between, Cell(1, 1)}))[start] == FAR


@pytest.mark.parametrize("around", [frozenset[Cell](), frozenset({Cell(0, 1)}), frozenset({Cell(0, 1), Cell(1, 1)})])
def test_moves_counted_from_where_an_agent_is_are_those_counted_from_where_it_goes(around: frozenset[Cell]) -> None:
    orchard = small_game("always eaten < 99").on(("...", "..."), 1)
    assert orchard is not None
    board = board_of(orchard)
    for start in range(4 * 2 * 3):
        for cell in board.kind_of:
            assert least_moves(board, start, [cell], None, around) == moves_until(board, cell, around=around)[start]
        either = min(moves_until(board, Cell(0, col), around=around)[start] for col in (0, 2))
        assert least_moves(board, start, [Cell(0, 0), Cell(0, 2)], None, around) == either
    assert least_moves(board, 0, [], None, around) == FAR
