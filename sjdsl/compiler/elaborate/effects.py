"""Elaborates the effects `give`, `tally` and `send`, and whom they reach."""

from math import inf
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
from sjdsl.compiler.elaborate.movers import check_heading, heading_of
from sjdsl.compiler.elaborate.paths import placed
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.elaborate.streams import PhaseUse
from sjdsl.compiler.ir.free_variables import free_variables
from sjdsl.compiler.ir.printer import expression_text as text
from sjdsl.compiler.ir.queries import body_sort
from sjdsl.runtime.actions import HEADINGS

FACINGS = (*HEADINGS, "same")
QUARTERS = {"ahead": 0, "right": 1, "back": 2, "left": 3}  # turns to the right of the heading


LATER = (
    "who is sent `after` some ticks finds its cell when it comes back: "
    "keep what it needs in a field of its own, set before it is sent"
)


DIRECTIONS = (
    "a direction: `ahead`, `back`, `left`, `right`, a heading such as `north` or `x.heading`, "
    "`away from x` or `toward x`"
)


def body(e: ast.Path, scope: Scope) -> ir.Expr:
    """Returns one agent, or one mover."""
    built = scope.expression(e)
    if isinstance(built, ir.Member) and built.sort.what == "mover":
        return built
    if not as_agent(built):
        wanted = "an agent or a mover" if scope.static.movers else "an agent"
        raise wrong_type(scope, e, wanted, built.type)
    check_somebody(built, e.span, scope)
    return built


def receiver(e: ast.Path, scope: Scope) -> ir.Expr:
    """Returns one agent or a set of agents."""
    built = scope.expression(e)
    if built.type.kind == "agents" and not built.type.by:
        return built
    wanted = "an agent or a set of agents"
    if isinstance(built, ir.Member) and built.sort.what == "mover":
        help_ = (
            "a mover earns nothing; keep it in a field of the mover, "
            "such as `field fed : 0 .. 9 capped = 0`"
        )
        raise scope.expected(e.span, wanted, "a mover", help_)
    if not as_agent(built):
        raise wrong_type(scope, e, wanted, built.type)
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
        meant = near(name.text, static.events)
        raise scope.fail(errors.NoEvent(name.span, name=name.text, near=meant))
    static.refer(name, Symbol("metric", name.text))
    steps = s.event.steps
    word = None
    if event.by is not None:
        if len(steps) != 1 or not isinstance(steps[0], ast.Index):
            raise scope.expected(s.event.span, f"`{name.text}[word]`", "the whole row")
        if name.text not in static.event_levels:
            raise Poisoned
        word = key_of(steps[0].key, name.text, static.event_levels[name.text], scope)
    elif steps:
        raise scope.expected(s.event.span, "the event alone", "an entry of it")
    amount = None
    if s.by is not None:
        amount = scope.number(s.by, ("count",), "a count")
        if amount.type.low < 0:
            raise scope.fail(errors.Negative(s.by.span, name="what is counted"))
    for_ = None if s.receiver is None else receiver(s.receiver, scope)
    return ir.Tally(event=name.text, word=word, amount=amount, receiver=for_, origin=s.span)


def _facing_and_stay(s: ast.Send | ast.Shift, who_stays: str, scope: Scope) -> str | None:
    """Returns which way an agent faces after it is sent, None if that isn't written.

    Reports anything but `stay` after `otherwise`. who_stays: by `otherwise stay`.
    """
    if s.facing is not None and s.facing.text not in FACINGS:
        raise scope.problems.unknown(s.facing, FACINGS, "what an agent can be made to face")
    if s.stay is not None and s.stay.text != "stay":
        help_ = f"write `otherwise stay`: {who_stays} stays"
        fix = Fix(s.stay.span, "stay")
        raise scope.fail(errors.UnknownName(s.stay.span, name=s.stay.text, help=help_, fix=fix))
    return None if s.facing is None else s.facing.text


def send(s: ast.Send, scope: Scope, use: PhaseUse) -> ir.Stmt:
    """Returns `send x to CELL` as a shift if it happens at once, else `send x to DOMAIN`."""
    who = body(s.who, scope)
    after = None
    if s.after is not None:
        after = scope.number(s.after, ("steps",), "a number of steps")
        if after.type.low < 0:
            raise scope.fail(errors.Negative(s.after.span, name="the delay"))
    if isinstance(after, ir.Number) and after.value == 0:
        after = None
    around = scope if s.after is None else only_one_who(scope, who, LATER)
    cell = _cell(s.domain, around)
    facing = _facing_and_stay(s, "who finds no cell", scope)
    if cell is not None and s.stay is None:
        raise _perhaps_taken(s, cell, scope)
    if cell is not None and after is None:
        header = use.streams.header(s.span, s.span.end)
        stream = use.streams.of_statement(header)
        heading_stream = use.streams.of_statement(f"heading of {header}")
        return ir.Shift(
            who=who,
            to=cell,
            facing=facing,  # type: ignore[arg-type]
            stream=stream,
            heading_stream=heading_stream,
            origin=s.span,
        )
    if cell is None:
        assert isinstance(s.domain, ast.Domain)
        destination = _destination(s.domain, scope, around)
    else:
        destination = _domain_of_cell(s.domain, cell)
    header = use.streams.header(s.domain.span, s.domain.span.end)
    sort = body_sort(who)
    if sort.what == "mover":  # each sort is placed by itself
        header = f"{header} of {sort.name}"
    return ir.Send(
        who=who,
        domain=destination,
        after=after,
        facing=facing,  # type: ignore[arg-type]
        stay=s.stay is not None,
        pool=use.pools.setdefault(header, len(use.pools)),
        cell_stream=use.streams.shared("send to", header),
        heading_stream=use.streams.shared("heading of those sent to", header),
        origin=s.span,
    )


def _perhaps_taken(s: ast.Send, cell: ir.Expr, scope: Scope) -> Poisoned:
    """Reports a destination that may be taken, without `otherwise stay`."""
    if not isinstance(cell, ir.Member):
        return scope.fail(errors.TakenOrNowhere(s.span, place=text(cell)))
    help_ = ""
    if scope.static.kinds_of(cell.name):
        help_ = (
            "write `otherwise stay` after it: who cannot go there stays; "
            f"any cell of the kind is `{cell.name} as other`"
        )
    return scope.fail(errors.PerhapsTaken(s.span, place=cell.name, help=help_))


def _destination(d: ast.Domain, scope: Scope, around: Scope) -> ir.Domain:
    """Returns the cells that somebody is sent to. around: what their `where` may name."""
    check_free(d.bind or d.kind, scope, d.bind is not None)
    destination, _ = domain(d, around)
    is_plain = destination.on is None and destination.restriction is None
    if destination.var.sort.what != "cell" or not is_plain:
        raise scope.expected(d.span, "a kind of cell, perhaps with `where`", "another domain")
    return destination


def _domain_of_cell(tree: ast.Domain | ast.Path, cell: ir.Expr) -> ir.Domain:
    """Returns the domain of one cell, with a variable that the cell doesn't read."""
    span = tree.span
    read = {v.name for v in free_variables(cell)}
    name = next(n for n in ("cell", "cell_", "cell__") if n not in read)
    var = ir.Member(name=name, sort=ir.Sort("cell", kinds_of_cell(cell) or ()), origin=span)
    return ir.Domain(var=var, where=ir.Same(left=var, right=cell, origin=span), origin=span)


def _cell(d: ast.Domain | ast.Path, scope: Scope) -> ir.Expr | None:
    """Returns the one cell that a destination is, of a field or a variable; None for a domain."""
    if isinstance(d, ast.Domain):
        static = scope.static
        name = d.kind.text
        is_name = d.bind is None and d.on is None and d.restriction is None and d.where is None
        is_withheld = name in scope.withheld
        if not is_name:
            return None
        if not (is_withheld or name in scope.variables or name in static.fields):
            return None
        if is_withheld and static.kinds_of(name):
            help_ = f"any cell of the kind is `{name} as other`; {scope.withheld[name]}"
            actual = "a cell of the statements around"
            raise scope.misused(d.kind, actual, "a destination that is known later", help_)
        d = ast.Path(d.span, d.kind, ())
    cell = scope.expression(d)
    if not kinds_of_cell(cell):
        raise wrong_type(scope, d, "a kind of cell, or a field that holds a cell", cell.type)
    return cell


def shift(s: ast.Shift, scope: Scope, use: PhaseUse) -> ir.Stmt:
    """Returns `send x by n DIRECTION`."""
    who = body(s.who, scope)
    check_placed(who, s.span, "send … by", scope)
    direction = _direction(s.direction, who, scope)
    facing = _facing_and_stay(s, "who cannot go there", scope)
    if s.stay is None:
        raise scope.fail(errors.NoWayFree(s.span))
    stream = use.streams.of_statement(use.streams.header(s.span, s.span.end))
    steps = scope.number(s.steps, ("cells", "count"), "a number of cells")
    if steps.type.low < 0:
        raise scope.fail(errors.Negative(s.steps.span, name="the number of cells"))
    most = steps.type.high
    if most > limits.MAX_SHIFT:
        number = "any number of" if most == inf else f"{most:g}"
        help_ = "give the parameters limits, `in a .. b`, or bound it with `min`"
        problem = f"this can be {number} cells"
        raise scope.fail(limits.too_much(problem, limits.MAX_SHIFT, s.steps.span, help_))
    return ir.Shift(
        who=who,
        steps=steps,
        **direction,
        facing=facing or "same",  # type: ignore[arg-type]
        stream=stream,
        origin=s.span,
    )


def _direction(d: ast.Direction, who: ir.Expr, scope: Scope) -> dict[str, Any]:
    """Returns the fields of the statement that say in which direction somebody is sent."""
    if d.how != "along":
        other = placed(d.path, scope.expression(d.path), f"{d.how} …", scope)
        return {"other": other, "quarters": QUARTERS["back"] if d.how == "away" else 0}
    name = d.path.name.text
    if not d.path.steps and name in QUARTERS and name not in scope.variables:
        return {"heading": heading_of(who, d.path.span), "quarters": QUARTERS[name]}
    heading = scope.expression(d.path)
    check_heading(heading, d.path, DIRECTIONS, scope)
    return {"heading": heading}
