"""Elaborates the effects `give`, `tally` and `send`, and whom they reach."""

from math import inf
from typing import Any

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.diagnostics.diagnostic import Fix, near
from sjdsl.compiler.diagnostics.problems import Poisoned
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate.domains import domain, when_back
from sjdsl.compiler.elaborate.keys import key_of
from sjdsl.compiler.elaborate.lookup import (
    check_agent,
    check_free,
    check_placed,
    is_member,
    kinds_of_cell,
    named_agent,
    read_beside,
)
from sjdsl.compiler.elaborate.movers import check_heading, heading_of
from sjdsl.compiler.elaborate.paths import placed
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.elaborate.streams import Streams
from sjdsl.compiler.ir.free_variables import free_variables
from sjdsl.compiler.ir.printer import expression_text as text
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
    if not is_member(built, "mover"):
        wanted = "an agent or a mover" if scope.static.movers else "an agent"
        check_agent(built, e, wanted, scope)
    return built


def receiver(e: ast.Path, scope: Scope) -> ir.Expr:
    """Returns one agent or a set of agents."""
    built = scope.expression(e)
    if built.type.is_single("agents"):
        return built
    wanted = "an agent or a set of agents"
    if is_member(built, "mover"):
        help_ = (
            "a mover earns nothing; keep it in a field of the mover, "
            "such as `field fed : 0 .. 9 capped = 0`"
        )
        raise scope.expected(e.span, wanted, "a mover", help_)
    check_agent(built, e, wanted, scope)
    return built


def give(s: ast.Give, scope: Scope) -> ir.Stmt:
    """Returns a typed `give`: to an agent, to a set of agents, to `all`, or to `all but` an agent.

    Raises Poisoned if something in it is wrong, which has been reported. If its value is, mistakes
    in its receiver are reported too.
    """
    try:
        value = scope.number(s.value, ("reward",), "a reward")
    except Poisoned:
        if not isinstance(s.receiver, ast.All):
            read_beside(s.receiver, scope)
        raise
    if not isinstance(s.receiver, ast.All):
        return ir.Give(value=value, receiver=receiver(s.receiver, scope), origin=s.span)
    left_out = None
    if s.receiver.but is not None:
        path = ast.Path(s.receiver.but.span, s.receiver.but, ())
        left_out = named_agent(scope.expression(path), path, scope)
    return ir.Give(value=value, receiver=None, but=left_out, origin=s.span)


def declared_event(name: ast.Name, scope: Scope) -> ast.Event:
    """Returns the event of a name; reports one that no `metrics` declare."""
    static = scope.static
    if name.text not in static.events:
        meant = near(name.text, static.events)
        raise scope.fail(errors.NoEvent(name.span, name=name.text, near=meant))
    static.refer(name, Symbol("metric", name.text))
    return static.events[name.text]


def tally(s: ast.Tally, scope: Scope) -> ir.Stmt:
    """Returns a typed `tally`."""
    static = scope.static
    name = s.event.name
    event = declared_event(name, scope)
    steps = s.event.steps
    entry = None
    if event.by is not None:
        if len(steps) != 1 or not isinstance(steps[0], ast.Index):
            raise scope.expected(s.event.span, f"`{name.text}[word]`", "the whole row")
        if name.text not in static.event_index_sets:
            raise Poisoned
        entry = key_of(steps[0].key, name.text, static.event_index_sets[name.text], scope)
    elif steps:
        raise scope.expected(s.event.span, "the event alone", "an entry of it")
    amount = None
    if s.by is not None:
        amount = scope.not_negative(s.by, ("count",), "a count", "what is counted")
    earner = None if s.receiver is None else receiver(s.receiver, scope)
    return ir.Tally(event=name.text, word=entry, amount=amount, receiver=earner, origin=s.span)


def _facing(facing: ast.Path | None, scope: Scope) -> dict[str, Any]:
    """Returns the fields of the statement that say which way an agent faces after it is sent."""
    if facing is None:
        return {}
    name = facing.name
    is_name = not facing.steps and name.text not in scope.variables
    if is_name and name.text in FACINGS:
        return {"facing": name.text}
    known = (*scope.static.fields, *scope.static.params, *scope.static.defines, *scope.variables)
    if not facing.steps and name.text not in known:
        raise scope.problems.unknown(name, FACINGS, "what an agent can be made to face")
    way = scope.narrowed(facing)
    check_heading(way, facing, "a heading, such as `north` or `x.heading`, or `same`", scope)
    return {"way": way}


def _check_stay(stay: ast.Name | None, who_stays: str, scope: Scope) -> None:
    """Reports anything but `stay` after `otherwise`. who_stays: by `otherwise stay`."""
    if stay is not None and stay.text != "stay":
        help_ = f"write `otherwise stay`: {who_stays} stays"
        fix = Fix(stay.span, "stay")
        raise scope.fail(errors.UnknownName(stay.span, name=stay.text, help=help_, fix=fix))


def send(s: ast.Send, scope: Scope, streams: Streams) -> ir.Stmt:
    """Returns `send x to CELL` as a shift if it happens at once, else `send x to DOMAIN`."""
    who = body(s.who, scope)
    after = None
    arrival_scope = scope
    if s.after is not None:
        after = scope.not_negative(s.after, ("steps",), "a number of steps", "the delay")
        arrival_scope = when_back(who, scope, LATER)
    if isinstance(after, ir.Number) and after.value == 0:
        after = None
    cell = _one_cell(s.domain, arrival_scope)
    facing = _facing(s.facing, scope)
    _check_stay(s.stay, "who finds no cell", scope)
    if cell is not None and s.stay is None:
        raise _perhaps_taken(s, cell, scope)
    if cell is not None and after is None:
        header = streams.header(s.span)
        return ir.Shift(
            who=who,
            to=cell,
            **facing,
            stream=streams.of_statement(header),
            heading_stream=streams.of_statement(f"heading of {header}"),
            origin=s.span,
        )
    if cell is None:
        assert isinstance(s.domain, ast.Domain)
        destination = _cells_to_choose_from(s.domain, arrival_scope, scope)
    else:
        destination = _domain_of_cell(s.domain.span, cell)
    header = streams.header(s.domain.span)
    if is_member(who, "mover"):  # movers of each name are placed by themselves
        header = f"{header} of {who.entity_type.name}"
    return ir.Send(
        who=who,
        domain=destination,
        after=after,
        **facing,
        stay=s.stay is not None,
        pool=streams.pools.setdefault(header, len(streams.pools)),
        cell_stream=streams.shared("send to", header),
        heading_stream=streams.shared("heading of those sent to", header),
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


def _cells_to_choose_from(d: ast.Domain, arrival_scope: Scope, scope: Scope) -> ir.Domain:
    """Returns the cells of which somebody is sent to one that is free.

    arrival_scope: what their `where` may name. scope: names that their variable can't have.
    """
    check_free(d.bind or d.kind, scope, d.bind is not None)
    cells, _ = domain(d, arrival_scope)
    has_place = cells.on is not None or cells.restriction is not None
    if has_place or not is_member(cells.var, "cell"):
        raise scope.expected(d.span, "a kind of cell, perhaps with `where`", "another domain")
    return cells


def _domain_of_cell(span: Span, cell: ir.Expr) -> ir.Domain:
    """Returns the domain of one cell, with a variable that the cell doesn't read."""
    names_read = {variable.name for variable in free_variables(cell)}
    name = next(name for name in ("cell", "cell_", "cell__") if name not in names_read)
    entity_type = ir.EntityType("cell", kinds_of_cell(cell) or ())
    var = ir.Member(name=name, entity_type=entity_type, origin=span)
    is_cell = ir.Same(left=var, right=cell, origin=span)
    return ir.Domain(var=var, where=is_cell, origin=span)


def _one_cell(d: ast.Domain | ast.Path, scope: Scope) -> ir.Expr | None:
    """Returns the one cell that a destination is, of a field or a variable; None for a domain."""
    if isinstance(d, ast.Domain):
        name = d.kind.text
        is_name = all(part is None for part in (d.bind, d.on, d.restriction, d.where))
        known = (scope.variables, scope.withheld, scope.static.fields)
        if not is_name or not any(name in names for names in known):
            return None
        if name in scope.withheld and scope.static.kinds_of(name):
            help_ = f"any cell of the kind is `{name} as other`; {scope.withheld[name]}"
            actual = "a cell of the statements around"
            raise scope.misused(d.kind, actual, "a destination that is known later", help_)
        d = ast.Path(d.span, d.kind, ())
    cell = scope.expression(d)
    if not kinds_of_cell(cell):
        raise wrong_type(scope, d, "a kind of cell, or a field that holds a cell", cell.type)
    return cell


def shift(s: ast.Shift, scope: Scope, streams: Streams) -> ir.Stmt:
    """Returns `send x by n DIRECTION`."""
    who = body(s.who, scope)
    check_placed(who, s.span, "send … by", scope)
    direction = _direction(s.direction, who, scope)
    facing = _facing(s.facing, scope) or {"facing": "same"}
    _check_stay(s.stay, "who cannot go there", scope)
    if s.stay is None:
        raise scope.fail(errors.NoWayFree(s.span))
    stream = streams.of_line(s.span)
    wanted = "a number of cells"
    steps = scope.not_negative(s.steps, ("cells", "count"), wanted, "the number of cells")
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
        **facing,
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
