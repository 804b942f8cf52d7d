"""The fenced blocks of the manual and of the pages beside it: which games they show, and what they say these do."""

import re
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path

MANUAL = Path(__file__).parents[2] / "docs" / "language.md"
CORNERS = Path(__file__).parent / "corners.md"  # what the manual says and does not show
BESIDE = (
    MANUAL.parent / "tour.md",
    MANUAL.parent / "recipes.md",
    CORNERS,
)  # pages whose examples are tested in the same way
_FENCE = re.compile(r"^```(\w*)[ \t]*([^\n]*)\n(.*?)^```[ \t]*$", re.MULTILINE | re.DOTALL)
_WRAPPER = 'sj 1\ngame example extends "{frame}.sj" {{\n'


@dataclass(frozen=True, eq=False)
class Block:
    """One fenced block. `line`: of its first line of text, counted in its page."""

    language: str
    info: dict[str, str]
    text: str
    line: int
    page: Path


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


def read_blocks(page: Path) -> list[Block]:
    """Returns the fenced blocks of a Markdown page in order."""
    found, text = [], page.read_text(encoding="utf-8")
    for match in _FENCE.finditer(text):
        info = dict(part.split("=", 1) for part in match.group(2).split())
        found.append(
            Block(
                match.group(1), info, match.group(3), text.count("\n", 0, match.start(3)) + 1, page
            )
        )
    return found


@cache
def blocks(*pages: Path) -> tuple[Block, ...]:
    """Returns the blocks of pages, of all tested ones if none is given."""
    return tuple(block for page in pages or (MANUAL, *BESIDE) for block in read_blocks(page))


@cache
def frames() -> dict[str, str]:
    """Returns the games that short examples extend, by name; one may extend another that stands above it."""
    found: dict[str, str] = {}
    for block in blocks():
        if block.language == "sj" and "frame" in block.info:
            found[block.info["frame"]] = _source(block, found)[0]
    return found


@cache
def examples(*pages: Path) -> tuple[Example, ...]:
    """Returns the examples of pages in order, of all if none is given; an expectation belongs to the `sj` block before it."""
    found: list[Example] = []
    for block in blocks(*pages):
        if block.language == "sj":
            source, offset = _source(block, frames())
            found.append(Example(_name(block), block, source, offset, block.info.get("in")))
        elif block.language in ("result", "error", "warning"):
            assert found, f"{block.page.name}, line {block.line}: nothing to expect from"
            found[-1] = replace(found[-1], expected=(*found[-1].expected, block))
    return tuple(found)


def _name(block: Block) -> str:
    where = f"line_{block.line}" if block.page == MANUAL else f"{block.page.stem}_line_{block.line}"
    return block.info.get("name") or block.info.get("frame") or where


def _source(block: Block, frames: dict[str, str]) -> tuple[str, int]:
    """Returns the file that a block stands for, and how many lines of it stand before the block's own."""
    frame = block.info.get("in")
    if frame is None:
        return block.text, 0
    assert frame in frames, f"{block.page.name}, line {block.line}: there is no frame `{frame}`"
    wrapper = _WRAPPER.format(frame=frame)
    return f"{wrapper}{block.text}}}\n", wrapper.count("\n")
