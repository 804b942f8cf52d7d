"""Elaborates the effects `give`, `tally` and `send`, and whom they reach."""

from typing import Any

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.diagnostics.diagnostic import Fix, near
from sjdsl.compiler.diagnostics.problems import Poisoned
from sjdsl.compiler.elaborate.domains import domain, only_one_who
from sjdsl.compiler.elaborate.keys import key_of
from sjdsl.compiler.elaborate.lookup import (
    as_agent,
    check_free,
    check_placed,
    check_somebody,
    kinds_of_cell,
    read_beside,
)
from sjdsl.compiler.elaborate.movers import check_heading
from sjdsl.compiler.elaborate.paths import placed
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.elaborate.streams import PhaseUse
from sjdsl.compiler.ir.free_variables import free_variables
from sjdsl.compiler.ir.printer import expression as text
from sjdsl.compiler.ir.queries import body_sort
from sjdsl.compiler.ir.types import words
from sjdsl.runtime.actions import HEADINGS

FACINGS = (*HEADINGS, "same")
TURNED = {
    "ahead": 0,
    "right": 1,
    "back": 2,
    "left": 3,
}  # quarter turns to the right from where the agent that is sent looks
LATER = "who is sent `after` some ticks finds its cell when it comes back: keep what it needs in a field of its own, set before it is sent"


def body(e: ast.Path, scope: Scope) -> ir.Expr:
    """Returns one agent, or one mover."""
    built = scope.expression(e)
    if isinstance(built, ir.Member) and built.sort.what == "mover":
        return built
    if not as_agent(built):
        raise wrong_type(
            scope, e, "an agent or a mover" if scope.static.movers else "an agent", built.type
        )
    check_somebody(built, e.span, scope)
    return built


def receiver(e: ast.Path, scope: Scope) -> ir.Expr:
    """Returns one agent or a set of agents."""
    built = scope.expression(e)
    if built.type.kind == "agents" and not built.type.by:
        return built
    if isinstance(built, ir.Member) and built.sort.what == "mover":
        help_ = "a mover earns nothing; keep it in a field of the mover, such as `field fed : 0 .. 9 capped = 0`"
        raise scope.expected(e.span, "an agent or a set of agents", "a mover", help_)
    if not as_agent(built):
        raise wrong_type(scope, e, "an agent or a set of agents", built.type)
    check_somebody(built, e.span, scope)
    return built


def give(s: ast.Give, scope: Scope) -> ir.Stmt:
    try:
        value = scope.number(s.value, ("reward",), "a reward")
    except Poisoned:
        if not isinstance(s.receiver, ast.All):
            read_beside(s.receiver, scope)
        raise
    if not isinstance(s.receiver, ast.All):
        return ir.Give(value=value, receiver=receiver(s.receiver, scope), origin=s.span)
    but = None
    if s.receiver.but is not None:
        tree = ast.Path(s.receiver.but.span, s.receiver.but, ())
        member = scope.expression(tree)
        if not (isinstance(member, ir.Member) and member.sort.what == "agent"):
            raise wrong_type(scope, tree, "an agent", member.type)
        but = member
    return ir.Give(value=value, receiver=None, but=but, origin=s.span)


def tally(s: ast.Tally, scope: Scope) -> ir.Stmt:
    static = scope.static
    name = s.event.name
    event = static.events.get(name.text)
    if event is None:
        raise scope.fail(
            errors.NoEvent(name.span, name=name.text, near=near(name.text, static.events))
        )
    static.refer(name, Symbol("metric", name.text))
    word = None
    if event.by is not None:
        if len(s.event.steps) != 1 or not isinstance(s.event.steps[0], ast.Index):
            raise scope.expected(s.event.span, f"`{name.text}[word]`", "the whole row")
        if name.text not in static.event_levels:
            raise Poisoned
        word = key_of(s.event.steps[0].key, name.text, static.event_levels[name.text], scope)
    elif s.event.steps:
        raise scope.expected(s.event.span, "the event alone", "an entry of it")
    amount = None if s.by is None else scope.number(s.by, ("count",), "a count")
    if s.by is not None and amount is not None and amount.type.low < 0:
        raise scope.fail(errors.Negative(s.by.span, name="what is counted"))
    for_ = None if s.receiver is None else receiver(s.receiver, scope)
    return ir.Tally(event=name.text, word=word, amount=amount, receiver=for_, origin=s.span)


def _facing_and_stay(s: ast.Send | ast.Shift, otherwise: str, scope: Scope) -> str | None:
    """Returns which way an agent faces after it is sent, None if that isn't written. `otherwise`: who stays by `otherwise stay`."""
    if s.facing is not None and s.facing.text not in FACINGS:
        raise scope.problems.unknown(s.facing, FACINGS, "what an agent can be made to face")
    if s.stay is not None and s.stay.text != "stay":
        help_, fix = f"write `otherwise stay`: {otherwise} stays", Fix(s.stay.span, "stay")
        raise scope.fail(errors.UnknownName(s.stay.span, name=s.stay.text, help=help_, fix=fix))
    return None if s.facing is None else s.facing.text


def send(s: ast.Send, scope: Scope, use: PhaseUse) -> ir.Stmt:
    who = body(s.who, scope)
    after = None if s.after is None else scope.number(s.after, ("steps",), "a number of steps")
    if s.after is not None and after is not None and after.type.low < 0:
        raise scope.fail(errors.Negative(s.after.span, name="the delay"))
    if isinstance(after, ir.Number) and after.value == 0:
        after = None
    around = scope if s.after is None else only_one_who(scope, who, LATER)
    held = _cell(s.domain, around)
    look = _facing_and_stay(s, "who finds no cell", scope)
    if held is not None and s.stay is None:
        if isinstance(held, ir.Member):
            help_ = ""
            if scope.static.kinds_of(held.name):
                help_ = f"write `otherwise stay` after it: who cannot go there stays; any cell of the kind is `{held.name} as other`"
            raise scope.fail(errors.PerhapsTaken(s.span, place=held.name, help=help_))
        raise scope.fail(errors.TakenOrNowhere(s.span, place=text(held)))
    place = use.streams.header(s.domain.span, s.domain.span.end)
    if body_sort(who).what == "mover":  # each sort is placed by itself
        place = f"{place} of {body_sort(who).name}"
    if held is not None and after is None:
        header = use.streams.header(s.span, s.span.end)
        stream, turned = (
            use.streams.of_statement(header),
            use.streams.of_statement(f"heading of {header}"),
        )
        return ir.Shift(
            who=who, to=held, facing=look, stream=stream, heading_stream=turned, origin=s.span
        )  # type: ignore[arg-type]
    if held is None:
        assert isinstance(s.domain, ast.Domain)
        check_free(s.domain.bind or s.domain.kind, scope, s.domain.bind is not None)
        destination, _ = domain(s.domain, around)
        if (
            destination.var.sort.what != "cell"
            or destination.on is not None
            or destination.restriction is not None
        ):
            wanted = "a kind of cell, perhaps with `where`"
            raise scope.expected(s.domain.span, wanted, "another domain")
    else:  # the domain of that one cell
        span, taken = s.domain.span, {v.name for v in free_variables(held)}
        name = next(n for n in ("cell", "cell_", "cell__") if n not in taken)
        var = ir.Member(name=name, sort=ir.Sort("cell", kinds_of_cell(held) or ()), origin=span)
        destination = ir.Domain(
            var=var, where=ir.Same(left=var, right=held, origin=span), origin=span
        )
    pool = use.pools.setdefault(place, len(use.pools))
    return ir.Send(
        who=who,
        domain=destination,
        after=after,
        facing=look,  # type: ignore[arg-type]
        stay=s.stay is not None,
        pool=pool,
        cell_stream=use.streams.shared("send to", place),
        heading_stream=use.streams.shared("heading of those sent to", place),
        origin=s.span,
    )


def _cell(d: ast.Domain | ast.Path, scope: Scope) -> ir.Expr | None:
    """Returns the one cell that a destination is: that of a field, or of a variable; None for a domain."""
    if isinstance(d, ast.Domain):
        static, name = scope.static, d.kind.text
        whole = d.bind is None and d.on is None and d.restriction is None and d.where is None
        if not whole or not (
            name in scope.variables or name in static.fields or name in scope.withheld
        ):
            return None
        if name in scope.withheld and static.kinds_of(name):
            what, wanted = "a cell of the statements around", "a destination that is known later"
            help_ = f"any cell of the kind is `{name} as other`; {scope.withheld[name]}"
            raise scope.fail(
                errors.WrongSort(d.kind.span, name=name, actual=what, wanted=wanted, help=help_)
            )
        d = ast.Path(d.span, d.kind, ())
    cell = scope.expression(d)
    if not kinds_of_cell(cell):
        raise wrong_type(scope, d, "a kind of cell, or a field that holds a cell", cell.type)
    return cell


def shift(s: ast.Shift, scope: Scope, use: PhaseUse) -> ir.Stmt:
    """Returns `send x by n DIRECTION`."""
    who = body(s.who, scope)
    check_placed(who, s.span, "send … by", scope)
    way = _direction(s.direction, who, scope)
    look = _facing_and_stay(s, "who cannot go there", scope)
    if s.stay is None:
        raise scope.fail(errors.NoWayFree(s.span))
    stream = use.streams.of_statement(use.streams.header(s.span, s.span.end))
    steps = scope.number(s.steps, ("cells", "count"), "a number of cells")
    if steps.type.low < 0:
        raise scope.fail(errors.Negative(s.steps.span, name="the number of cells"))
    if steps.type.high > limits.MAX_SHIFT:
        far = f"{steps.type.high:g}" if steps.type.high < float("inf") else "any number of"
        help_ = "give the parameters limits, `in a .. b`, or bound it with `min`"
        raise scope.fail(
            limits.too_much(f"this can be {far} cells", limits.MAX_SHIFT, s.steps.span, help_)
        )
    return ir.Shift(
        who=who, steps=steps, **way, facing=look or "same", stream=stream, origin=s.span
    )  # type: ignore[arg-type]


def _direction(d: ast.Direction, who: ir.Expr, scope: Scope) -> dict[str, Any]:
    """Returns which way, as fields of the statement."""
    if d.how != "along":
        quarters = TURNED["back"] if d.how == "away" else 0
        return {
            "other": placed(d.path, scope.expression(d.path), f"{d.how} …", scope),
            "quarters": quarters,
        }
    name = d.path.name.text
    if not d.path.steps and name in TURNED and name not in scope.variables:
        look: ir.Expr = ir.Attribute(
            type=words(HEADINGS), owner=who, name="heading", origin=d.path.span
        )
        if isinstance(who, ir.Member) and who.sort.what == "mover":
            look = ir.FieldRead(
                type=words(HEADINGS),
                owner=who,
                held_by=who.sort,
                name="heading",
                origin=d.path.span,
            )
        return {"heading": look, "quarters": TURNED[name]}
    heading = scope.expression(d.path)
    wanted = "a direction: `ahead`, `back`, `left`, `right`, a heading such as `north` or `x.heading`, `away from x` or `toward x`"
    check_heading(heading, d.path, wanted, scope)
    return {"heading": heading}
