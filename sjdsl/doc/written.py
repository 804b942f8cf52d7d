"""Facts that the text of a game states beside its rules: sources of its numbers, computed constants, variants."""

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
    """A size or parameter as its file has it.

    formulas: how values are computed that are not plainly written: (words of the entry, text); low, high: limits as written,
    empty without; source: the comments beside the value.
    """

    formulas: tuple[tuple[tuple[str, ...], str], ...]
    low: str
    high: str
    source: str


@dataclass(frozen=True)
class Written:
    """The rules of a game in one variant, and what its text says beside them. `chosen`: the variants applied; `variants`: (name, title)."""

    composition: Composition
    game: ir.Game
    file: str
    chosen: tuple[str, ...]
    variants: tuple[tuple[str, str], ...]
    numbers: dict[str, WrittenNumber]


def read_written(source: Source, variants: Sequence[str] = ()) -> Written:
    """Returns a game with what its text says beside the rules. Raises CompileError."""
    composed = compose(source, variants)
    game = build_composition(composed).game
    return Written(
        composition=composed,
        game=game,
        file=PurePath(source.name).name,
        chosen=tuple(variants),
        variants=tuple(
            (v.name.text, v.title.text if v.title else "") for v in composed.variants.values()
        ),
        numbers={
            name: _number(constant, composed) for name, constant in composed.constants.items()
        },
    )


def _number(constant: ast.Constant, game: Composition) -> WrittenNumber:
    leaves = list(_leaves(constant.value))
    computed = [(path, leaf) for path, leaf in leaves if not _is_literal(leaf, constant)]
    low, high = (
        "" if bound is None else _text(bound, game) for bound in (constant.low, constant.high)
    )
    here = [leaf.span for _, leaf in leaves if _is_inside(leaf.span, constant.span)]
    elsewhere = [leaf.span for _, leaf in leaves if not _is_inside(leaf.span, constant.span)]
    found = [comments(span, game.sources) for span in ([constant.span] if here else []) + elsewhere]
    source = "; ".join(dict.fromkeys(text for text in found if text))
    return WrittenNumber(
        tuple((path, _text(leaf, game)) for path, leaf in computed), low, high, source
    )


def _leaves(
    value: ast.Expr | ast.Table, path: tuple[str, ...] = ()
) -> Iterator[tuple[tuple[str, ...], ast.Expr]]:
    """Yields the expressions of a number or table, each with its words."""
    if isinstance(value, ast.Table):
        for entry in value.entries:
            yield from _leaves(entry.value, (*path, entry.key.text))
    else:
        yield path, value


def _is_literal(value: ast.Expr, constant: ast.Constant) -> bool:
    if isinstance(value, ast.Unary):
        return _is_literal(value.operand, constant)
    return isinstance(value, ast.Int | ast.Decimal) or (
        constant.unit.text == "word" and isinstance(value, ast.Path)
    )


def _is_inside(inner: Span, outer: Span) -> bool:
    return inner.file == outer.file and outer.start <= inner.start < outer.end


def _text(value: ast.Expr, game: Composition) -> str:
    """Returns an expression as written; one of several lines without its layout."""
    source = game.sources[value.span.file]
    text = source.text[value.span.start : value.span.end]
    return layout_free(source, value.span.start, value.span.end) if "\n" in text else text


def comments(span: Span, sources: dict[str, Source]) -> str:
    """Returns the comments at the ends of the lines that a declaration stands on."""
    source = sources[span.file]
    last = span.line + source.text.count("\n", span.start, span.end)
    found = (_COMMENT.match(source.line(number)) for number in range(span.line, last + 1))
    return "; ".join(match.group(1) for match in found if match and match.group(1))
