"""The fenced blocks of the manual: which games it shows, and what it says they do."""

import re
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path

MANUAL = Path(__file__).parents[2] / "docs" / "language.md"
_FENCE = re.compile(r"^```(\w*)[ \t]*([^\n]*)\n(.*?)^```[ \t]*$", re.MULTILINE | re.DOTALL)
_WRAPPER = 'sj 1\ngame example extends "{frame}.sj" {{\n'


@dataclass(frozen=True, eq=False)
class Block:
    """One fenced block. `line`: of its first line of text, counted in the manual."""

    language: str
    info: dict[str, str]
    text: str
    line: int


@dataclass(frozen=True, eq=False)
class Example:
    """An `sj` block with the blocks that say what becomes of it.

    source: the file to compile. offset: lines of it before the block's own. frame: the game it extends, none if it is whole.
    """

    name: str
    block: Block
    source: str
    offset: int
    frame: str | None
    expected: tuple[Block, ...] = field(default=())

    def said(self, language: str) -> tuple[Block, ...]:
        """Returns the expectations in blocks of one language: `result`, `error`, `warning`."""
        return tuple(b for b in self.expected if b.language == language)


def read_blocks(text: str) -> list[Block]:
    """Returns the fenced blocks of a Markdown text in order."""
    found = []
    for match in _FENCE.finditer(text):
        info = dict(part.split("=", 1) for part in match.group(2).split())
        found.append(Block(match.group(1), info, match.group(3), text.count("\n", 0, match.start(3)) + 1))
    return found


@cache
def manual_blocks() -> tuple[Block, ...]:
    return tuple(read_blocks(MANUAL.read_text(encoding="utf-8")))


@cache
def frames() -> dict[str, str]:
    """Returns the games that short examples extend, by name."""
    return {b.info["frame"]: b.text for b in manual_blocks() if b.language == "sj" and "frame" in b.info}


@cache
def examples() -> tuple[Example, ...]:
    """Returns the examples of the manual in order; an expectation belongs to the `sj` block before it."""
    found: list[Example] = []
    for block in manual_blocks():
        if block.language == "sj":
            found.append(_example(block))
        elif block.language in ("result", "error", "warning"):
            assert found, f"line {block.line}: nothing to expect from"
            found[-1] = replace(found[-1], expected=(*found[-1].expected, block))
    return tuple(found)


def _example(block: Block) -> Example:
    name = block.info.get("name") or block.info.get("frame") or f"line_{block.line}"
    frame = block.info.get("in")
    if frame is None:
        return Example(name, block, block.text, 0, None)
    assert frame in frames(), f"line {block.line}: there is no frame `{frame}`"
    wrapper = _WRAPPER.format(frame=frame)
    return Example(name, block, f"{wrapper}{block.text}}}\n", wrapper.count("\n"), frame)
