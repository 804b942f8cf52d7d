"""Elaborates `size` and `param`: units, values, tables and limits."""

from itertools import product
from math import isfinite
from typing import Any

from sjdsl.compiler import ast, ir
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.diagnostics.diagnostic import Label, near
from sjdsl.compiler.elaborate.keys import entries_of, level_of
from sjdsl.compiler.elaborate.lookup import table_words
from sjdsl.compiler.elaborate.scope import Scope
from sjdsl.compiler.ir.sorts import Level
from sjdsl.compiler.ir.types import INTEGER_UNITS, UNIT_LIMITS, describe

UNITS = (*UNIT_LIMITS, "word")
Tree = ast.Expr | ast.Table


def constant(declared: ast.Constant, scope: Scope, override: object = None) -> None:
    """Adds one `size` or `param` to the static tables; a size may take another value than the written one."""
    unit, name, static = declared.unit.text, declared.name.text, scope.static
    if unit not in UNITS:
        raise scope.problems.unknown(declared.unit, UNITS, "the units")
    if unit == "word":
        type_, word = _word(declared, scope)
        static.params[name] = ir.Param(name=name, type=type_, value=word, origin=declared.span)
        return
    if declared.is_size and (declared.by is not None or isinstance(declared.value, ast.Table)):
        raise scope.fail(
            errors.Unsupported(
                declared.span, feature="a size that is a table", help="a `param` can be one"
            )
        )
    low, high = _limits(declared, scope)
    level = None if declared.by is None else level_of(declared.by, scope)
    by, value = _value(declared.value, unit, scope, level)
    if override is not None and declared.is_size:
        value = _overridden(declared, override, scope)
    outside = [
        (keys, n)
        for keys, n in zip(product(*(each.names for each in by)), _flat(value), strict=True)
        if not low <= n <= high
    ]
    if outside:
        _report_outside(declared, outside, (low, high), level, scope)
        if not isinstance(value, tuple):
            value = type(value)(
                min(max(value, low), high)
            )  # reported once: the rest is read with a number that is allowed
    kind = "int" if unit in INTEGER_UNITS else "real"
    type_ = ir.Type(kind=kind, unit=unit, low=low, high=high, by=by)  # type: ignore[arg-type]
    if declared.is_size:
        type_ = type_.model_copy(update={"low": value, "high": value})
        static.sizes[name] = ir.Size(name=name, type=type_, value=value, origin=declared.span)
    else:
        static.params[name] = ir.Param(name=name, type=type_, value=value, origin=declared.span)


def _report_outside(
    declared: ast.Constant,
    outside: list[tuple[tuple[str, ...], float]],
    between: tuple[float, float],
    level: Level | None,
    scope: Scope,
) -> None:
    """Reports the numbers of one declaration that are outside its limits, as one mistake.

    The comment beside a number may say why its limits are as they are, after its source: `# paper: why`.
    """
    first, *others = dict.fromkeys(
        _entry(declared.value, keys, level, scope).span for keys, _ in outside
    )
    labels = [Label(span, "and this") for span in others]
    reason = ""
    if declared.low is not None:
        if (declared.low.span.file, declared.low.span.line) != (
            first.file,
            first.line,
        ):  # the number is a variant's, or an entry's
            labels.insert(0, Label(declared.low.span, "its limits are here"))
        _, _, comment = (
            scope.static.sources[declared.span.file]
            .text[declared.span.end :]
            .partition("\n")[0]
            .partition("#")
        )
        _, _, why = comment.partition(": ")
        reason = f" ({why.strip()})" if why else ""
    name, value, (low, high) = f"`{declared.name.text}`", outside[0][1], between
    scope.problems.add(
        errors.OutOfLimits(
            first, labels=tuple(labels), name=name, value=value, low=low, high=high, reason=reason
        )
    )


def _overridden(declared: ast.Constant, override: object, scope: Scope) -> int | float:
    """Returns the value that a caller gives a size."""
    whole = declared.unit.text in INTEGER_UNITS
    number = (
        override.item()
        if hasattr(override, "item") and getattr(override, "shape", None) == ()
        else override
    )
    if not isinstance(number, bool) and isinstance(number, int | float):
        if isinstance(number, int) and abs(number) > limits.MAX_VALUE:
            raise scope.fail(
                limits.too_much(
                    f"`{declared.name.text}` is {number}", limits.MAX_VALUE, declared.span
                )
            )
        if isfinite(number) and (not whole or number == int(number)):
            return int(number) if whole else float(number)
    wanted = "a whole number" if whole else "a number"
    raise scope.fail(
        errors.WrongType(
            declared.span, wanted=f"{wanted} for `{declared.name.text}`", actual=repr(override)
        )
    )


def _limits(declared: ast.Constant, scope: Scope) -> tuple[float, float]:
    unit = declared.unit.text
    low, high = UNIT_LIMITS[unit]
    if declared.low is None or declared.high is None:
        return low, high
    own_low, own_high = (
        scope.fixed(e, "the limits of a number") for e in (declared.low, declared.high)
    )
    if own_low > own_high or own_low < low or own_high > high:
        name, given = f"the limits of `{declared.name.text}`", f"{own_low:g} .. {own_high:g}"
        raise scope.fail(
            errors.OutOfLimits(declared.low.span, name=name, value=given, low=low, high=high)
        )
    for tree, value in ((declared.low, own_low), (declared.high, own_high)):
        if unit in INTEGER_UNITS and value != int(value):
            raise scope.fail(
                errors.WrongType(tree.span, wanted="a whole number", actual=f"{value:g}")
            )
    return own_low, own_high


def _value(
    tree: Tree, unit: str, scope: Scope, level: Level | None = None
) -> tuple[tuple[Level, ...], int | float | tuple[Any, ...]]:
    """Returns the levels and the value (nested as the levels) of a number or table. `level`: the first one, where it is declared."""
    if level is not None:
        trees = entries_of(tree, level, scope)
        made = {
            id(entry): _value(entry, unit, scope)
            for entry in {id(entry): entry for entry in trees}.values()
        }
        if len({by for by, _ in made.values()}) > 1:
            raise scope.fail(errors.UnequalRows(tree.span))
        return (level, *made[id(trees[0])][0]), tuple(made[id(entry)][1] for entry in trees)
    if not isinstance(tree, ast.Table):
        return (), _number(tree, unit, scope)
    names = table_words(tree, scope)
    words = _declared_words(tree, names, scope)
    inner = [_value(e.value, unit, scope) for e in tree.entries]
    if any(i[0] != inner[0][0] for i in inner):
        raise scope.fail(errors.UnequalRows(tree.span))
    return (Level("word", words), *inner[0][0]), tuple(inner[names.index(w)][1] for w in words)


def _declared_words(table: ast.Table, names: tuple[str, ...], scope: Scope) -> tuple[str, ...]:
    """Returns the declared set of words a table is over; every word of it exactly once."""
    sets = scope.static.word_sets
    exact = next((s for s in sets if set(s) == set(names)), None)
    if exact is not None:
        return exact
    closest = max(
        sets, key=lambda s: (len(set(s) & set(names)), -len(set(s) ^ set(names))), default=()
    )
    unknown = next((e.key for e in table.entries if not scope.static.is_word(e.key.text)), None)
    if unknown is not None and set(names) & set(closest):
        raise scope.fail(
            errors.WordOutside(unknown.span, word=unknown.text, owner="this table", words=closest)
        )
    if unknown is not None:
        meant = near(unknown.text, [w for s in sets for w in s])
        declare = (
            f"declare one, `field NAME : {{ {', '.join(dict.fromkeys(names))} }} = {names[0]}`"
        )
        help_ = (
            ""
            if meant.nearest
            else f"the words of a table are those of a field, a row (`by`) or an event: {declare}"
        )
        raise scope.fail(
            errors.UnknownName(unknown.span, name=unknown.text, near=meant, help=help_)
        )
    if (
        set(names) < set(closest)
        and len(closest) - len(names) == 1
        and closest[0] not in names
        and len(names) > 1
    ):
        return tuple(w for w in closest if w in names)
    missing = tuple(w for w in closest if w not in names)
    raise scope.fail(
        errors.TableLacks(table.span, words=missing) if missing else errors.TableGap(table.span)
    )


def _number(tree: ast.Expr, unit: str, scope: Scope) -> int | float:
    built = scope.expression(tree)
    if not isinstance(built, ir.Number):
        scope.fixed(tree, "the value of a number")
        raise scope.fail(
            errors.WrongType(tree.span, wanted="a number", actual=describe(built.type))
        )
    value = built.value
    whole = unit in INTEGER_UNITS
    if not isfinite(value) or (whole and value != int(value)):
        raise scope.fail(
            errors.WrongType(
                tree.span, wanted="a whole number" if whole else "a number", actual=f"{value:g}"
            )
        )
    if abs(value) > limits.MAX_VALUE:
        raise scope.fail(
            limits.too_much(f"this number is {value:.15g}", limits.MAX_VALUE, tree.span)
        )
    if built.type.unit not in ("number", unit) and not (
        unit == "reward" and built.type.unit == "count"
    ):
        raise scope.fail(
            errors.UnitMismatch(
                tree.span, verb="give", left=describe(built.type), right=f"the unit `{unit}`"
            )
        )
    return int(value) if whole else float(value)


def _word(declared: ast.Constant, scope: Scope) -> tuple[ir.Type, str | tuple[str, ...]]:
    """Returns the type and value of a parameter of words: over the table's own words if they serve, else the first set that has them all."""
    if declared.is_size:
        raise scope.fail(
            errors.WrongType(declared.span, wanted="a number for a `size`", actual="a word")
        )
    by: tuple[Level, ...] = ()
    entries: list[Tree] = [declared.value]
    if declared.by is not None:
        by = (level_of(declared.by, scope),)
        entries = entries_of(declared.value, by[0], scope)
    elif isinstance(declared.value, ast.Table):
        by = (
            Level(
                "word", _declared_words(declared.value, table_words(declared.value, scope), scope)
            ),
        )
        written = {e.key.text: e.value for e in declared.value.entries}
        entries = [written[w] for w in by[0].names]
    known: dict[int, str] = {}
    for entry in {id(e): e for e in entries}.values():
        built = None if isinstance(entry, ast.Table) else scope.expression(entry)
        if not isinstance(built, ir.Word):
            given = "a table" if built is None else describe(built.type)
            raise scope.fail(errors.WrongType(entry.span, wanted="a word", actual=given))
        known[id(entry)] = built.value
    values = tuple(known[id(e)] for e in entries)
    sets = [*(level.names for level in by if level.sort == "word"), *scope.static.word_sets]
    words = next((s for s in sets if set(values) <= set(s)), None)
    if words is None:
        raise scope.fail(errors.NeverEqual(declared.value.span))
    return ir.Type(kind="word", words=words, by=by), values if by else values[0]


def _entry(value: Tree, keys: tuple[str, ...], level: Level | None, scope: Scope) -> Tree:
    """Returns the entry of a table that was read without mistakes, or the number itself. `level`: the first one, where it is declared."""
    if level is not None:
        value, keys = entries_of(value, level, scope)[level.names.index(keys[0])], keys[1:]
    for key in keys:
        assert isinstance(value, ast.Table)
        value = next(e.value for e in value.entries if e.key.text == key)
    return value


def _flat(value: object) -> list[float]:
    if isinstance(value, tuple):
        return [x for v in value for x in _flat(v)]
    assert isinstance(value, int | float)
    return [value]
