"""Constant folding of conditions and whole numbers; reals keep their float32 order of operations.

when 3 < 5 and agent.index < 2 { … }   ->   when agent.index < 2 { … }
"""

from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.operations import CALCULATIONS
from sjdsl.compiler.ir.traverse import rewrite


def fold_constants(game: ir.Game) -> ir.Game:
    """Returns the game with constant conditions and whole numbers computed."""
    return rewrite(game, _fold)


def _fold(node: Any) -> Any:
    match node:
        case ir.Arithmetic(fn=fn, args=(ir.Number(value=int(a)), ir.Number(value=int(b)))) if node.type.kind == "int":
            value = int(CALCULATIONS[fn].fold(a, b))
            return ir.Number(type=node.type.model_copy(update={"low": value, "high": value}), value=value, origin=node.origin)
        case ir.Compare(fn=fn, left=ir.Number(value=a), right=ir.Number(value=b)):
            truth = {"<": a < b, "<=": a <= b, ">": a > b, ">=": a >= b, "==": a == b, "!=": a != b}[fn]
            return ir.Truth(value=truth, origin=node.origin)
        case ir.Same(left=ir.Word(value=a), right=ir.Word(value=b)):
            return ir.Truth(value=a == b, origin=node.origin)
        case ir.Not(value=ir.Truth(value=value)):
            return ir.Truth(value=not value, origin=node.origin)
        case ir.Not(value=ir.Not(value=inner)):
            return inner
        case ir.Logic():
            return _logic(node)
        case ir.Case(subject=ir.Word(value=word)):
            return next(a.value for a in node.arms if word in a.words) if node.type.kind != "word" else node
        case _:
            return node


def _logic(node: ir.Logic) -> ir.Expr:
    """`and` drops yes and stops at no; `or` the other way round."""
    neutral = node.fn == "and"
    left = [a for a in node.args if not (isinstance(a, ir.Truth) and a.value == neutral)]
    if any(isinstance(a, ir.Truth) for a in left):
        return ir.Truth(value=not neutral, origin=node.origin)
    if not left:
        return ir.Truth(value=neutral, origin=node.origin)
    if len(left) == 1:
        return left[0]
    return node if len(left) == len(node.args) else node.model_copy(update={"args": tuple(left)})
