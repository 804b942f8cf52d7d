"""Elaborates domains: the agents or cells of a quantifier, its variables, facts that then hold."""

from dataclasses import replace

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.elaborate import shapes
from sjdsl.compiler.elaborate.lookup import (
    bound_cell,
    check_free,
    check_placed,
    is_agent,
    is_member,
    kinds_named,
    unknown,
    variable,
)
from sjdsl.compiler.elaborate.possible import check_possible
from sjdsl.compiler.elaborate.scope import Scope, Static, wrong_type
from sjdsl.compiler.ir.entity_types import AGENTS
from sjdsl.compiler.ir.free_variables import free_variables
from sjdsl.compiler.ir.implications import compares, narrowed
from sjdsl.compiler.ir.queries import most_restricted
from sjdsl.compiler.ir.types import integer


def domain(d: ast.Domain, scope: Scope, warns: bool = True) -> tuple[ir.Domain, Scope]:
    """Returns a domain, such as `agent on plot where agent.bag > 0`, and the scope inside it.

    warns: whether a condition that never holds is reported.
    """
    var = new_member(d, _entity_type_named(d.kind, scope), scope)
    restriction = None if d.restriction is None else _restriction(d.restriction, var, scope)
    inner = with_member(d, var, scope)
    on: ir.Member | None = None
    conditions: list[ir.Expr] = []
    if d.on is not None:
        if is_member(var, "cell"):
            raise scope.misused(d.kind, "a kind of cell", "an agent (`agent on KIND`)")
        cell = _cell_around(d.on, inner)
        if cell is not None:  # `on plot` within `for plot …`: the agent stands on that cell
            stands_at = ir.StandsAt(agent=var, cell=cell, origin=d.on.span)
            conditions.append(stands_at)
            inner = inner.knowing([stands_at, ir.StandsOn(agent=var, kinds=cell.kinds)])
        else:  # `on plot` binds the cell below the agent
            entity_type = ir.EntityType("cell", kinds_named(d.on.kind, inner))
            on = new_member(d.on, entity_type, inner)
            inner = with_member(d.on, on, inner)
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


def _entity_type_named(kind: ast.Name, scope: Scope) -> ir.EntityType:
    """Returns what a name of agents, movers, a kind or a group stands for; reports any other."""
    if kind.text == "agent":
        return AGENTS
    if kind.text in scope.static.movers:
        scope.static.use(kind, Symbol("name", kind.text))
        return ir.EntityType("mover", (kind.text,))
    return ir.EntityType("cell", kinds_named(kind, scope))


def new_member(bound: ast.Domain | ast.On, entity_type: ir.EntityType, scope: Scope) -> ir.Member:
    """Returns the variable that a domain, or its `on KIND`, binds; reports a name in use."""
    name = bound.bind or bound.kind
    check_free(name, scope, bound.bind is not None)
    return ir.Member(name=_ir_name(name, scope), entity_type=entity_type, origin=bound.kind.span)


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


def with_member(bound: ast.Domain | ast.On, var: ir.Member | None, scope: Scope) -> Scope:
    """Returns a scope with the variable of a domain, or of its `on KIND`.

    It has the name of its kind if the text gives it none.
    """
    if bound.bind is None:
        return scope.bind(bound.kind.text, var)
    return scope.bind_named(bound.bind, var)


def _ir_name(name: ast.Name, scope: Scope) -> str:
    """Returns the name of a variable in the IR.

    In a define it differs from those of variables around its use, which the define doesn't see.
    """
    if not scope.defining:
        return name.text
    around = [value for value in scope.variables.values() if isinstance(value, ir.Node)]
    around += [fact.condition for fact in scope.facts]
    taken = {variable.name for node in around for variable in free_variables(node)}
    free_name = name.text
    while free_name in taken:
        free_name += "_"
    return free_name


def when_back(who: ir.Expr, scope: Scope, help_: str) -> Scope:
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
    """Returns what members of a domain are restricted to: `in beam of x`, `in { x, y }`, `in s`."""
    match restriction:
        case ast.Near():
            return near(restriction.shape, restriction.anchor, scope)
        case ast.Members():
            members = tuple(_named_member(name, scope) for name in restriction.names)
            for other in members:
                are_cells = {other.entity_type.what, var.entity_type.what} == {"cell"}
                if other.entity_type != var.entity_type and not are_cells:
                    wanted = "variables of the same sort"
                    raise scope.expected(restriction.span, wanted, "a mixture")
            return ir.Among(members=members, origin=restriction.span)
        case ast.Path():
            value = scope.expression(restriction)
            if is_member(var, "cell") and value.type.is_single("cell"):
                if not set(var.kinds) & set(value.type.kinds):
                    raise scope.fail(errors.NeverOneCell(restriction.span))
                return ir.InCell(value=value, origin=restriction.span)
            holds_agents = value.type.kind == "agents" or is_agent(value)
            if not (is_member(var, "agent") and holds_agents):
                wanted = "a shape of something, or a field that holds agents or a cell"
                raise wrong_type(scope, restriction, wanted, value.type)
            return ir.InAgents(value=value, origin=restriction.span)


def near(ref: ast.ShapeRef, anchor: ast.Name, scope: Scope) -> ir.Near:
    """Returns `SHAPE of anchor`; a shape with a direction needs an agent."""
    shape = shapes.used(ref, scope)
    member = _named_member(anchor, scope)
    if not is_member(member, "cell"):
        check_placed(member, ref.span, f"{shape.name} of {anchor.text}", scope)
    elif shape.directed:
        raise scope.fail(errors.DirectedShape(ref.span, name=shape.name, anchor=anchor.text))
    return ir.Near(shape=shape.name, anchor=member, origin=ref.span)


def _named_member(name: ast.Name, scope: Scope) -> ir.Member:
    """Returns the agent, mover or cell that a name stands for."""
    if name.text not in scope.variables:
        raise unknown(name, scope)
    member = variable(name, scope)
    if not isinstance(member, ir.Member):
        raise scope.misused(name, "a value", "an agent or a cell")
    return member


def most_members(d: ir.Domain, static: Static) -> int:
    """Returns the most members a domain can have."""
    match d.var.entity_type.what:
        case "agent":
            everywhere = static.num_agents
        case "mover":
            everywhere = static.movers[d.var.entity_type.name].number
        case "cell":
            everywhere = sum(static.cells.get(kind, 0) for kind in d.var.kinds)
        case "world":
            raise AssertionError(d)
    return most_restricted(d, everywhere, lambda near: static.shapes[near.shape].lanes)


def can_be_empty(d: ir.Domain, scope: Scope) -> bool:
    """Returns whether a domain may have no member, as far as map, rules and guards tell."""
    static = scope.static
    known = scope.facts_and_requires
    members = ir.Count(type=integer(0, most_members(d, static)), domain=d)
    least, _ = narrowed(members, known)
    if least > 0 or compares(members, "!=", 0, known):
        return False
    if d.where is not None or d.on is not None:
        return True
    match d.restriction:
        case None if is_member(d.var, "cell"):
            return not any(static.cells.get(kind, 0) for kind in d.var.kinds)
        case None:
            has_one_around = any(
                member.entity_type == d.var.entity_type for member in scope.members
            )
            # in the other parts of a game a variable may stand for one that is away
            is_on_map = scope.part in ("phase", "start", "metrics", "checks", "policy")
            return static.can_be_away and not (has_one_around and is_on_map)
        case ir.Among():
            return is_member(d.var, "cell")
        case _:
            return True
