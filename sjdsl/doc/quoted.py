"""Declarations of a game as its file has them: without comments, formatted."""

import re
from collections.abc import Iterable
from textwrap import dedent

from sjdsl.compiler.ast.node import Node
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.format import format_source

COMMENT = re.compile(r'("[^"]*")|#.*')


def written_text(c: Composition, nodes: Iterable[Node | None]) -> str:
    """Returns declarations as they are written, without comments."""
    spans = [node.span for node in nodes if node is not None]
    return "\n".join(COMMENT.sub(lambda found: found[1] or "", c.sources[s.file].text[s.start : s.end]) for s in spans)


def laid_out(text: str, block: str = "") -> list[str]:
    """Returns the lines of declarations as `sjdsl fmt` has them. `block`: the block of a file that they stand in, such as `checks`."""
    head, foot = (["sj 1", "game g {", f"{block} {{"], ["}", "}"]) if block else (["sj 1", "game g {"], ["}"])
    lines = format_source(Source("declarations", "\n".join([*head, text, *foot]))).splitlines() if text else []
    return dedent("\n".join(line for line in lines[len(head) : -len(foot)] if line)).splitlines()
