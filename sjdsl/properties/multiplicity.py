"""Multiplicity of a statement: how often it can run in one step at most, by the quantifiers around it."""

import math
from collections.abc import Sequence
from typing import assert_never

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import most_members
from sjdsl.interpreter.board import Board
from sjdsl.interpreter.members import everybody

Quantifier = ir.Each | ir.Pick | ir.First | ir.Match


def most_of_each(quantifiers: Sequence[Quantifier], board: Board) -> dict[str, int]:
    """Returns for the variables of quantifiers how many members each has at most, within one member of those around it.

    The product is how often a statement inside all of them runs at most. Of two that are matched the second has one.
    """
    found: dict[str, int] = {}
    for quantifier in quantifiers:
        match quantifier:
            case ir.Each(domain=domain):
                found[domain.var.name] = most_members(domain, board.game)
            case ir.Pick(domain=domain):
                found[domain.var.name] = min(quantifier.most, most_members(domain, board.game))
            case ir.First(domain=domain):
                lanes = len(board.shapes[domain.restriction.shape].lanes) if isinstance(domain.restriction, ir.Near) else 1
                found[domain.var.name] = min(lanes, most_members(domain, board.game))
            case ir.Match(left=left, right=right):
                pairs = min(most_members(left, board.game), most_members(right, board.game))
                alike = left.var.sort == right.var.sort and left.var.sort.what != "cell"
                found[left.var.name] = min(pairs, everybody(left, board) // 2) if alike else pairs
                found[right.var.name] = 1
            case _:
                assert_never(quantifier)
    return found


def is_always_once(quantifiers: Sequence[Quantifier]) -> bool:
    """Returns whether a statement runs at most once in a step, on any map, with any agents: nothing around it but `pick 1`."""
    return all(isinstance(quantifier, ir.Pick) and quantifier.most == 1 for quantifier in quantifiers)


def most(quantifiers: Sequence[Quantifier], board: Board, without: str | None = None) -> int:
    """Returns how often a statement can run in one step; `without`: for each member of one of the variables."""
    return math.prod(number for name, number in most_of_each(quantifiers, board).items() if name != without)
