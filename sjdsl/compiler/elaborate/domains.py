"""Elaborates domains: the agents or cells a quantifier ranges over, the variables it binds, and facts that then hold."""

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
from sjdsl.compiler.ir.queries import at_most
from sjdsl.compiler.ir.sorts import AGENTS
from sjdsl.compiler.ir.types import integer


def domain(d: ast.Domain, scope: Scope, warns: bool = True) -> tuple[ir.Domain, Scope]:
    """Returns a domain and the scope inside it. `warns`: of a condition that never holds."""
    if d.kind.text == "agent":
        sort = AGENTS
    elif d.kind.text in scope.static.movers:
        scope.static.use(d.kind, Symbol("name", d.kind.text))
        sort = ir.Sort("mover", (d.kind.text,))
    else:
        sort = ir.Sort("cell", kinds_named(d.kind, scope))
    chosen = d.bind or d.kind
    var = ir.Member(name=_own_name(chosen, scope), sort=sort, origin=d.kind.span)
    check_free(chosen, scope, d.bind is not None)
    restriction = None if d.restriction is None else _restriction(d.restriction, var, scope)
    inner = with_member(d.bind, d.kind, var, scope)
    on = None
    conditions: list[ir.Expr] = []
    if d.on is not None:
        if sort.what == "cell":
            wanted = "an agent (`agent on KIND`)"
            raise scope.misused(d.kind, "a kind of cell", wanted)
        cell = _cell_around(d.on, inner)
        if cell is not None:
            conditions.append(ir.StandsAt(agent=var, cell=cell, origin=d.on.span))
            inner = inner.knowing([*conditions, ir.StandsOn(agent=var, kinds=cell.sort.names)])
        else:
            under = d.on.bind or d.on.kind
            check_free(under, inner, d.on.bind is not None)
            on = ir.Member(
                name=_own_name(under, inner),
                sort=ir.Sort("cell", kinds_named(d.on.kind, inner)),
                origin=d.on.span,
            )
            inner = with_member(d.on.bind, d.on.kind, on, inner).knowing(
                [ir.StandsOn(agent=var, kinds=on.kinds)]
            )
    if d.where is not None:
        conditions.append(inner.condition(d.where))
        if warns:
            check_possible(conditions[-1], inner)
        inner = inner.knowing(conditions[-1:])
    where = conditions[0] if len(conditions) == 1 else None
    if len(conditions) > 1:
        where = ir.Logic(fn="and", args=tuple(conditions), origin=d.span)
    return ir.Domain(var=var, on=on, restriction=restriction, where=where, origin=d.span), inner


def _cell_around(on: ast.On, scope: Scope) -> ir.Member | None:
    """Returns the cell around that `on NAME` means; it has a name already. None if `on` binds the cell underneath."""
    cell = bound_cell(on.kind, scope)
    if cell is not None and on.bind is not None:
        name = on.kind.text
        help_ = f"`on {name}` means that cell; to bind the cell under the agent, rename the outer one: `{name} as one`"
        raise scope.fail(
            errors.NameTaken(
                on.span, name=name, taken_by="a cell around this statement", help=help_
            )
        )
    return cell


def with_member(
    name: ast.Name | None, kind: ast.Name, var: ir.Member | None, scope: Scope
) -> Scope:
    """Returns a scope with the variable of a domain, which has the name of its kind if the text gives it none."""
    return scope.bind(kind.text, var) if name is None else scope.bind_named(name, var)


def _own_name(name: ast.Name, scope: Scope) -> str:
    """Returns what a variable is called in the IR: in a define, never like one of those who use it, which the define does not see."""
    if not scope.defining:
        return name.text
    around = [v for v in scope.variables.values() if isinstance(v, ir.Node)]
    unseen = {
        v.name for e in (*around, *(f.condition for f in scope.facts)) for v in free_variables(e)
    }
    found = name.text
    while found in unseen:
        found += "_"
    return found


def only_one_who(scope: Scope, who: ir.Expr, instead: str) -> Scope:
    """Returns a scope for what is asked when an agent comes back: of the variables around it sees this agent alone, which has no place.

    What is known now may not hold any more then.
    """
    seen = who.name if isinstance(who, ir.Member) else ""
    kept = {
        n: v
        for n, v in scope.variables.items()
        if n == seen or not isinstance(v, ir.Member | ir.Local)
    }
    facts = tuple(f for f in scope.facts if not free_variables(f.condition))
    return replace(
        scope,
        variables=kept,
        facts=facts,
        withheld={n: instead for n in scope.variables if n not in kept},
        returning=seen,
    )


def _restriction(
    restriction: ast.Near | ast.Path | ast.Members, var: ir.Member, scope: Scope
) -> ir.Restriction:
    match restriction:
        case ast.Near():
            return near(restriction.shape, restriction.anchor, scope)
        case ast.Members():
            members = tuple(_variable(name, scope) for name in restriction.names)
            if any(
                m.sort != var.sort and {m.sort.what, var.sort.what} != {"cell"} for m in members
            ):
                raise scope.expected(restriction.span, "variables of the same sort", "a mixture")
            return ir.Among(members=members, origin=restriction.span)
        case ast.Path():
            value = scope.expression(restriction)
            if var.sort.what == "cell" and value.type.kind == "cell" and not value.type.by:
                if not set(var.kinds) & set(value.type.kinds):
                    raise scope.fail(errors.NeverOneCell(restriction.span))
                return ir.InCell(value=value, origin=restriction.span)
            if var.sort.what != "agent" or (value.type.kind != "agents" and not as_agent(value)):
                raise wrong_type(
                    scope,
                    restriction,
                    "a shape of something, or a field that holds agents or a cell",
                    value.type,
                )
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
    if name.text in scope.variables:
        scope.refer(name)
        bound = scope.variables[name.text]
        if bound is None:
            raise Poisoned
        if isinstance(bound, ir.Member):
            return bound.model_copy(update={"origin": name.span})
        raise scope.misused(name, "a value", "an agent or a cell")
    raise unknown(name, scope)


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
    return at_most(d, everywhere, lambda near: static.shapes[near.shape].lanes)


def can_be_empty(d: ir.Domain, scope: Scope) -> bool:
    """Returns whether neither the map, the rules nor a guard such as `count(D) > 0` gives a domain a member."""
    static, known = scope.static, scope.facts_and_requires
    members = ir.Count(type=integer(0, most_members(d, scope)), domain=d)
    if narrowed(members, known)[0] > 0 or compares(members, "!=", 0, known):
        return False
    if d.where is not None or d.on is not None:
        return True
    match d.restriction:
        case None if d.var.sort.what == "cell":
            return not any(static.cells.get(kind, 0) for kind in d.var.kinds)
        case None:
            # a domain around has an agent (or such a mover); other parts of a game may speak of one that is away
            somebody = any(
                isinstance(v, ir.Member) and v.sort == d.var.sort for v in scope.variables.values()
            )
            here = somebody and scope.part in ("phase", "start", "metrics", "checks", "policy")
            return static.can_be_away and not here
        case ir.Among():
            return d.var.sort.what == "cell"
        case _:
            return True
