"""Resolves paths such as `agent.bag[raw]`: variables, their attributes, entries of tables."""

from dataclasses import replace
from math import inf

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.problems import Poisoned
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate.actions import argument_read
from sjdsl.compiler.elaborate.keys import key_of
from sjdsl.compiler.elaborate.lookup import (
    AGENT_ATTRIBUTES,
    CELL_ATTRIBUTES,
    MOVER_ATTRIBUTES,
    NOWHERE,
    check_placed,
    check_somebody,
    check_somewhere,
    is_agent,
    is_member,
    kinds_of_cell,
    no_field,
    unknown,
    use_define,
    variable,
)
from sjdsl.compiler.elaborate.scope import Scope, Static, wrong_type
from sjdsl.compiler.ir.entity_types import AGENTS
from sjdsl.compiler.ir.operations import Function
from sjdsl.compiler.ir.printer import expression_text as text
from sjdsl.compiler.ir.types import describe, element, integer, words
from sjdsl.runtime.actions import HEADINGS


def path(e: ast.Path, scope: Scope) -> ir.Expr:
    """Returns what a path stands for."""
    value = head(e, scope)
    steps = e.steps
    while steps:
        step = steps[0]
        used = 1
        if isinstance(step, ast.Index):
            value = index(value, step, scope)
        elif is_agent(value) and step.name.text in scope.static.with_arguments:
            value, used = argument_read(value, steps, scope)
        else:
            value = member(value, step.name, scope)
        read_so_far = replace(e.span, end=steps[used - 1].span.end)
        value = value.changed(origin=read_so_far)
        steps = steps[used:]
    return value


def head(e: ast.Path, scope: Scope) -> ir.Expr:
    """Returns what the first name of a path stands for; variables hide everything else."""
    name = e.name.text
    static = scope.static
    if name in scope.variables:
        value = variable(e.name, scope)
        if isinstance(value, str):
            raise scope.misused(e.name, f"the action `{value}`", "a value")
        return value
    if name == "step":
        return ir.Step(type=integer(0, inf, "steps"), origin=e.span)
    if name in static.sizes:
        static.use(e.name, Symbol("name", name))
        size = static.sizes[name]
        return ir.Number(type=size.type, value=size.value, origin=e.span)  # type: ignore[arg-type]
    if name in static.params:
        static.use(e.name, Symbol("name", name))
        return ir.ParamRef(type=static.params[name].type, name=name, origin=e.span)
    if name in static.defines:
        return use_define(e.name, (), scope)
    if name in static.fields:
        static.use(e.name, Symbol("name", name))
        type_ = static.fields[name].type
        world = ir.EntityType("world")
        return ir.FieldRead(type=type_, owner=None, held_by=world, name=name, origin=e.span)
    if scope.events_readable and name in static.events:
        static.refer(e.name, Symbol("metric", name))
        type_ = integer(0, inf, "count")
        if name in static.event_index_sets and e.steps:
            type_ = type_.changed(indexed_by=(static.event_index_sets[name],))
        return ir.EventTotal(type=type_, name=name, origin=e.span)
    if static.is_word(name):
        static.refer(e.name, Symbol("word", name))
        return ir.Word(type=words((name,)), value=name, origin=e.span)
    if name == NOWHERE:
        return ir.Nowhere(origin=e.span)
    raise unknown(e.name, scope)


def member(owner: ir.Expr, name: ast.Name, scope: Scope) -> ir.Expr:
    """Returns `owner.name`: a field or a read-only attribute of an agent, a mover or a cell."""
    if kinds_of_cell(owner) is not None:
        return cell_member(owner, name, scope)
    static = scope.static
    types = attribute_types(static)
    known: tuple[str, ...]
    if is_member(owner, "mover"):  # its heading is a field
        held_by = owner.entity_type
        described = f"a mover `{held_by.name}`"
        known = MOVER_ATTRIBUTES
        types["index"] = integer(0, static.movers[held_by.name].number - 1, "number")
    elif is_agent(owner):
        check_somebody(owner, name.span, scope)
        held_by = AGENTS
        described = "an agent"
        known = AGENT_ATTRIBUTES
    else:
        wanted = "an agent or a cell before the point"
        raise scope.expected(name.span, wanted, describe(owner.type))
    fields = static.fields_of(held_by)
    if name.text in fields:
        static.use(name, Symbol("field", name.text, held_by.name))
        return ir.FieldRead(
            type=fields[name.text].type,
            owner=owner,
            held_by=held_by,
            name=name.text,
            origin=name.span,
        )
    if name.text in ("row", "col"):
        if not isinstance(owner, ir.Member):
            raise _perhaps_away(owner, name.span, "row or column", f"x.{name.text}", scope)
        check_placed(owner, name.span, f"{text(owner)}.{name.text}", scope)
    if name.text in types:
        return ir.Attribute(type=types[name.text], owner=owner, name=name.text, origin=name.span)  # type: ignore[arg-type]
    if Symbol("field", name.text, held_by.name) in static.broken:
        raise Poisoned
    raise no_field(name, described, [*fields, *known], scope.problems)


def attribute_types(static: Static) -> dict[str, ir.Type]:
    """Returns the type of each thing that every agent has of itself."""
    return {
        "index": integer(0, static.num_agents - 1, "number"),
        "heading": words(HEADINGS),
        "moved": ir.CONDITION,
        "away": ir.CONDITION,
        "row": integer(0, max(static.map_rows - 1, 0), "cells"),
        "col": integer(0, max(static.map_cols - 1, 0), "cells"),
    }


def _perhaps_away(
    agent: ir.Expr, span: Span, attribute: str, example: str, scope: Scope
) -> Poisoned:
    """Reports the row, column or distance of an agent that a field holds."""
    feature = f"the {attribute} of an agent that a field holds: it may be away"
    help_ = f"name it: `each agent as x in {text(agent)}` has those who are there, and `{example}`"
    return scope.fail(errors.Unsupported(span, feature=feature, help=help_))


def distance(_: Function, e: ast.Call, scope: Scope) -> ir.Expr:
    """Returns `distance(a, b)` between two agents or cells that domains around have named."""
    left, right = _both_placed(e, scope)
    rows = scope.static.map_rows
    cols = scope.static.map_cols
    farthest = max(rows + cols - 2, 0)
    if scope.static.wraps:
        farthest = rows // 2 + cols // 2
    return ir.Distance(type=integer(0, farthest, "cells"), left=left, right=right, origin=e.span)


def bearing(function: Function, e: ast.Call, scope: Scope) -> ir.Expr:
    """Returns `steps_ahead(a, b)` or `steps_right(a, b)`: where b is, as a looks."""
    left, right = _both_placed(e, scope)
    if not (is_member(left, "agent") or is_member(left, "mover")):
        wanted = "an agent or a mover, which has a heading"
        raise wrong_type(scope, e.arguments[0], wanted, left.type)
    farthest = max(scope.static.map_rows, scope.static.map_cols, 1) - 1
    type_ = integer(-farthest, farthest, "cells")
    if scope.static.wraps:
        type_ = integer(-(farthest // 2), (farthest + 1) // 2, "cells")
    return ir.Bearing(type=type_, fn=function.name, left=left, right=right, origin=e.span)  # type: ignore[arg-type]


def _both_placed(e: ast.Call, scope: Scope) -> list[ir.Expr]:
    """Returns the two arguments of a call, each an agent, a mover or a cell that has a place."""
    names = [tree.name.text if isinstance(tree, ast.Path) else "…" for tree in e.arguments]
    question = f"{e.name.text}({', '.join(names)})"
    values = scope.expressions(e.arguments)
    return [
        placed(tree, value, question, scope)
        for tree, value in zip(e.arguments, values, strict=True)
    ]


def placed(tree: ast.Expr, place: ir.Expr, question: str, scope: Scope) -> ir.Expr:
    """Returns an agent or a cell that has a place; reports anything else.

    question: the expression that needs the place.
    """
    if place.type.is_single("cell"):
        check_somewhere(place, tree.span, scope)
        return place
    if isinstance(place, ir.Nobody):
        raise scope.expected(tree.span, "an agent or a cell", "nobody")
    if not isinstance(place, ir.Member):
        if place.type.kind == "agent":
            raise _perhaps_away(place, tree.span, "distance", "distance(x, …)", scope)
        raise wrong_type(scope, tree, "an agent or a cell", place.type)
    if place.entity_type.what != "cell":
        check_placed(place, tree.span, question, scope)
    return place


def cell_member(owner: ir.Expr, name: ast.Name, scope: Scope) -> ir.Expr:
    """Returns an attribute or a field of a cell."""
    static = scope.static
    check_somewhere(owner, name.span, scope)
    kinds = kinds_of_cell(owner) or ()
    if name.text in CELL_ATTRIBUTES:
        type_ = attribute_types(static)[name.text]
        return ir.Attribute(type=type_, owner=owner, name=name.text, origin=name.span)  # type: ignore[arg-type]
    declared = []
    for kind in kinds:
        fields = static.kinds[kind]
        if Symbol("field", name.text, kind) in static.broken:
            raise Poisoned
        if name.text not in fields:
            described = f"the kind `{kind}`"
            if len(kinds) > 1:
                described = f"{described} of the group"
            raise no_field(name, described, [*fields, *CELL_ATTRIBUTES], scope.problems)
        declared.append(fields[name.text])
        static.use(name, Symbol("field", name.text, kind))
    first = declared[0]
    if any(f.type != first.type or f.timer != first.timer for f in declared):
        described = "the group: its kinds disagree on the type, so it"
        raise scope.fail(errors.NoField(name.span, owner=described, name=name.text))
    return ir.FieldRead(
        type=first.type,
        owner=owner,
        held_by=ir.EntityType("cell", kinds),
        name=name.text,
        origin=name.span,
    )


def index(row: ir.Expr, step: ast.Index, scope: Scope) -> ir.Expr:
    """Returns `row[key]`, or a mix over the entries of the row."""
    if not row.type.indexed_by:
        wanted = "a row or table before `[`"
        raise scope.expected(step.span, wanted, describe(row.type))
    index_set = row.type.indexed_by[0]
    key = key_of(step.key, row, index_set, scope)
    type_ = element(row.type)
    if isinstance(row, ir.EventTotal):
        if not isinstance(key, ir.Word | ir.Number):
            raise wrong_type(scope, step.key, "one entry", key.type)
        entry = index_set.keys[index_set.place_of(key.value)]  # type: ignore[arg-type]
        return row.changed(word=entry, type=type_)
    if key.type.kind == "mix":
        if row.type.kind not in ("int", "real") or not isinstance(row, ir.ParamRef | ir.At):
            wanted = "a word (only tables of numbers are mixed)"
            raise scope.expected(step.key.span, wanted, "a mix")
        keeps_unit = type_.unit in ("reward", "probability", "fraction")
        unit = type_.unit if keeps_unit else "number"
        type_ = type_.changed(kind="real", unit=unit)
    return ir.At(type=type_, row=row, key=key, origin=step.span)
