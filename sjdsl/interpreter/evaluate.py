"""Evaluates expressions in one instance, reading the state before the phase (the snapshot).

Who belongs to a domain and how far a shape reaches is found here too: a domain has conditions, a condition counts over domains, and
lanes end where a condition holds, so that these three are one recursion.
"""

from collections.abc import Callable, Iterable
from functools import reduce
from itertools import islice, product
from typing import Any, Literal, assert_never

from sjdsl.compiler import ir
from sjdsl.compiler.ir.free_variables import free_variables
from sjdsl.compiler.ir.queries import action_named
from sjdsl.interpreter import numbers
from sjdsl.interpreter.board import Board, cells_of
from sjdsl.interpreter.bodies import (
    Body,
    heading_of,
    herd_of,
    is_free,
    number_of,
    sort_of_body,
    where_is,
)
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.members import Found, agent_on, body_on, is_here
from sjdsl.interpreter.shapes import Seen, lanes_from
from sjdsl.interpreter.state import HEADINGS, Cell, Mover, Value


def evaluate(e: ir.Expr, here: Instance) -> Value:
    """Returns the value of an expression; reals as float32, numbers and words checked against what their type allows."""
    if e.__class__ in _ONCE and _is_closed(e, here.board):
        if id(e) not in here.known:
            here.known[id(e)] = (e, _checked(e, here))
        return here.known[id(e)][1]
    return _checked(e, here)


def _checked(e: ir.Expr, here: Instance) -> Value:
    value, type_ = VALUES[e.__class__](e, here), e.type
    if type_.kind == "real":
        value = numbers.real(value)
    if type_.kind in ("real", "int"):
        numbers.check_interval(value, type_, e)
    elif type_.kind == "word" and not type_.by:
        assert value in type_.words, (value, e)
    return value


def _is_closed(e: ir.Expr, board: Board) -> bool:
    """Returns whether all variables of an expression are bound inside it. The board keeps the answers."""
    if id(e) not in board.closed:
        board.closed[id(e)] = (e, not free_variables(e))
    return board.closed[id(e)][1]


def _name(e: "ir.Member | ir.Local", here: Instance) -> Value:
    assert e.name in here.names, f"`{e.name}` has no value here"
    return here.names[e.name]


def _over_domain(e: ir.Sum | ir.Extreme, here: Instance) -> Value:
    values = [evaluate(e.value, here.binding(m.names)) for m in members_of(e.domain, here)]
    if isinstance(e, ir.Sum):
        return numbers.total(values, e.type.kind == "real")
    if not values:
        assert e.otherwise is not None, f"`{e.fn}` over nobody"
        return evaluate(e.otherwise, here)
    return min(values) if e.fn == "min" else max(values)


def _before(e: ir.Before, here: Instance) -> Value:
    assert here.earlier is not None, "no step has been taken"
    return evaluate(e.value, here.earlier.only(here.names))


def _is_in_range(e: ir.InRange, here: Instance) -> bool:
    value = evaluate(e.value, here)
    return numbers.compare("<=", evaluate(e.low, here), value) and numbers.compare(
        "<=", value, evaluate(e.high, here)
    )


def _stands_on(e: ir.StandsOn, here: Instance) -> bool:
    cell = where_is(evaluate(e.agent, here), here.world)
    return cell is not None and here.board.kind_of[cell] in e.kinds


def _chose_with(e: ir.ChoseWith, here: Instance) -> bool:
    taken = arguments_of(
        action_named(here.board.game, e.action), here.actions[evaluate(e.agent, here)]
    )
    return taken is not None and all(
        evaluate(given.value, here) == value for given, value in zip(e.given, taken, strict=False)
    )


def _argument_of(e: ir.ArgumentOf, here: Instance) -> Value:
    taken = arguments_of(
        action_named(here.board.game, e.action), here.actions[evaluate(e.agent, here)]
    )
    assert taken is not None, f"the arguments of `{e.action}`, which was not chosen"
    return taken[e.number]


def _logic(e: ir.Logic, here: Instance) -> bool:
    """Returns what `and` or `or` says; both stop at the first side that decides, so that guards protect."""
    decides = e.fn == "or"
    for arg in e.args:
        if bool(evaluate(arg, here)) == decides:
            return decides
    return not decides


def _field(e: ir.FieldRead, here: Instance) -> Value:
    if e.owner is None:
        return here.world.fields[e.name]
    owner = evaluate(e.owner, here)
    assert owner is not None, f"`{e.name}` of nobody"
    if e.held_by.what == "agent":
        return here.world.agents[e.name][owner]
    if e.held_by.what == "mover":
        return here.world.movers[owner.sort].fields[e.name][owner.number]
    return here.world.cells[here.board.kind_of[owner], e.name][here.board.number[owner]]


def _distance(e: ir.Distance, here: Instance) -> int:
    a, b = cell_of(e.left, here), cell_of(e.right, here)
    assert a is not None and b is not None, f"the place of somebody who is away, or nowhere: {e}"
    return here.board.steps(a, b)


def cell_of(e: ir.Expr, here: Instance) -> Cell | None:
    """Returns the cell that an expression is, or that its agent or mover stands on."""
    owner = evaluate(e, here)
    return owner if owner is None or isinstance(owner, Cell) else where_is(owner, here.world)


def _attribute(e: ir.Attribute, here: Instance) -> Value:
    owner = evaluate(e.owner, here)
    assert owner is not None, f"`{e.name}` of nobody"
    match e.name:
        case "index":
            return number_of(owner)
        case "heading":
            return HEADINGS[heading_of(owner, here.world)]
        case "moved":
            return herd_of(owner, here.world).moved[number_of(owner)]
        case "away":
            return not is_here(owner, here.world)
        case "row" | "col":
            cell = owner if isinstance(owner, Cell) else where_is(owner, here.world)
            assert cell is not None, f"`{e.name}` of somebody who is away"
            return cell.row if e.name == "row" else cell.col
        case _:
            assert_never(e.name)


def _entry(e: ir.At, here: Instance) -> Value:
    row, key, level = evaluate(e.row, here), evaluate(e.key, here), e.row.type.by[0]
    if e.key.type.kind != "mix":
        return row[entry_place(level, key)]
    share = dict(zip(e.key.type.words, key, strict=True))
    parts = [
        numbers.arithmetic("*", [share[name], entry], is_real=True)
        for name, entry in zip(level.names, row, strict=True)
    ]
    return reduce(lambda before, part: numbers.arithmetic("+", [before, part], is_real=True), parts)


def _case(e: ir.Case, here: Instance) -> Value:
    subject = evaluate(e.subject, here)
    if isinstance(subject, bool):
        subject = "yes" if subject else "no"
    arms = [arm for arm in e.arms if applies(arm, subject)]
    assert len(arms) == 1, f"{len(arms)} arms apply to {subject}"
    return evaluate(arms[0].value, here)


def _of_all_entries(e: ir.SumRow, here: Instance) -> Value:
    row = list(evaluate(e.row, here))
    return (
        numbers.total(row, e.type.kind == "real")
        if e.fn == "sum"
        else min(row)
        if e.fn == "min"
        else max(row)
    )


def _shifted(e: ir.ShiftRow, here: Instance) -> Value:
    row, filler = evaluate(e.row, here), evaluate(e.filler, here)
    filler = frozenset() if e.type.kind == "agents" and filler is None else filler
    return tuple(
        row[place - e.by] if 0 <= place - e.by < len(row) else filler for place in range(len(row))
    )


def _lowest(e: ir.Lowest, here: Instance) -> str | int:
    level, order = e.row.type.by[0], -1 if e.last else 0
    positive = [
        name for name, entry in zip(level.names, evaluate(e.row, here), strict=True) if entry > 0
    ]
    found = positive[order] if positive else level.names[order]
    return int(found) if level.sort == "number" else found


def members_of(domain: ir.Domain, here: Instance) -> list[Found]:
    """Returns the members in the order of their numbers."""
    members = (
        _restricted(domain, member, number, here) for member, number in _candidates(domain, here)
    )
    return [m for m in members if m is not None]


def nearest_members(domain: ir.Domain, here: Instance) -> list[Found | None]:
    """Returns for each lane of the domain's shape its nearest member, None where there is none."""
    assert isinstance(domain.restriction, ir.Near), "only a shape has lanes"
    return [_first(domain, lane, here) for lane in lanes(domain.restriction, here)]


def lanes(near: ir.Near, here: Instance) -> list[list[Seen]]:
    """Returns the lanes of a shape around its anchor, as far as they go."""
    shape, anchor = here.board.shapes[near.shape], here.names[near.anchor.name]
    body = None if near.anchor.sort.what == "cell" else anchor
    place = anchor if body is None else where_is(body, here.world)
    heading = heading_of(body, here.world) if shape.directed and body is not None else 0
    return lanes_from(
        shape, place, heading, here.board.at, lambda cell: is_blocked(cell, shape.name, body, here)
    )


def cells_in(near: ir.Near, here: Instance) -> dict[Cell, int]:
    """Returns the cells of the shape with their numbers; a cell of two lanes has the first one's."""
    numbers: dict[Cell, int] = {}
    for lane in lanes(near, here):
        for cell, number in lane:
            numbers.setdefault(cell, number)
    return numbers


def is_blocked(cell: Cell, what: str, body: Body | None, here: Instance) -> bool:
    """Returns whether the cell's kind blocks `what`: agents, a sort of movers, or the shape of that name (or an agent on it does).

    `body`: who moves, or the anchor.
    """
    if what != "agents" and _agent_stops(cell, what, here):
        return True
    kind = here.board.kinds[here.board.kind_of[cell]]
    names: dict[str, Value] = {kind.name: cell}
    if body is not None:
        names[sort_of_body(body).name] = body
    return any(
        block.what == what
        and (block.condition is None or evaluate(block.condition, here.only(names)))
        for block in kind.blocks
    )


def _agent_stops(cell: Cell, shape: str, here: Instance) -> bool:
    """Returns whether an agent stands on the cell that ends the lanes of the shape."""
    blocks = [block for block in here.board.game.agents.blocks if block.what == shape]
    other = agent_on(cell, here.world) if blocks else None
    if other is None:
        return False
    inside = here.only({"agent": other})
    return any(block.condition is None or evaluate(block.condition, inside) for block in blocks)


def _first(domain: ir.Domain, lane: list[Seen], here: Instance) -> Found | None:
    for cell, number in lane:
        if domain.var.sort.what != "cell":
            body = body_on(cell, domain, here.world)
            member = None if body is None else _restricted(domain, body, number_of(body), here)
        else:
            is_kind = here.board.kind_of[cell] in domain.var.kinds
            member = _restricted(domain, cell, number, here) if is_kind else None
        if member is not None:
            return member
    return None


def _candidates(domain: ir.Domain, here: Instance) -> list[tuple[Body | Cell, int]]:
    """Returns who may be a member, or which cells, as far as the domain's restriction says; each with its number, in their order."""
    sort, restriction = domain.var.sort, domain.restriction
    everything: list[tuple[Body | Cell, int]]
    if sort.what == "cell":
        everything = [
            (cell, number) for number, cell in enumerate(cells_of(here.board, sort.names))
        ]
    else:
        herd = here.world.movers[sort.name] if sort.what == "mover" else here.world
        numbers = [number for number, away in enumerate(herd.away) if away is None]
        everything = [
            (Mover(sort.name, number) if sort.what == "mover" else number, number)
            for number in numbers
        ]
    match restriction:
        case None:
            return everything
        case ir.Near():
            near = cells_in(restriction, here)
            if sort.what == "cell":  # their numbers are those in the shape
                inside = [
                    (cell, number)
                    for cell, number in near.items()
                    if here.board.kind_of[cell] in sort.names
                ]
                return sorted(inside, key=lambda pair: pair[1])
            return [
                pair
                for pair in everything
                if not isinstance(pair[0], Cell) and where_is(pair[0], here.world) in near
            ]
        case ir.InAgents():
            chosen = set(agents_in(evaluate(restriction.value, here)))
        case ir.InCell():
            chosen = {evaluate(restriction.value, here)}
        case ir.Among():
            chosen = {here.names[m.name] for m in restriction.members}
        case _:
            assert_never(restriction)
    return [pair for pair in everything if pair[0] in chosen]


def _restricted(
    domain: ir.Domain, member: Body | Cell, number: int, here: Instance
) -> Found | None:
    """Returns the member with what it binds if it passes `on` and `where`."""
    names: dict[str, Value] = {domain.var.name: member}
    if domain.on is not None:
        assert not isinstance(member, Cell), "only agents and movers stand on something"
        cell = where_is(member, here.world)
        if cell is None or here.board.kind_of[cell] not in domain.on.kinds:
            return None
        names[domain.on.name] = cell
    if domain.where is not None and not evaluate(domain.where, here.binding(names)):
        return None
    return Found(member, number, names)


_ONCE = (ir.Named, ir.Count, ir.Sum, ir.Extreme)  # kept where they name nothing around them

# The value of each class of expression, looked up: `sjdsl test` asks this millions of times.
VALUES: dict[type[ir.Node], Callable[[Any, Instance], Value]] = {
    ir.Member: _name,
    ir.Local: _name,
    ir.FieldRead: _field,
    ir.Number: lambda e, _: e.value,
    ir.Word: lambda e, _: e.value,
    ir.Truth: lambda e, _: e.value,
    ir.Nobody: lambda _, __: None,
    ir.Nowhere: lambda _, __: None,
    ir.ParamRef: lambda e, here: here.world.params[e.name],
    ir.Attribute: _attribute,
    ir.Distance: _distance,
    ir.At: _entry,
    ir.Step: lambda _, here: here.world.step,
    ir.Arithmetic: lambda e, here: numbers.arithmetic(
        e.fn, [evaluate(a, here) for a in e.args], e.type.kind == "real"
    ),
    ir.Count: lambda e, here: len(members_of(e.domain, here)),
    ir.Sum: _over_domain,
    ir.SumRow: _of_all_entries,
    ir.ShiftRow: _shifted,
    ir.Extreme: _over_domain,
    ir.Case: _case,
    ir.Lowest: _lowest,
    ir.Mix: lambda e, here: numbers.shares(evaluate(e.row, here)),
    ir.Named: lambda e, here: evaluate(e.value, here),
    ir.Narrowed: lambda e, here: evaluate(e.value, here),
    ir.Before: _before,
    ir.EventTotal: lambda e, here: sum(
        n for (name, word), n in here.totals.items() if name == e.name and e.word in (None, word)
    ),
    ir.Compare: lambda e, here: numbers.compare(
        e.fn, evaluate(e.left, here), evaluate(e.right, here)
    ),
    ir.Same: lambda e, here: evaluate(e.left, here) == evaluate(e.right, here),
    ir.InRange: _is_in_range,
    ir.InWords: lambda e, here: evaluate(e.value, here) in e.words,
    ir.InSet: lambda e, here: evaluate(e.value, here) in agents_in(evaluate(e.container, here)),
    ir.IsEmpty: lambda e, here: not agents_in(evaluate(e.container, here)),
    ir.Chose: lambda e, here: here.actions[evaluate(e.agent, here)] == e.action,
    ir.ChoseWith: _chose_with,
    ir.ArgumentOf: _argument_of,
    ir.Unoccupied: lambda e, here: is_free(evaluate(e.cell, here), here.world),
    ir.StandsOn: _stands_on,
    ir.StandsAt: lambda e, here: (
        where_is(evaluate(e.agent, here), here.world) == evaluate(e.cell, here)
    ),
    ir.Not: lambda e, here: not evaluate(e.value, here),
    ir.Logic: _logic,
    ir.MatrixClass: lambda e, here: is_of_class(e.name, evaluate(e.table, here)),
}


def arguments_of(action: ir.ActionWithArguments, number: int) -> tuple[Value, ...] | None:
    """Returns the arguments of an action with this number; None if it is another action's."""
    if number not in action.numbers:
        return None
    values: list[Iterable[Value]] = []
    for argument in action.arguments:
        if argument.type.kind == "word":
            values.append(argument.type.words)
        else:
            low = int(argument.type.low) if argument.type.kind == "int" else 0
            values.append(range(low, low + argument.count))
    return next(islice(product(*values), number - action.first, None))


def agents_in(value: Value) -> Iterable[int]:
    """Returns the agents of a set, the one agent, or none."""
    if isinstance(value, frozenset):
        return value
    return frozenset() if value is None else frozenset({value})


def entry_place(level: ir.Level, key: Value) -> int:
    """Returns the place of the entry that a key names: a word, a number of the range, or an agent."""
    place = level.place_of(key)
    assert 0 <= place < len(level), f"no entry for {key} in {level}"
    return place


def applies(arm: ir.Arm, subject: int | str) -> bool:
    """Returns whether an arm of a `case` is for this word or number."""
    if isinstance(subject, str):
        return subject in arm.words
    return (arm.low is None or arm.low <= subject) and (arm.high is None or subject <= arm.high)


def is_of_class(
    name: Literal["prisoners_dilemma", "stag_hunt", "chicken"],
    table: tuple[tuple[Value, Value], tuple[Value, Value]],
) -> bool:
    """Returns whether a table [own word][other's word], cooperation first, is such a game.

    Source: Macy and Flache, "Learning dynamics in social dilemmas", PNAS 2002; a chicken game by its order alone.
    """
    (reward, sucker), (temptation, punishment) = table
    match name:
        case "prisoners_dilemma":
            return bool(
                temptation > reward > punishment > sucker and 2 * reward > temptation + sucker
            )
        case "stag_hunt":
            return bool(reward > temptation >= punishment > sucker)
        case "chicken":
            return bool(temptation > reward > sucker > punishment)
        case _:
            assert_never(name)
