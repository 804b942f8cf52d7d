"""The statements of a game as their author wrote them, with file and line."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import PurePath

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.compiler.ir.printer import expression_text
from sjdsl.interpreter.overflow import LeavesFloat32

_COMMENT_OR_TEXT = re.compile(r'("(?:\\.|[^"\\\n])*")|#[^\n]*')
UNKNOWN = "?"  # of a game that was built without a text


@dataclass(frozen=True)
class Rules:
    """The texts that a game was built from, by name."""

    sources: Mapping[str, Source]

    def place(self, statement: ir.Node) -> str:
        """Returns `clean_up.sj:52`."""
        span = statement.origin
        return UNKNOWN if span is None else f"{PurePath(span.file).name}:{span.line}"

    def overflow(self, error: LeavesFloat32) -> str:
        """Returns where and when a real left float32."""
        place = self.place(error.node)
        return f"{place}: in step {error.before}, `{self.text(error.node)}`: {error}"

    def text(self, statement: ir.Node) -> str:
        """Returns a statement up to its block, without comments, on one line."""
        span = statement.origin
        if span is None or span.file not in self.sources:
            return type(statement).__name__.lower()
        return self._one_line(span, _end_of_header(statement, span))

    def expression(self, e: ir.Expr) -> str:
        """Returns an expression as written, on one line."""
        span = e.origin
        if span is None or span.file not in self.sources:
            return expression_text(e)
        return self._one_line(span, span.end)

    def branch(self, statement: "ir.When | ir.Chance", number: int) -> str:
        """Returns the header of one branch: `chance 0.5`, `otherwise chance 0.2`."""
        if number == 0:
            return self.text(statement)
        branch = statement.branches[number]
        span = branch.origin
        if span is None or branch.test.origin is None or span.file not in self.sources:
            return f"branch {number + 1} of {self.text(statement)}"
        return f"otherwise {self._one_line(span, branch.test.origin.end)}"

    def _one_line(self, span: Span, end: int) -> str:
        """Returns the text from a span's start to `end` without comments and line ends."""
        text = self.sources[span.file].text[span.start : end]
        return " ".join(_COMMENT_OR_TEXT.sub(lambda match: match[1] or "", text).split())


def _end_of_header(statement: ir.Node, span: Span) -> int:
    """Returns where the block of a statement begins, or where the statement ends if it has none."""
    match statement:
        case ir.When() | ir.Chance():
            last = statement.branches[0].test.origin
        case ir.Each() | ir.Pick() | ir.First():
            last = statement.domain.origin
        case ir.Match():
            last = statement.right.origin
        case _:
            last = span
    return (last or span).end
