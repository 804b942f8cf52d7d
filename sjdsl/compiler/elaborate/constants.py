"""Elaborates `size` and `param`: units, values, tables and limits."""

from dataclasses import dataclass, field
from math import isfinite
from typing import Any, Literal

from sjdsl.compiler import ast, ir
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.diagnostics.diagnostic import Label
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate.keys import entries_of, index_set_of
from sjdsl.compiler.elaborate.lookup import no_word, not_among, table_words
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.ir.entity_types import IndexSet
from sjdsl.compiler.ir.types import INTEGER_UNITS, UNIT_LIMITS, describe

UNITS = (*UNIT_LIMITS, "word")
Tree = ast.Expr | ast.Table


def constant(declared: ast.Constant, scope: Scope, override: object = None) -> None:
    """Adds one `size` or `param` to the static tables.

    override: the value that a caller gives a size in place of the written one.
    """
    unit = declared.unit.text
    name = declared.name.text
    static = scope.static
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
    numbers = _Numbers(unit, scope)
    by, value = numbers.read(declared.value, declared.by)
    if override is not None and declared.is_size:
        value = _overridden(declared, override, scope)
        numbers.written = [(declared.value.span, value)]
    outside = {span: number for span, number in numbers.written if not low <= number <= high}
    if outside:
        _report_outside(declared, outside, (low, high), scope)
        if not isinstance(value, tuple):  # the rest of the game is read with an allowed number
            value = type(value)(min(max(value, low), high))
    kind: Literal["int", "real"] = "int" if unit in INTEGER_UNITS else "real"
    type_ = ir.Type(kind=kind, unit=unit, low=low, high=high, indexed_by=by)  # type: ignore[arg-type]
    if declared.is_size:
        type_ = type_.changed(low=value, high=value)
        static.sizes[name] = ir.Size(name=name, type=type_, value=value, origin=declared.span)
    else:
        static.params[name] = ir.Param(name=name, type=type_, value=value, origin=declared.span)


def _report_outside(
    declared: ast.Constant,
    outside: dict[Span, float],
    interval: tuple[float, float],
    scope: Scope,
) -> None:
    """Reports the numbers of one declaration that are outside its limits, as one mistake.

    outside: these numbers, by where they are written.
    """
    first, *others = outside
    labels = [Label(span, "and this") for span in others]
    reason = ""
    if declared.low is not None:
        limits_span = declared.low.span
        if (limits_span.file, limits_span.line) != (first.file, first.line):
            labels.insert(0, Label(limits_span, "its limits are here"))
        reason = _reason_of_limits(declared, scope)
    low, high = interval
    scope.problems.add(
        errors.OutOfLimits(
            first,
            labels=tuple(labels),
            name=f"`{declared.name.text}`",
            value=outside[first],
            low=low,
            high=high,
            reason=reason,
        )
    )


def _reason_of_limits(declared: ast.Constant, scope: Scope) -> str:
    """Returns why a number has its limits, if the comment behind it says so: `# source: reason`."""
    text = scope.static.sources[declared.span.file].text
    line, _, _ = text[declared.span.end :].partition("\n")
    _, _, comment = line.partition("#")
    _, _, reason = comment.partition(": ")
    return f" ({reason.strip()})" if reason else ""


def _overridden(declared: ast.Constant, override: object, scope: Scope) -> int | float:
    """Returns the value that a caller gives a size."""
    number = override
    if hasattr(override, "item") and getattr(override, "shape", None) == ():
        number = override.item()
    is_whole = declared.unit.text in INTEGER_UNITS
    if isinstance(number, int | float) and not isinstance(number, bool):
        if isinstance(number, int) and abs(number) > limits.MAX_VALUE:
            problem = f"`{declared.name.text}` is {number}"
            raise scope.fail(limits.too_much(problem, limits.MAX_VALUE, declared.span))
        if isfinite(number) and not is_whole:
            return float(number)
        if isfinite(number) and number == int(number):
            return int(number)
    noun = "a whole number" if is_whole else "a number"
    wanted = f"{noun} for `{declared.name.text}`"
    raise scope.expected(declared.span, wanted, repr(override))


def _limits(declared: ast.Constant, scope: Scope) -> tuple[float, float]:
    """Returns the interval of a number: the one written after it, or that of its unit."""
    unit = declared.unit.text
    unit_low, unit_high = UNIT_LIMITS[unit]
    if declared.low is None or declared.high is None:
        return unit_low, unit_high
    low = scope.fixed(declared.low, "the limits of a number")
    high = scope.fixed(declared.high, "the limits of a number")
    if low > high or low < unit_low or high > unit_high:
        raise scope.fail(
            errors.OutOfLimits(
                declared.low.span,
                name=f"the limits of `{declared.name.text}`",
                value=f"{low:g} .. {high:g}",
                low=unit_low,
                high=unit_high,
            )
        )
    for tree, value in ((declared.low, low), (declared.high, high)):
        if unit in INTEGER_UNITS and value != int(value):
            raise scope.expected(tree.span, "a whole number", f"{value:g}")
    return low, high


@dataclass
class _Numbers:
    """Reads the numbers of a declaration: one, or a table.

    written: the numbers that were read, each with its place.
    """

    unit: str
    scope: Scope
    written: list[tuple[Span, float]] = field(default_factory=list)

    def read(
        self, tree: Tree, declared_by: ast.By | None = None
    ) -> tuple[tuple[IndexSet, ...], int | float | tuple[Any, ...]]:
        """Returns the index sets of a number or table, and its value, nested as they are."""
        if declared_by is not None:
            index_set = index_set_of(declared_by, self.scope)
            entries = entries_of(tree, index_set, self.scope)
        elif isinstance(tree, ast.Table):
            index_set, entries = _entries_by_words(tree, self.scope)
        else:
            number = _number(tree, self.unit, self.scope)
            self.written.append((tree.span, number))
            return (), number
        inner_sets, values = zip(*map(self.read, entries), strict=True)
        if len(set(inner_sets)) > 1:
            raise self.scope.fail(errors.UnequalRows(tree.span))
        return (index_set, *inner_sets[0]), values


def _entries_by_words(table: ast.Table, scope: Scope) -> tuple[IndexSet, list[Tree]]:
    """Returns the words that a table is by, and what is written for each of them."""
    names = table_words(table, scope)
    words = _declared_words(table, names, scope)
    written = {entry.key.text: entry.value for entry in table.entries}
    return IndexSet("word", words), [written[word] for word in words]


def _declared_words(table: ast.Table, names: tuple[str, ...], scope: Scope) -> tuple[str, ...]:
    """Returns the declared set of words that a table is over; reports a table over no set.

    A table may leave out the first word of a set, if it has two others: nothing is kept for it.
    """
    sets = scope.static.word_sets
    for words in sets:
        if set(words) == set(names):
            return words

    def similarity(words: tuple[str, ...]) -> tuple[int, int]:
        return len(set(words) & set(names)), -len(set(words) ^ set(names))

    closest = max(sets, key=similarity, default=())
    for entry in table.entries:
        if not scope.static.is_word(entry.key.text):
            if set(names) & set(closest):
                raise not_among(entry.key, closest, "this table", scope)
            raise no_word(entry.key, names, "table", scope)
    missing = tuple(w for w in closest if w not in names)
    if set(names) < set(closest) and missing == closest[:1] and len(names) > 1:
        return closest[1:]
    if missing:
        raise scope.fail(errors.TableLacks(table.span, words=missing))
    raise scope.fail(errors.TableGap(table.span))


def _number(tree: ast.Expr, unit: str, scope: Scope) -> int | float:
    """Returns a number of a unit that is known when compiled."""
    built = scope.expression(tree)
    if not isinstance(built, ir.Number):
        scope.fixed(tree, "the value of a number")
        raise wrong_type(scope, tree, "a number", built.type)
    value = built.value
    is_whole = unit in INTEGER_UNITS
    if not isfinite(value) or (is_whole and value != int(value)):
        wanted = "a whole number" if is_whole else "a number"
        raise scope.expected(tree.span, wanted, f"{value:g}")
    if abs(value) > limits.MAX_VALUE:
        problem = f"this number is {value:.15g}"
        raise scope.fail(limits.too_much(problem, limits.MAX_VALUE, tree.span))
    is_count_of_reward = unit == "reward" and built.type.unit == "count"
    if built.type.unit not in ("number", unit) and not is_count_of_reward:
        left = describe(built.type)
        right = f"the unit `{unit}`"
        raise scope.fail(errors.UnitMismatch(tree.span, verb="give", left=left, right=right))
    return int(value) if is_whole else float(value)


def _word(declared: ast.Constant, scope: Scope) -> tuple[ir.Type, str | tuple[str, ...]]:
    """Returns the type and value of a parameter of words, or of a row of them.

    The type has the table's own words if these serve, else the first set with all the words.
    """
    if declared.is_size:
        raise scope.expected(declared.span, "a number for a `size`", "a word")
    by: tuple[IndexSet, ...] = ()
    entries: list[Tree] = [declared.value]
    if declared.by is not None:
        index_set = index_set_of(declared.by, scope)
        by = (index_set,)
        entries = entries_of(declared.value, index_set, scope)
    elif isinstance(declared.value, ast.Table):
        index_set, entries = _entries_by_words(declared.value, scope)
        by = (index_set,)
    values = tuple(_one_word(entry, scope) for entry in entries)
    sets = [
        index_set.names for index_set in by if index_set.kind == "word"
    ] + scope.static.word_sets
    words = next((words for words in sets if set(values) <= set(words)), None)
    if words is None:
        raise scope.fail(errors.NeverEqual(declared.value.span))
    type_ = ir.Type(kind="word", words=words, indexed_by=by)
    return type_, values if by else values[0]


def _one_word(tree: Tree, scope: Scope) -> str:
    """Returns the word that a value is."""
    if isinstance(tree, ast.Table):
        raise scope.expected(tree.span, "a word", "a table")
    built = scope.expression(tree)
    if not isinstance(built, ir.Word):
        raise wrong_type(scope, tree, "a word", built.type)
    return built.value
