"""Recognises closed expressions, those without free variables: each is evaluated once for all instances of a phase."""

from sjdsl.compiler import ir
from sjdsl.interpreter.board import Board


def is_closed(e: ir.Expr, board: Board) -> bool:
    """Returns whether all variables of an expression are bound inside it. The board keeps the answers."""
    if id(e) not in board.closed:
        board.closed[id(e)] = (e, _is_closed(e))
    return board.closed[id(e)][1]


def _is_closed(e: ir.Expr) -> bool:
    used: set[str] = set()
    bound: set[str] = set()
    for node in ir.walk(e):
        match node:
            case ir.Member() | ir.Local():
                used.add(node.name)
            case ir.Domain():
                bound |= {node.var.name} if node.on is None else {node.var.name, node.on.name}
            case _:
                pass
    return used <= bound
