"""Elaborates `blocks`: what cells of a kind, or agents, stop."""

from sjdsl.compiler import ast, ir
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.elaborate.scope import Declared, Scope


def blocked(blocks: ast.Blocks, test: ir.Expr | None, scope: Scope) -> list[ir.Block]:
    """Returns what is stopped, the agents or shapes by name, where a condition holds."""
    found = []
    for what in blocks.what:
        if Declared(what.text, among="shapes") in scope.static.broken:
            continue
        if what.text != "agents" and what.text not in scope.static.shapes:
            scope.problems.unknown(what, ["agents", *scope.static.shapes], "what a cell can block")
            continue
        if what.text != "agents" and scope.static.shapes[what.text].see_through:
            problem = f"the shape `{what.text}` sees through everything"
            scope.problems.add(errors.NeverHappens(what.span, problem=problem))
        found.append(ir.Block(what=what.text, condition=test, origin=blocks.span))
    return found
