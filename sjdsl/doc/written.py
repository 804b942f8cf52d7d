"""What the text of a game has beside its rules: sources of numbers, formulas, variants."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import PurePath

from sjdsl.compiler import ast, build_composition, ir
from sjdsl.compiler.compose import Composition, compose
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.compiler.elaborate.streams import layout_free

_COMMENT = re.compile(r'^(?:[^"#]|"[^"]*")*#\s*(.*?)\s*$')


@dataclass(frozen=True)
class WrittenNumber:
    """A size or param as its file has it.

    formulas: the values that are computed: (keys of the entry, text of the expression).
    low, high: limits as written, "" without; source: the comments beside the value.
    """

    formulas: tuple[tuple[tuple[str, ...], str], ...]
    low: str
    high: str
    source: str


@dataclass(frozen=True)
class Written:
    """The rules of a game with some variants, and what its text has beside them.

    chosen: the variants applied; variants: name and title of all.
    """

    composition: Composition
    game: ir.Game
    file: str
    chosen: tuple[str, ...]
    variants: tuple[tuple[str, str], ...]
    numbers: dict[str, WrittenNumber]


def read_written(source: Source, variants: Sequence[str] = ()) -> Written:
    """Returns a game with what its text has beside the rules. Raises CompileError."""
    c = compose(source, variants)
    return Written(
        composition=c,
        game=build_composition(c).game,
        file=PurePath(source.name).name,
        chosen=tuple(variants),
        variants=tuple(_name_and_title(variant) for variant in c.variants.values()),
        numbers={name: _number(constant, c) for name, constant in c.constants.items()},
    )


def _name_and_title(variant: ast.Variant) -> tuple[str, str]:
    return variant.name.text, variant.title.text if variant.title else ""


def _number(constant: ast.Constant, c: Composition) -> WrittenNumber:
    """Returns how a size or param is written: formulas, limits, and the comments beside it."""
    formulas = []
    spans: dict[Span, None] = {}  # a variant may change an entry elsewhere
    for keys, value in _leaves(constant.value):
        if not _is_literal(value, constant):
            formulas.append((keys, _text(value, c)))
        is_inside = _is_inside(value.span, constant.span)
        spans[constant.span if is_inside else value.span] = None
    ordered = sorted(spans, key=lambda span: span != constant.span)
    sources = dict.fromkeys(comments(span, c.sources) for span in ordered)
    return WrittenNumber(
        tuple(formulas),
        "" if constant.low is None else _text(constant.low, c),
        "" if constant.high is None else _text(constant.high, c),
        "; ".join(filter(None, sources)),
    )


def _leaves(
    value: ast.Expr | ast.Table, keys: tuple[str, ...] = ()
) -> Iterator[tuple[tuple[str, ...], ast.Expr]]:
    """Yields the expression of each entry of a constant, with its keys."""
    if isinstance(value, ast.Table):
        for entry in value.entries:
            yield from _leaves(entry.value, (*keys, entry.key.text))
    else:
        yield keys, value


def _is_literal(value: ast.Expr, constant: ast.Constant) -> bool:
    """Returns whether a value is a number or an enum value, not an expression to compute."""
    if isinstance(value, ast.Unary):
        return _is_literal(value.operand, constant)
    if isinstance(value, ast.Path):
        return constant.unit.text == "word"
    return isinstance(value, ast.Int | ast.Decimal)


def _is_inside(inner: Span, outer: Span) -> bool:
    return inner.file == outer.file and outer.start <= inner.start < outer.end


def _text(value: ast.Expr, c: Composition) -> str:
    """Returns an expression as written; without its layout if it has several lines."""
    source = c.sources[value.span.file]
    text = source.text[value.span.start : value.span.end]
    return layout_free(source, value.span.start, value.span.end) if "\n" in text else text


def comments(span: Span, sources: dict[str, Source]) -> str:
    """Returns the comments at the ends of the lines of a declaration."""
    source = sources[span.file]
    last = span.line + source.text.count("\n", span.start, span.end)
    matches = (_COMMENT.match(source.line(number)) for number in range(span.line, last + 1))
    return "; ".join(match[1] for match in matches if match and match[1])
