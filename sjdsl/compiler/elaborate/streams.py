"""Numbers of random streams: hashes of a phase use and a statement's text.

A change to one statement leaves the streams of all others alone.
"""

import hashlib
import re
from collections import Counter
from dataclasses import dataclass, field, replace

from sjdsl.compiler import ast
from sjdsl.compiler.diagnostics.source import Source, Span

_TOKEN = re.compile(r'"(?:\\.|[^"\\\n])*"|[a-z][a-z0-9_]*|\d+\.\d+|\d+|\.\.|->|[<>=!]=|#[^\n]*|\S')


def layout_free(source: Source, start: int, end: int) -> str:
    """Returns the tokens of a part of the text, one space between, comments left out."""
    tokens = _TOKEN.findall(source.text[start:end])
    return " ".join(token for token in tokens if not token.startswith("#"))


@dataclass
class Streams:
    """Hands out stream numbers for one use of a phase.

    label: of the use, such as `sprout(red)`. sources: the texts by file.
    around: the headers of the statements around, which are their texts up to their blocks.
    seen: how often each statement with its surroundings has been seen.
    pools: of sends: the text of a destination -> its number.
    """

    label: str
    sources: dict[str, Source]
    around: tuple[str, ...] = ()
    seen: Counter[str] = field(default_factory=Counter)
    pools: dict[str, int] = field(default_factory=dict)

    def header(self, span: Span, block: ast.Block | None = None) -> str:
        """Returns the text of a statement, up to its block if it has one."""
        end = span.end if block is None else block.span.start
        return layout_free(self.sources[span.file], span.start, end)

    def of_statement(self, text: str) -> int:
        """Returns the stream of a statement; equal ones in equal surroundings are numbered."""
        full = "\n".join((*self.around, text))
        self.seen[full] += 1
        return number(self.label, f"{full}\n{self.seen[full]}")

    def of_line(self, span: Span) -> int:
        """Returns the stream of a statement without a block."""
        return self.of_statement(self.header(span))

    def shared(self, purpose: str, text: str) -> int:
        """Returns the stream that all statements of this phase use share for one purpose."""
        return number(self.label, f"{purpose}\n{text}")

    def inside(self, header: str) -> "Streams":
        """Returns the streams in the block of a statement, whose header joins their names."""
        return replace(self, around=(*self.around, header))


def number(label: str, text: str) -> int:
    """Returns the 32-bit number of a stream."""
    digest = hashlib.sha256(f"{label}\n{text}".encode()).digest()
    return int.from_bytes(digest[:4], "big")
