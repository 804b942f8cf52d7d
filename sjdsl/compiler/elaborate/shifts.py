"""Elaborates `send x by n DIRECTION`: how far, and which way."""

from typing import Any

from sjdsl.compiler import ast, ir
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.diagnostics.diagnostic import Fix
from sjdsl.compiler.diagnostics.problems import Poisoned
from sjdsl.compiler.elaborate.effects import body, facing
from sjdsl.compiler.elaborate.lookup import check_placed
from sjdsl.compiler.elaborate.paths import placed
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.elaborate.streams import PhaseUse
from sjdsl.compiler.ir.types import words
from sjdsl.runtime.actions import HEADINGS

TURNED = {"ahead": 0, "right": 1, "back": 2, "left": 3}  # quarter turns to the right from where the agent that is sent looks
BACK = 2


def shift(s: ast.Shift, scope: Scope, use: PhaseUse) -> ir.Stmt:
    """Returns `send x by n DIRECTION`."""
    who = body(s.who, scope)
    check_placed(who, s.span, "send … by", scope)
    way = _direction(s.direction, who, scope)
    look = facing(s.facing, scope)
    if s.stay is None:
        raise scope.problems.fail(errors.NoWayFree(s.span))
    if s.stay.text != "stay":
        raise scope.problems.fail(
            errors.UnknownName(
                s.stay.span, name=s.stay.text, help="write `otherwise stay`: who cannot go there stays", fix=Fix(s.stay.span, "stay")
            )
        )
    stream = use.streams.of_statement(use.streams.header(s.span, s.span.end))
    return ir.Shift(who=who, steps=_steps(s.steps, scope), **way, facing=look or "same", stream=stream, origin=s.span)  # type: ignore[arg-type]


def _steps(e: ast.Expr, scope: Scope) -> ir.Expr:
    steps = scope.number(e, ("cells", "count"), "a number of cells")
    if steps.type.low < 0:
        raise scope.problems.fail(errors.Negative(e.span, name="the number of cells"))
    if steps.type.high > limits.MAX_SHIFT:
        far = f"{steps.type.high:g}" if steps.type.high < float("inf") else "any number of"
        help_ = "give the parameters limits, `in a .. b`, or bound it with `min`"
        scope.problems.found.append(limits.too_much(f"this can be {far} cells", limits.MAX_SHIFT, e.span, help_))
        raise Poisoned
    return steps


def _direction(d: ast.Direction, who: ir.Expr, scope: Scope) -> dict[str, Any]:
    """Returns which way, as fields of the statement."""
    if d.how != "along":
        return {"other": placed(d.path, scope.expression(d.path), f"{d.how} …", scope), "quarters": BACK if d.how == "away" else 0}
    name = d.path.name.text
    if not d.path.steps and name in TURNED and name not in scope.variables:
        look: ir.Expr = ir.Attribute(type=words(HEADINGS), owner=who, name="heading", origin=d.path.span)
        if isinstance(who, ir.Member) and who.sort.what == "mover":
            look = ir.FieldRead(type=words(HEADINGS), owner=who, held_by=who.sort, name="heading", origin=d.path.span)
        return {"heading": look, "quarters": TURNED[name]}
    heading = scope.expression(d.path)
    if heading.type.kind != "word" or heading.type.by or not set(heading.type.words) <= set(HEADINGS):
        wanted = "a direction: `ahead`, `back`, `left`, `right`, a heading such as `north` or `x.heading`, `away from x` or `toward x`"
        raise wrong_type(scope, d.path, wanted, heading.type)
    return {"heading": heading}
