"""Declarations as the file of a game has them, formatted, with or without their comments."""

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
# Behind a declaration, also behind the end of the block that it is the last of.
COMMENT_BEHIND = re.compile(r"[ \t}]*(#.*)")


def quoted(c: Composition, nodes: Iterable[Node | None], block: str = "") -> list[str]:
    """Returns declarations with their comments, between fences; no lines without declarations."""
    text = "\n".join(with_comments(c, node) for node in nodes if node is not None)
    return [*fenced(laid_out(text, block), "sj"), ""] if text else []


def with_comments(c: Composition, node: Node) -> str:
    """Returns a declaration as written, with the comments right above and behind it."""
    text = c.sources[node.span.file].text
    *lines_before, indent = text[: node.span.start].split("\n")
    lines = [f"{text[node.span.start : node.span.end]}  {comment_behind(c, node)}"]
    if not indent.strip():
        for line in takewhile(_is_comment, reversed(lines_before)):
            lines.insert(0, line)
    return "\n".join(lines)


def _is_comment(line: str) -> bool:
    return line.lstrip().startswith("#")


def comment_behind(c: Composition, node: Node) -> str:
    """Returns the comment behind a declaration, with its `#`.

    It is "" if there is none, or if something else stands between.
    """
    comment = COMMENT_BEHIND.match(c.sources[node.span.file].text, node.span.end)
    return comment[1].rstrip() if comment else ""


def written_text(c: Composition, nodes: Iterable[Node | None]) -> str:
    """Returns declarations as written, without comments."""
    texts = []
    for node in nodes:
        if node is not None:
            text = c.sources[node.span.file].text[node.span.start : node.span.end]
            texts.append(COMMENT.sub(lambda match: match[1] or "", text))
    return "\n".join(texts)


def laid_out(text: str, block: str = "") -> list[str]:
    """Returns the lines of declarations as `sjdsl fmt` formats them.

    Args:
      block: the block of a file that they belong to, such as `checks`, "" for none.
    """
    if not text:
        return []
    head = ["sj 1", "game g {"]
    foot = ["}"]
    if block:
        head.append(f"{block} {{")
        foot.append("}")
    source = Source("declarations", "\n".join([*head, text, *foot]))
    lines = format_source(source).splitlines()[len(head) : -len(foot)]
    return dedent("\n".join(line for line in lines if line)).splitlines()
