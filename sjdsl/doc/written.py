"""What the text of a game says beside its rules: where its numbers come from, how they are computed, which variants there are."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import PurePath

from sjdsl.compiler import ast, ir, load_base
from sjdsl.compiler.compose import Composition, compose
from sjdsl.compiler.diagnostics import CompileError
from sjdsl.compiler.elaborate import Overrides, elaborate
from sjdsl.compiler.parse import parse
from sjdsl.compiler.source import Source, Span
from sjdsl.compiler.streams import layout_free

_COMMENT = re.compile(r'^(?:[^"#]|"[^"]*")*#\s*(.*?)\s*$')


@dataclass(frozen=True)
class WrittenNumber:
    """A size or parameter as its file has it.

    formula: how the value is computed, empty if it is plainly written; low, high: limits as written, empty without; source:
    the comments beside the value.
    """

    formula: str
    low: str
    high: str
    source: str


@dataclass(frozen=True)
class Written:
    """The rules of a game in one variant, and what its text says beside them. `chosen`: the variants applied; `variants`: (name, title)."""

    game: ir.Game
    file: str
    chosen: tuple[str, ...]
    variants: tuple[tuple[str, str], ...]
    numbers: dict[str, WrittenNumber]


def read_written(source: Source, variants: Sequence[str] = ()) -> Written:
    """Returns a game with what its text says beside the rules. Raises CompileError."""
    composed = compose(source, parse(source), tuple(variants), load_base)
    game, found = elaborate(composed, Overrides())
    if game is None:
        raise CompileError(found)
    return Written(
        game=game,
        file=PurePath(source.name).name,
        chosen=tuple(variants),
        variants=tuple((v.name.text, v.title.text if v.title else "") for v in composed.variants.values()),
        numbers={name: _number(constant, composed) for name, constant in composed.constants.items()},
    )


def _number(constant: ast.Constant, game: Composition) -> WrittenNumber:
    leaves = list(_leaves(constant.value))
    of_words = constant.unit.text == "word"
    literal = all(isinstance(leaf, ast.Int | ast.Decimal) or (of_words and isinstance(leaf, ast.Path)) for leaf in map(_unsigned, leaves))
    low, high = ("" if bound is None else _text(bound, game) for bound in (constant.low, constant.high))
    here = [leaf.span for leaf in leaves if _is_inside(leaf.span, constant.span)]
    elsewhere = [leaf.span for leaf in leaves if not _is_inside(leaf.span, constant.span)]
    found = [comments(span, game.sources) for span in ([constant.span] if here else []) + elsewhere]
    source = "; ".join(dict.fromkeys(text for text in found if text))
    return WrittenNumber("" if literal else _text(constant.value, game), low, high, source)


def _leaves(value: ast.Expr | ast.Table) -> Iterator[ast.Expr]:
    """Yields the expressions of a number or table."""
    if isinstance(value, ast.Table):
        for entry in value.entries:
            yield from _leaves(entry.value)
    else:
        yield value


def _unsigned(value: ast.Expr) -> ast.Expr:
    return _unsigned(value.operand) if isinstance(value, ast.Unary) else value


def _is_inside(inner: Span, outer: Span) -> bool:
    return inner.file == outer.file and outer.start <= inner.start < outer.end


def _text(value: ast.Expr | ast.Table, game: Composition) -> str:
    """Returns a value as written; of a table each entry, for a variant may have changed some."""
    if isinstance(value, ast.Table):
        return "{ " + ", ".join(f"{e.key.text}: {_text(e.value, game)}" for e in value.entries) + " }"
    return layout_free(game.sources[value.span.file], value.span.start, value.span.end)


def comments(span: Span, sources: dict[str, Source]) -> str:
    """Returns the comments at the ends of the lines that a declaration stands on."""
    source = sources[span.file]
    last = span.line + source.text.count("\n", span.start, span.end)
    found = (_COMMENT.match(source.line(number)) for number in range(span.line, last + 1))
    return "; ".join(match.group(1) for match in found if match and match.group(1))
