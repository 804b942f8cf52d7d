"""Elaborates fields and timers: type, range and starting value."""

from math import inf

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol, field_symbol
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.diagnostics.tree import walk
from sjdsl.compiler.elaborate.keys import index_set_of
from sjdsl.compiler.elaborate.lookup import (
    AGENT_ATTRIBUTES,
    CELL_ATTRIBUTES,
    check_known_word,
    check_words,
    interval_text,
)
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.ir.range_arithmetic import nearest
from sjdsl.compiler.ir.types import UNIT_LIMITS, describe, has_limits, join_units, words

FIELD_TYPES = (
    "{ a, b }",
    "0 .. 9",
    "agent",
    "set of agent",
    "cell of KIND",
    "reward",
    "probability",
    "fraction",
    "number in 0 .. 1",
)
REAL_UNITS: tuple[ir.Unit, ...] = ("number", "reward", "probability", "fraction")

ATTRIBUTES = {  # names that fields of each owner can't have
    "agent": AGENT_ATTRIBUTES,
    "mover": AGENT_ATTRIBUTES,
    "cell": CELL_ATTRIBUTES,
    "world": (),
}


ROLES = {
    "agent": "a field of the agents",
    "mover": "a field of movers",
    "cell": "a field of a kind",
}


REAL_FIELD = "a field of real numbers is `field {name} : number in 0 .. 1 = 0.5`"


def fields_of(
    attributes: tuple[object, ...], scope: Scope, held_by: ir.EntityType
) -> dict[str, ir.VarField]:
    """Returns the fields and timers of a kind of cell, or of movers, by name."""
    fields: dict[str, ir.VarField] = {}
    for attribute in attributes:
        if not isinstance(attribute, ast.Field | ast.Timer):
            continue
        name = attribute.name.text
        if name in fields:
            scope.problems.add(errors.WrittenTwice(attribute.name.span, part=f"the field `{name}`"))
            continue
        with scope.problems.skip_if_broken(
            scope.static.broken, Symbol("field", name, held_by.name)
        ):
            fields[name] = one_field(attribute, scope, held_by)
    return fields


def one_field(declared: ast.Field | ast.Timer, scope: Scope, held_by: ir.EntityType) -> ir.VarField:
    """Returns one field with its type and starting value."""
    name = declared.name.text
    span = declared.span
    if name in ATTRIBUTES[held_by.what]:
        role = ROLES[held_by.what]
        problem = f"every {held_by.what} has it already"
        scope.problems.add(
            errors.BadName(declared.name.span, name=name, role=role, problem=problem)
        )
    if isinstance(declared, ast.Timer):
        by = () if declared.by is None else (index_set_of(declared.by, scope),)
        type_ = ir.Type(kind="int", unit="steps", low=0, high=inf, indexed_by=by)
        return ir.VarField(name=name, held_by=held_by, type=type_, timer=True, start=0, origin=span)
    type_ = field_type(declared.type, scope)
    start = start_value(declared, type_, scope)
    if declared.by is not None:
        type_ = type_.changed(indexed_by=(index_set_of(declared.by, scope),))
    capped = False
    if isinstance(declared.type, ast.Range | ast.Reals):
        capped = declared.type.capped
        if any(isinstance(node, ast.Path) for node in walk(declared.type)):
            scope.static.sized.add(field_symbol(name, held_by.name))
    return ir.VarField(
        name=name, held_by=held_by, type=type_, capped=capped, start=start, origin=span
    )


def field_type(declared: ast.Type, scope: Scope) -> ir.Type:
    """Returns the type of a field, without what it is indexed by."""
    static = scope.static
    match declared:
        case ast.Words():
            return words(tuple(dict.fromkeys(n.text for n in declared.names)))
        case ast.Range():
            return _range_type(declared, scope)
        case ast.Reals():
            return _type_of_reals(declared, scope)
        case ast.CellType():
            if declared.sort.text != "cell":
                raise scope.problems.unknown(declared.sort, ("cell", "set"), "what is of something")
            if declared.of.text not in static.cell_types:
                raise scope.problems.unknown(declared.of, static.cell_types, "the kinds and groups")
            static.refer(declared.of, Symbol("name", declared.of.text))
            return ir.Type(kind="cell", kinds=static.cell_types[declared.of.text])
        case ast.NamedType(name=ast.Name(text="agent")):
            return ir.AGENTS if declared.set_of else ir.AGENT
        case ast.NamedType(name=ast.Name(text="reward"), set_of=False):
            return ir.Type(kind="real", unit="reward")
        case ast.NamedType(name=ast.Name(text="probability" | "fraction" as unit), set_of=False):
            low, high = UNIT_LIMITS[unit]
            return ir.Type(kind="real", unit=unit, low=low, high=high)
        case ast.NamedType(name=ast.Name(text="number"), set_of=False):
            help_ = "write `number in 0 .. 10`; a field of reals without limits is a `reward`"
            raise scope.expected(declared.span, "a number with limits", "one without", help_)
        case ast.NamedType(name=ast.Name(text=entity_type)) if entity_type in static.mover_types:
            help_ = f"let the mover hold the agent: write `field holder : agent` in `movers {entity_type}`"
            raise scope.fail(
                errors.Unsupported(declared.span, feature="a field that holds a mover", help=help_)
            )
        case ast.NamedType():
            raise scope.problems.unknown(declared.name, FIELD_TYPES, "the types of fields")


def _ends(declared: ast.Range | ast.Reals, scope: Scope) -> tuple[float, float]:
    """Returns the ends of the range of a field."""
    low = scope.fixed(declared.low, "the range of a field")
    high = scope.fixed(declared.high, "the range of a field")
    if max(abs(low), abs(high)) > limits.MAX_VALUE:
        problem = f"an end of this range is {max(low, high, key=abs):.15g}"
        raise scope.fail(limits.too_much(problem, limits.MAX_VALUE, declared.span))
    return low, high


def _type_of_reals(declared: ast.Reals, scope: Scope) -> ir.Type:
    """Returns the type of real numbers of a range, whose ends are rounded to float32."""
    unit = next((unit for unit in REAL_UNITS if unit == declared.unit.text), None)
    if unit is None:
        raise scope.problems.unknown(declared.unit, REAL_UNITS, "the units of real numbers")
    low, high = map(nearest, _ends(declared, scope))
    if low > high:
        raise scope.expected(declared.span, "a range, the smaller number first", "another one")
    least, most = UNIT_LIMITS[unit]
    for end in (low, high):
        if not least <= end <= most:
            name = f"an end of the range of a {unit}"
            raise scope.fail(
                errors.OutOfLimits(declared.span, name=name, value=end, low=least, high=most)
            )
    return ir.Type(kind="real", unit=unit, low=low, high=high)


def _range_type(declared: ast.Range, scope: Scope) -> ir.Type:
    """Returns the type of a field with a range of whole numbers."""
    low_unit = scope.expression(declared.low).type.unit
    high_unit = scope.expression(declared.high).type.unit
    low, high = _ends(declared, scope)
    wanted = "a range of whole numbers, the smaller first"
    if low > high:
        raise scope.expected(declared.span, wanted, "another one")
    if low != int(low) or high != int(high):
        help_ = REAL_FIELD.format(name="NAME")
        raise scope.expected(declared.span, wanted, "another one", help_)
    unit = join_units(low_unit, high_unit)
    if unit is None or unit == "number":
        unit = "count"
    return ir.Type(kind="int", unit=unit, low=low, high=high)


def start_value(declared: ast.Field, type_: ir.Type, scope: Scope) -> int | float | str | None:
    """Returns the starting value: as written, else 0 for rewards, None for nobody and nowhere."""
    if declared.start is not None:
        return starting(declared.start, declared.name.text, type_, scope)
    if type_.kind in ("agent", "agents", "cell"):
        return None
    if type_.unit == "reward" and not has_limits(type_):
        return 0.0
    part = f"starting value for `{declared.name.text}`"
    raise scope.fail(
        errors.MissingPart(declared.span, part=part, example="`= value` after its type")
    )


def starting(tree: ast.Expr, name: str, type_: ir.Type, scope: Scope) -> int | float | str | None:
    """Returns a starting value of a field; reports one that is not of its type."""
    if type_.kind == "word":
        check_known_word(tree, name, type_.words, scope)
    value = scope.expression(tree)
    match value:
        case ir.Nobody() if type_.kind in ("agent", "agents"):
            return None
        case ir.Nowhere() if type_.kind == "cell":
            return None
        case ir.Word() if type_.kind == "word":
            check_words((value.value,), type_.words, tree.span, name, scope)
            return value.value
        case ir.Number() if type_.kind in ("int", "real"):
            return _starting_number(value, tree, name, type_, scope)
    help_ = ""
    if type_.kind in ("agent", "agents", "cell"):
        nobody = "nowhere" if type_.kind == "cell" else "nobody"
        help_ = f"leave the starting value out: the field begins as `{nobody}`"
    raise wrong_type(scope, tree, f"a starting value ({describe(type_)})", value.type, help_)


def _starting_number(
    number: ir.Number, tree: ast.Expr, name: str, type_: ir.Type, scope: Scope
) -> int | float:
    """Returns a starting value in the range of a field; reports any other."""
    is_whole = type_.kind == "int"
    if is_whole and number.value != int(number.value):
        help_ = REAL_FIELD.format(name=name)
        raise scope.expected(tree.span, "a whole number", f"{number.value:g}", help_)
    kept = number.value if is_whole else nearest(number.value)
    if not type_.low <= kept <= type_.high:
        raise scope.fail(
            errors.FieldRange(
                tree.span,
                name=name,
                declared=name,
                low=type_.low,
                high=type_.high,
                reached=interval_text(number.type.low, number.type.high),
                help="begin with a number of the range, or widen the range",
            )
        )
    return int(number.value) if is_whole else float(number.value)
