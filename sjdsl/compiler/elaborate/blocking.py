"""Elaborates `blocks`: what cells of a kind, or agents, stop."""

from collections.abc import Mapping

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.elaborate.scope import Scope
from sjdsl.compiler.ir.sorts import AGENTS


def blocked(blocks: ast.Blocks, tests: Mapping[ir.Sort, ir.Expr | None], scope: Scope) -> list[ir.Block]:
    """Returns what is stopped, the agents, sorts of movers or shapes by name, where a condition holds.

    tests: the condition as it is asked about movers of a sort; as it is asked about agents it is also asked about the others.
    """
    static, found = scope.static, []
    for what in blocks.what:
        if {Symbol("shape", what.text), Symbol("name", what.text)} & static.broken:
            continue
        if what.text != "agents" and what.text not in static.shapes and what.text not in static.movers:
            scope.problems.unknown(what, ["agents", *static.movers, *static.shapes], "what a cell can block")
            continue
        if what.text != "agents":
            static.refer(what, Symbol("shape" if what.text in static.shapes else "name", what.text))
        if what.text in static.shapes and static.shapes[what.text].see_through:
            problem = f"the shape `{what.text}` sees through everything"
            scope.problems.add(errors.NeverHappens(what.span, problem=problem))
        found.append(ir.Block(what=what.text, condition=tests.get(ir.Sort("mover", (what.text,)), tests.get(AGENTS)), origin=blocks.span))
    return found
