"""Evaluates expressions in one instance, reading the state before the phase (the snapshot).

Also computes the members of domains and the lanes of shapes: a domain has conditions, a condition
counts over domains, and a lane ends where a condition holds, so that these three are one recursion.
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
    type_of_body,
    where_is,
)
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.members import Bound, agent_on, body_on, is_on_map
from sjdsl.interpreter.shapes import Seen, lanes_from
from sjdsl.interpreter.state import HEADINGS, Cell, Mover, Value


def evaluate(e: ir.Expr, instance: Instance) -> Value:
    """Returns the value of an expression, reals as float32.

    Asserts that numbers and enum values are in the range of their types.
    """
    if e.__class__ in _CACHED and _is_closed(e, instance.board):
        if id(e) not in instance.known:
            instance.known[id(e)] = (e, _checked(e, instance))
        return instance.known[id(e)][1]
    return _checked(e, instance)


def _checked(e: ir.Expr, instance: Instance) -> Value:
    """Returns the value of an expression that isn't cached, within the range of its type."""
    value = VALUES[e.__class__](e, instance)
    type_ = e.type
    if type_.kind == "real":
        value = numbers.real(value)
    if type_.kind in ("real", "int"):
        numbers.check_interval(value, type_, e)
    elif type_.kind == "word" and not type_.indexed_by:
        assert value in type_.words, (value, e)
    return value


def _is_closed(e: ir.Expr, board: Board) -> bool:
    """Returns whether all variables of an expression are bound inside it.

    The board caches the answers.
    """
    if id(e) not in board.closed:
        board.closed[id(e)] = (e, not free_variables(e))
    return board.closed[id(e)][1]


# Functions of (e, instance) evaluate the classes of expressions for which VALUES names them.


def _name(e: "ir.Member | ir.Local", instance: Instance) -> Value:
    assert e.name in instance.names, f"`{e.name}` has no value here"
    return instance.names[e.name]


def _over_domain(e: ir.Sum | ir.Extreme, instance: Instance) -> Value:
    """Returns the sum, minimum or maximum of a value over the members of a domain."""
    values = [evaluate(e.value, instance.binding(m.names)) for m in members_of(e.domain, instance)]
    if isinstance(e, ir.Sum):
        return numbers.total(values, e.type.kind == "real")
    if not values:
        assert e.otherwise is not None, f"`{e.fn}` over nobody"
        return evaluate(e.otherwise, instance)
    return min(values) if e.fn == "min" else max(values)


def _before(e: ir.Before, instance: Instance) -> Value:
    assert instance.earlier is not None, "no step has been taken"
    return evaluate(e.value, instance.earlier.only(instance.names))


def _is_in_range(e: ir.InRange, instance: Instance) -> bool:
    value = evaluate(e.value, instance)
    is_high_enough = numbers.compare("<=", evaluate(e.low, instance), value)
    return is_high_enough and numbers.compare("<=", value, evaluate(e.high, instance))


def _stands_on(e: ir.StandsOn, instance: Instance) -> bool:
    cell = where_is(evaluate(e.agent, instance), instance.world)
    return cell is not None and instance.board.kind_of[cell] in e.kinds


def _chosen_arguments(
    e: ir.ChoseWith | ir.ArgumentOf, instance: Instance
) -> tuple[Value, ...] | None:
    """Returns the arguments of an agent's action; None if it chose another action."""
    action = action_named(instance.board.game, e.action)
    return arguments_of(action, instance.actions[evaluate(e.agent, instance)])


def _chose_with(e: ir.ChoseWith, instance: Instance) -> bool:
    """Returns whether the agent chose this action, and with these arguments if it has some."""
    arguments = _chosen_arguments(e, instance)
    if arguments is None or not e.given:
        return arguments is not None
    return all(
        evaluate(given.value, instance) == argument
        for given, argument in zip(e.given, arguments, strict=True)
    )


def _argument_of(e: ir.ArgumentOf, instance: Instance) -> Value:
    arguments = _chosen_arguments(e, instance)
    assert arguments is not None, f"the arguments of `{e.action}`, which was not chosen"
    return arguments[e.number]


def _logic(e: ir.Logic, instance: Instance) -> bool:
    """Returns the value of `and` or `or`.

    Both stop at the first side that decides, so that this side can guard the next one.
    """
    decides = e.fn == "or"
    for arg in e.args:
        if bool(evaluate(arg, instance)) == decides:
            return decides
    return not decides


def _field(e: ir.FieldRead, instance: Instance) -> Value:
    """Returns the value of a field of its owner, or of the world."""
    if e.owner is None:
        return instance.world.fields[e.name]
    owner = evaluate(e.owner, instance)
    assert owner is not None, f"`{e.name}` of nobody"
    if e.held_by.what == "agent":
        return instance.world.agents[e.name][owner]
    if e.held_by.what == "mover":
        return instance.world.movers[owner.entity_type].fields[e.name][owner.number]
    return instance.world.cells[instance.board.kind_of[owner], e.name][instance.board.number[owner]]


def _distance(e: ir.Distance, instance: Instance) -> int:
    """Returns the steps between two agents, movers or cells."""
    a = cell_of(e.left, instance)
    b = cell_of(e.right, instance)
    assert a is not None and b is not None, f"the place of somebody who is away, or nowhere: {e}"
    return instance.board.steps(a, b)


def _bearing(e: ir.Bearing, instance: Instance) -> int:
    """Returns how many steps ahead of somebody, or to the right, an agent, mover or cell is."""
    a = cell_of(e.left, instance)
    b = cell_of(e.right, instance)
    assert a is not None and b is not None, f"the place of somebody who is away, or nowhere: {e}"
    heading = heading_of(evaluate(e.left, instance), instance.world)
    direction = heading if e.fn == "steps_ahead" else (heading + 1) % 4
    return instance.board.steps_toward(direction, a, b)


def cell_of(e: ir.Expr, instance: Instance) -> Cell | None:
    """Returns the cell that an expression is, or that its agent or mover stands on."""
    owner = evaluate(e, instance)
    return owner if owner is None or isinstance(owner, Cell) else where_is(owner, instance.world)


def _attribute(e: ir.Attribute, instance: Instance) -> Value:
    """Returns a fact about an agent, a mover or a cell that is no field."""
    owner = evaluate(e.owner, instance)
    assert owner is not None, f"`{e.name}` of nobody"
    match e.name:
        case "index":
            return number_of(owner)
        case "heading":
            return HEADINGS[heading_of(owner, instance.world)]
        case "moved":
            return herd_of(owner, instance.world).moved[number_of(owner)]
        case "away":
            return not is_on_map(owner, instance.world)
        case "row" | "col":
            cell = owner if isinstance(owner, Cell) else where_is(owner, instance.world)
            assert cell is not None, f"`{e.name}` of somebody who is away"
            return cell.row if e.name == "row" else cell.col
        case _:
            assert_never(e.name)


def _entry(e: ir.At, instance: Instance) -> Value:
    """Returns the entry of a row at a key, or the mean of the entries weighted by a mix."""
    row = evaluate(e.row, instance)
    key = evaluate(e.key, instance)
    index_set = e.row.type.indexed_by[0]
    if e.key.type.kind != "mix":
        return row[entry_place(index_set, key)]
    shares = dict(zip(e.key.type.words, key, strict=True))
    parts = [
        numbers.arithmetic("*", [shares[name], entry], is_real=True)
        for name, entry in zip(index_set.names, row, strict=True)
    ]
    return reduce(lambda total, part: numbers.arithmetic("+", [total, part], is_real=True), parts)


def _case(e: ir.Case, instance: Instance) -> Value:
    """Returns the value of the one arm that applies."""
    subject = evaluate(e.subject, instance)
    if isinstance(subject, bool):
        subject = "yes" if subject else "no"
    arms = [arm for arm in e.arms if applies(arm, subject)]
    assert len(arms) == 1, f"{len(arms)} arms apply to {subject}"
    return evaluate(arms[0].value, instance)


def _of_all_entries(e: ir.SumRow, instance: Instance) -> Value:
    """Returns the sum, the least or the greatest of a row."""
    entries = list(evaluate(e.row, instance))
    match e.fn:
        case "sum":
            return numbers.total(entries, e.type.kind == "real")
        case "min":
            return min(entries)
        case _:
            return max(entries)


def _shifted(e: ir.ShiftRow, instance: Instance) -> Value:
    """Returns a row whose entries moved `by` places towards its end; a filler takes their place."""
    entries = evaluate(e.row, instance)
    filler = evaluate(e.filler, instance)
    if e.type.kind == "agents" and filler is None:
        filler = frozenset()
    sources = [index - e.by for index in range(len(entries))]
    return tuple(entries[source] if 0 <= source < len(entries) else filler for source in sources)


def _lowest(e: ir.Lowest, instance: Instance) -> str | int:
    """Returns the first key whose entry is positive, or the first of all if none is.

    With `last`, the last one.
    """
    index_set = e.row.type.indexed_by[0]
    entries = zip(index_set.names, evaluate(e.row, instance), strict=True)
    names = [name for name, entry in entries if entry > 0] or index_set.names
    name = names[-1] if e.last else names[0]
    return int(name) if index_set.kind == "number" else name


def members_of(domain: ir.Domain, instance: Instance) -> list[Bound]:
    """Returns the members of a domain in the order of their numbers."""
    candidates = _candidates(domain, instance)
    members = [_bind(domain, member, number, instance) for member, number in candidates]
    return [member for member in members if member is not None]


def nearest_members(domain: ir.Domain, instance: Instance) -> list[Bound | None]:
    """Returns for each lane of the domain's shape its nearest member, None where there is none."""
    assert isinstance(domain.restriction, ir.Near), "only a shape has lanes"
    return [_nearest_in(domain, lane, instance) for lane in lanes(domain.restriction, instance)]


def lanes(near: ir.Near, instance: Instance) -> list[list[Seen]]:
    """Returns the lanes of a shape around its anchor, as far as they go."""
    shape = instance.board.shapes[near.shape]
    anchor = instance.names[near.anchor.name]
    body = None if near.anchor.entity_type.what == "cell" else anchor
    place = anchor if body is None else where_is(body, instance.world)
    heading = heading_of(body, instance.world) if shape.directed and body is not None else 0

    def is_end(cell: Cell) -> bool:
        return is_blocked(cell, shape.name, body, instance)

    return lanes_from(shape, place, heading, instance.board.at, is_end)


def cells_in(near: ir.Near, instance: Instance) -> dict[Cell, int]:
    """Returns the cells of the shape with their numbers.

    A cell of two lanes has that of the first.
    """
    numbers: dict[Cell, int] = {}
    for lane in lanes(near, instance):
        for cell, number in lane:
            numbers.setdefault(cell, number)
    return numbers


def is_blocked(cell: Cell, blocked: str, body: Body | None, instance: Instance) -> bool:
    """Returns whether a cell, or an agent on it, blocks something.

    Args:
      blocked: `agents`, an entity type of movers, or the name of a shape.
      body: the agent or mover that moves, or the anchor of the shape.
    """
    if blocked != "agents" and _agent_blocks(cell, blocked, instance):
        return True
    kind = instance.board.kinds[instance.board.kind_of[cell]]
    names: dict[str, Value] = {kind.name: cell}
    if body is not None:
        names[type_of_body(body).name] = body
    return any(
        block.what == blocked
        and (block.condition is None or evaluate(block.condition, instance.only(names)))
        for block in kind.blocks
    )


def _agent_blocks(cell: Cell, blocked: str, instance: Instance) -> bool:
    """Returns whether an agent that blocks movers or a shape stands on a cell."""
    blocks = [block for block in instance.board.game.agents.blocks if block.what == blocked]
    other = agent_on(cell, instance.world) if blocks else None
    if other is None:
        return False
    inner = instance.only({"agent": other})
    return any(block.condition is None or evaluate(block.condition, inner) for block in blocks)


def _nearest_in(domain: ir.Domain, lane: list[Seen], instance: Instance) -> Bound | None:
    """Returns the nearest member in a lane, None if there is none."""
    for cell, number in lane:
        if domain.var.entity_type.what != "cell":
            body = body_on(cell, domain, instance.world)
            member = None if body is None else _bind(domain, body, number_of(body), instance)
        else:
            is_of_kind = instance.board.kind_of[cell] in domain.var.kinds
            member = _bind(domain, cell, number, instance) if is_of_kind else None
        if member is not None:
            return member
    return None


def _candidates(domain: ir.Domain, instance: Instance) -> list[tuple[Body | Cell, int]]:
    """Returns the bodies or cells that pass the restriction of a domain.

    Each with its number, in the order of these.
    """
    restriction = domain.restriction
    if domain.var.entity_type.what == "cell" and isinstance(restriction, ir.Near):
        cells = cells_in(restriction, instance)  # numbered as cells of the shape
        of_kinds = [cell for cell in cells if instance.board.kind_of[cell] in domain.var.kinds]
        return [(cell, cells[cell]) for cell in sorted(of_kinds, key=cells.__getitem__)]
    population = _population(domain, instance)
    match restriction:
        case None:
            return population
        case ir.Near():
            cells = cells_in(restriction, instance)
            return [
                (body, number)
                for body, number in population
                if not isinstance(body, Cell) and where_is(body, instance.world) in cells
            ]
        case ir.InAgents():
            allowed = set(agents_in(evaluate(restriction.value, instance)))
        case ir.InCell():
            allowed = {evaluate(restriction.value, instance)}
        case ir.Among():
            allowed = {instance.names[member.name] for member in restriction.members}
        case _:
            assert_never(restriction)
    return [(member, number) for member, number in population if member in allowed]


def _population(domain: ir.Domain, instance: Instance) -> list[tuple[Body | Cell, int]]:
    """Returns the bodies of the domain's entity type that aren't away, or the cells of its kinds.

    Each with its number.
    """
    entity_type = domain.var.entity_type
    if entity_type.what == "cell":
        return [
            (cell, number)
            for number, cell in enumerate(cells_of(instance.board, entity_type.names))
        ]
    herd = (
        instance.world.movers[entity_type.name] if entity_type.what == "mover" else instance.world
    )
    present = [number for number, away in enumerate(herd.away) if away is None]
    if entity_type.what == "mover":
        return [(Mover(entity_type.name, number), number) for number in present]
    return [(number, number) for number in present]


def _bind(domain: ir.Domain, member: Body | Cell, number: int, instance: Instance) -> Bound | None:
    """Returns a member with the variables that it binds.

    None if it doesn't pass `on` and `where`.
    """
    names: dict[str, Value] = {domain.var.name: member}
    if domain.on is not None:
        assert not isinstance(member, Cell), "only agents and movers stand on something"
        cell = where_is(member, instance.world)
        if cell is None or instance.board.kind_of[cell] not in domain.on.kinds:
            return None
        names[domain.on.name] = cell
    if domain.where is not None and not evaluate(domain.where, instance.binding(names)):
        return None
    return Bound(member, number, names)


# Expressions whose values are cached in an instance if they have no free variables.
_CACHED = (ir.Named, ir.Count, ir.Sum, ir.Extreme)

# A table because `sjdsl test` evaluates millions of expressions: `match` would try case after case.
VALUES: dict[type[ir.Node], Callable[[Any, Instance], Value]] = {
    ir.Member: _name,
    ir.Local: _name,
    ir.FieldRead: _field,
    ir.Number: lambda e, _: e.value,
    ir.Word: lambda e, _: e.value,
    ir.Truth: lambda e, _: e.value,
    ir.Nobody: lambda _, __: None,
    ir.Nowhere: lambda _, __: None,
    ir.ParamRef: lambda e, instance: instance.world.params[e.name],
    ir.Attribute: _attribute,
    ir.Distance: _distance,
    ir.Bearing: _bearing,
    ir.At: _entry,
    ir.Step: lambda _, instance: instance.world.step,
    ir.Arithmetic: lambda e, instance: numbers.arithmetic(
        e.fn, [evaluate(a, instance) for a in e.args], e.type.kind == "real"
    ),
    ir.Count: lambda e, instance: len(members_of(e.domain, instance)),
    ir.Sum: _over_domain,
    ir.SumRow: _of_all_entries,
    ir.ShiftRow: _shifted,
    ir.Extreme: _over_domain,
    ir.Case: _case,
    ir.Lowest: _lowest,
    ir.Mix: lambda e, instance: numbers.shares(evaluate(e.row, instance)),
    ir.Named: lambda e, instance: evaluate(e.value, instance),
    ir.Narrowed: lambda e, instance: evaluate(e.value, instance),
    ir.Before: _before,
    ir.EventTotal: lambda e, instance: sum(
        n
        for (name, word), n in instance.totals.items()
        if name == e.name and e.word in (None, word)
    ),
    ir.Compare: lambda e, instance: numbers.compare(
        e.fn, evaluate(e.left, instance), evaluate(e.right, instance)
    ),
    ir.Same: lambda e, instance: evaluate(e.left, instance) == evaluate(e.right, instance),
    ir.InRange: _is_in_range,
    ir.InWords: lambda e, instance: evaluate(e.value, instance) in e.words,
    ir.InSet: lambda e, instance: (
        evaluate(e.value, instance) in agents_in(evaluate(e.container, instance))
    ),
    ir.IsEmpty: lambda e, instance: not agents_in(evaluate(e.container, instance)),
    ir.Chose: lambda e, instance: instance.actions[evaluate(e.agent, instance)] == e.action,
    ir.ChoseWith: _chose_with,
    ir.ArgumentOf: _argument_of,
    ir.Unoccupied: lambda e, instance: is_free(evaluate(e.cell, instance), instance.world),
    ir.StandsOn: _stands_on,
    ir.StandsAt: lambda e, instance: (
        where_is(evaluate(e.agent, instance), instance.world) == evaluate(e.cell, instance)
    ),
    ir.Not: lambda e, instance: not evaluate(e.value, instance),
    ir.Logic: _logic,
    ir.MatrixClass: lambda e, instance: is_of_class(e.name, evaluate(e.table, instance)),
}


def arguments_of(action: ir.ActionWithArguments, number: int) -> tuple[Value, ...] | None:
    """Returns the arguments of an action with this number.

    None if the number is another action's.
    """
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
    """Returns the agents of a value: of a set, of one agent, or of nobody."""
    if isinstance(value, frozenset):
        return value
    return frozenset() if value is None else frozenset({value})


def entry_place(index_set: ir.IndexSet, key: Value) -> int:
    """Returns the index of the entry of a key.

    The key is an enum value, a number of the range, or an agent.
    """
    index = index_set.place_of(key)
    assert 0 <= index < len(index_set), f"no entry for {key} in {index_set}"
    return index


def applies(arm: ir.Arm, subject: int | str) -> bool:
    """Returns whether an arm of a `case` is for this enum value or number."""
    if isinstance(subject, str):
        return subject in arm.words
    return (arm.low is None or arm.low <= subject) and (arm.high is None or subject <= arm.high)


def is_of_class(
    name: Literal["prisoners_dilemma", "stag_hunt", "chicken"],
    table: tuple[tuple[Value, Value], tuple[Value, Value]],
) -> bool:
    """Returns whether a table of payoffs is such a game.

    Its entries are [own choice][other's choice], cooperation first.

    Source: Macy and Flache, "Learning dynamics in social dilemmas", PNAS 2002; a chicken game by
    its order alone.
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
