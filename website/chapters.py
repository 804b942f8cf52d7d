"""Splits the manual, one file, into a page a chapter, and knows on which of them each of its anchors is."""

import re
import unicodedata
from dataclasses import dataclass

FENCE = re.compile(r"^( *)(`{3,}).*?^\1\2 *$", re.DOTALL | re.MULTILINE)
HEADING = re.compile(r"^(#+) +(.+?) *$", re.MULTILINE)
LINK = re.compile(r"\[([^\]]*)\]\([^)]*\)")
ANCHOR = re.compile(r'<a id="([^"]+)">')


@dataclass(frozen=True)
class Chapter:
    """A page of a manual. name: of its file, without ending; title: its heading; text: its Markdown, whose first heading is of level 1."""

    name: str
    title: str
    text: str


def slug(title: str, _separator: str = "-") -> str:
    """Returns the anchor of a heading, by the rule of GitHub: small letters, no signs, a hyphen for each space."""
    plain = unicodedata.normalize("NFC", LINK.sub(r"\1", title)).lower()
    return re.sub(r"[^\w\- ]", "", plain).strip().replace(" ", "-")


def without_code(text: str) -> str:
    """Returns a text of the same length in which blocks of code are blank: what looks like a heading in them is none."""
    return FENCE.sub(lambda found: re.sub(r"[^\n]", " ", found.group()), text)


def anchors(text: str) -> set[str]:
    """Returns all anchors of a page."""
    plain = without_code(text)
    return {slug(title) for _, title in HEADING.findall(plain)} | set(ANCHOR.findall(plain))


def raised(text: str, levels: int) -> str:
    """Returns a text whose headings are so many levels higher; of a negative number, lower."""
    plain, pieces, at = without_code(text), [], 0
    for found in HEADING.finditer(plain):
        depth = len(found.group(1)) - levels
        pieces += [text[at : found.start()], "#" * max(1, depth)]
        at = found.end(1)
    return "".join([*pieces, text[at:]])


def split(text: str) -> tuple[str, list[Chapter]]:
    """Returns what stands before the first chapter, and the chapters: the parts that begin with a heading of level 2.

    Raises ValueError if two headings have the same anchor: a link to it could not tell which page is meant.
    """
    plain = without_code(text)
    slugs = [slug(title) for _, title in HEADING.findall(plain)]
    twice = sorted({name for name in slugs if slugs.count(name) > 1})
    if twice:
        raise ValueError(f"headings with the same anchor: {', '.join(twice)}")
    starts = [found for found in HEADING.finditer(plain) if found.group(1) == "##"]
    ends = [*(found.start() for found in starts[1:]), len(text)]
    chapters = [
        Chapter(
            re.sub(r"^\d+-", "", slug(found.group(2))),
            found.group(2),
            raised(text[found.start() : end], 1),
        )
        for found, end in zip(starts, ends)
    ]
    return text[: starts[0].start()], chapters
