"""Elaborates domains: the agents or cells of a quantifier, its variables, facts that then hold."""

from dataclasses import replace

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.problems import Poisoned
from sjdsl.compiler.elaborate import shapes
from sjdsl.compiler.elaborate.lookup import (
    as_agent,
    bound_cell,
    check_free,
    check_placed,
    kinds_named,
    unknown,
)
from sjdsl.compiler.elaborate.possible import check_possible
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.ir.free_variables import free_variables
from sjdsl.compiler.ir.implications import compares, narrowed
from sjdsl.compiler.ir.queries import most_restricted
from sjdsl.compiler.ir.sorts import AGENTS
from sjdsl.compiler.ir.types import integer


def domain(d: ast.Domain, scope: Scope, warns: bool = True) -> tuple[ir.Domain, Scope]:
    """Returns a domain and the scope inside it. warns: of a condition that never holds."""
    sort = _sort_of(d.kind, scope)
    chosen = d.bind or d.kind
    var = ir.Member(name=_ir_name(chosen, scope), sort=sort, origin=d.kind.span)
    check_free(chosen, scope, d.bind is not None)
    restriction = None if d.restriction is None else _restriction(d.restriction, var, scope)
    inner = with_member(d.bind, d.kind, var, scope)
    on = None
    conditions: list[ir.Expr] = []
    if d.on is not None:
        if sort.what == "cell":
            raise scope.misused(d.kind, "a kind of cell", "an agent (`agent on KIND`)")
        cell = _cell_around(d.on, inner)
        if cell is not None:
            stands_at = ir.StandsAt(agent=var, cell=cell, origin=d.on.span)
            conditions.append(stands_at)
            inner = inner.knowing([stands_at, ir.StandsOn(agent=var, kinds=cell.sort.names)])
        else:
            on = _cell_under(d.on, inner)
            inner = with_member(d.on.bind, d.on.kind, on, inner)
            inner = inner.knowing([ir.StandsOn(agent=var, kinds=on.kinds)])
    if d.where is not None:
        where = inner.condition(d.where)
        if warns:
            check_possible(where, inner)
        conditions.append(where)
        inner = inner.knowing([where])
    condition: ir.Expr | None = None
    if len(conditions) == 1:
        condition = conditions[0]
    elif conditions:
        condition = ir.Logic(fn="and", args=tuple(conditions), origin=d.span)
    built = ir.Domain(var=var, on=on, restriction=restriction, where=condition, origin=d.span)
    return built, inner


def _sort_of(kind: ast.Name, scope: Scope) -> ir.Sort:
    """Returns what a name of agents, movers, a kind or a group stands for."""
    if kind.text == "agent":
        return AGENTS
    if kind.text in scope.static.movers:
        scope.static.use(kind, Symbol("name", kind.text))
        return ir.Sort("mover", (kind.text,))
    return ir.Sort("cell", kinds_named(kind, scope))


def _cell_under(on: ast.On, scope: Scope) -> ir.Member:
    """Returns the cell under an agent, which `on KIND` binds."""
    name = on.bind or on.kind
    check_free(name, scope, on.bind is not None)
    sort = ir.Sort("cell", kinds_named(on.kind, scope))
    return ir.Member(name=_ir_name(name, scope), sort=sort, origin=on.span)


def _cell_around(on: ast.On, scope: Scope) -> ir.Member | None:
    """Returns the cell of a statement around that `on NAME` means.

    None if `on` binds the cell under the agent.
    """
    cell = bound_cell(on.kind, scope)
    if cell is not None and on.bind is not None:
        name = on.kind.text
        taken_by = "a cell around this statement"
        help_ = (
            f"`on {name}` means that cell; to bind the cell under the agent, "
            f"rename the outer one: `{name} as one`"
        )
        raise scope.fail(errors.NameTaken(on.span, name=name, taken_by=taken_by, help=help_))
    return cell


def with_member(
    name: ast.Name | None, kind: ast.Name, var: ir.Member | None, scope: Scope
) -> Scope:
    """Returns a scope with the variable of a domain.

    It has the name of its kind if the text gives it none.
    """
    return scope.bind(kind.text, var) if name is None else scope.bind_named(name, var)


def _ir_name(name: ast.Name, scope: Scope) -> str:
    """Returns the name of a variable in the IR.

    In a define it differs from those of variables around its use, which the define doesn't see.
    """
    if not scope.defining:
        return name.text
    around = [v for v in scope.variables.values() if isinstance(v, ir.Node)]
    around += [f.condition for f in scope.facts]
    taken = {variable.name for node in around for variable in free_variables(node)}
    free_name = name.text
    while free_name in taken:
        free_name += "_"
    return free_name


def only_one_who(scope: Scope, who: ir.Expr, help_: str) -> Scope:
    """Returns a scope for what is read when an agent comes back.

    Of the variables around it sees this agent alone, which has no place; what is known now may
    not hold then. help_: for uses of the other variables.
    """
    returning = who.name if isinstance(who, ir.Member) else ""
    kept = {
        name: value
        for name, value in scope.variables.items()
        if name == returning or not isinstance(value, ir.Member | ir.Local)
    }
    return replace(
        scope,
        variables=kept,
        facts=tuple(f for f in scope.facts if not free_variables(f.condition)),
        withheld=dict.fromkeys(scope.variables.keys() - kept.keys(), help_),
        returning=returning,
    )


def _restriction(
    restriction: ast.Near | ast.Path | ast.Members, var: ir.Member, scope: Scope
) -> ir.Restriction:
    match restriction:
        case ast.Near():
            return near(restriction.shape, restriction.anchor, scope)
        case ast.Members():
            members = tuple(_variable(name, scope) for name in restriction.names)
            for other in members:
                are_cells = {other.sort.what, var.sort.what} == {"cell"}
                if other.sort != var.sort and not are_cells:
                    wanted = "variables of the same sort"
                    raise scope.expected(restriction.span, wanted, "a mixture")
            return ir.Among(members=members, origin=restriction.span)
        case ast.Path():
            value = scope.expression(restriction)
            if var.sort.what == "cell" and value.type.kind == "cell" and not value.type.by:
                if not set(var.kinds) & set(value.type.kinds):
                    raise scope.fail(errors.NeverOneCell(restriction.span))
                return ir.InCell(value=value, origin=restriction.span)
            holds_agents = value.type.kind == "agents" or as_agent(value)
            if var.sort.what != "agent" or not holds_agents:
                wanted = "a shape of something, or a field that holds agents or a cell"
                raise wrong_type(scope, restriction, wanted, value.type)
            return ir.InAgents(value=value, origin=restriction.span)


def near(ref: ast.ShapeRef, anchor: ast.Name, scope: Scope) -> ir.Near:
    """Returns `SHAPE of anchor`; a shape with a direction needs an agent."""
    shape = shapes.used(ref, scope)
    member = _variable(anchor, scope)
    if member.sort.what != "cell":
        check_placed(member, ref.span, f"{shape.name} of {anchor.text}", scope)
    if shape.directed and member.sort.what == "cell":
        raise scope.fail(errors.DirectedShape(ref.span, name=shape.name, anchor=anchor.text))
    return ir.Near(shape=shape.name, anchor=member, origin=ref.span)


def _variable(name: ast.Name, scope: Scope) -> ir.Member:
    """Returns the agent, mover or cell that a name stands for."""
    if name.text not in scope.variables:
        raise unknown(name, scope)
    scope.refer(name)
    bound = scope.variables[name.text]
    if bound is None:
        raise Poisoned
    if not isinstance(bound, ir.Member):
        raise scope.misused(name, "a value", "an agent or a cell")
    return bound.model_copy(update={"origin": name.span})


def most_members(d: ir.Domain, scope: Scope) -> int:
    """Returns the most members a domain can have."""
    static = scope.static
    match d.var.sort.what:
        case "agent":
            everywhere = static.num_agents
        case "mover":
            everywhere = static.movers[d.var.sort.name].number
        case "cell":
            everywhere = sum(static.cells.get(k, 0) for k in d.var.kinds)
        case "world":
            raise AssertionError(d)
    return most_restricted(d, everywhere, lambda near: static.shapes[near.shape].lanes)


def can_be_empty(d: ir.Domain, scope: Scope) -> bool:
    """Returns whether a domain may have no member, as far as map, rules and guards tell."""
    static = scope.static
    known = scope.facts_and_requires
    members = ir.Count(type=integer(0, most_members(d, scope)), domain=d)
    if narrowed(members, known)[0] > 0 or compares(members, "!=", 0, known):
        return False
    if d.where is not None or d.on is not None:
        return True
    match d.restriction:
        case None if d.var.sort.what == "cell":
            return not any(static.cells.get(kind, 0) for kind in d.var.kinds)
        case None:
            return static.can_be_away and not _has_present_member(d.var.sort, scope)
        case ir.Among():
            return d.var.sort.what == "cell"
        case _:
            return True


def _has_present_member(sort: ir.Sort, scope: Scope) -> bool:
    """Returns whether a domain around has an agent (or such a mover) that is on the map.

    In some parts of a game a variable may stand for one that is away.
    """
    if scope.part not in ("phase", "start", "metrics", "checks", "policy"):
        return False
    return any(isinstance(v, ir.Member) and v.sort == sort for v in scope.variables.values())
