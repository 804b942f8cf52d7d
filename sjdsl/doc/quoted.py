"""Declarations of a game as its file has them, formatted, with or without their comments."""

import re
from collections.abc import Iterable
from itertools import takewhile
from textwrap import dedent

from sjdsl.compiler.ast.node import Node
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.doc.wording import fenced
from sjdsl.format import format_source

COMMENT = re.compile(r'("[^"]*")|#.*')
BEHIND = re.compile(
    r"[ \t}]*(#.*)"
)  # also behind the end of the block that a declaration is the last of


def quoted(c: Composition, nodes: Iterable[Node | None], block: str = "") -> list[str]:
    """Returns declarations with their comments, between fences; nothing without declarations."""
    text = "\n".join(with_comments(c, node) for node in nodes if node is not None)
    return [*fenced(laid_out(text, block), "sj"), ""] if text else []


def with_comments(c: Composition, node: Node) -> str:
    """Returns a declaration as it is written, with the comment behind it and the lines of comments right above it."""
    text, start, end = c.sources[node.span.file].text, node.span.start, node.span.end
    *before, indent = text[:start].split("\n")
    above = takewhile(
        lambda line: line.lstrip().startswith("#"), [] if indent.strip() else reversed(before)
    )
    return "\n".join([*reversed(list(above)), f"{text[start:end]}  {comment_behind(c, node)}"])


def comment_behind(c: Composition, node: Node) -> str:
    """Returns the comment that ends the last line of a declaration, with its `#`; "" if there is none, or it is of what follows."""
    found = BEHIND.match(c.sources[node.span.file].text, node.span.end)
    return found[1].rstrip() if found else ""


def written_text(c: Composition, nodes: Iterable[Node | None]) -> str:
    """Returns declarations as they are written, without comments."""
    spans = [node.span for node in nodes if node is not None]
    return "\n".join(
        COMMENT.sub(lambda found: found[1] or "", c.sources[s.file].text[s.start : s.end])
        for s in spans
    )


def laid_out(text: str, block: str = "") -> list[str]:
    """Returns the lines of declarations as `sjdsl fmt` has them. `block`: the block of a file that they stand in, such as `checks`."""
    head, foot = (
        (["sj 1", "game g {", f"{block} {{"], ["}", "}"])
        if block
        else (["sj 1", "game g {"], ["}"])
    )
    lines = (
        format_source(Source("declarations", "\n".join([*head, text, *foot]))).splitlines()
        if text
        else []
    )
    return dedent("\n".join(line for line in lines[len(head) : -len(foot)] if line)).splitlines()
