"""Sentences in order, each with those it holds for, and their layout as plain text."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

WIDEST = 240  # characters of a sentence that takes those inside it onto its own line

# A name of the game at the beginning of a sentence keeps its small letter.
OPENERS = frozenset({
    "a", "agent", "all", "an", "at", "cell", "each", "every", "for", "if", "in", "let", "moves",
    "one", "otherwise", "pairs", "the", "what", "who", "whoever", "with",
})  # fmt: skip
CONDITIONS = ("if ", "with probability ", "otherwise")


@dataclass(frozen=True)
class Line:
    """A sentence, and the sentences it holds for; it begins with a small letter.

    is_joined: whether it holds sentences that were joined to it.
    """

    text: str
    inside: tuple["Line", ...] = ()
    is_joined: bool = False


def bullets(lines: Iterable[Line], depth: int = 0) -> Iterator[str]:
    """Yields sentences as a nested list; short ones inside another follow on its line."""
    for line in lines:
        short = joined_to_one(line)
        end = ":" if short.inside else "."
        yield f"{'  ' * depth}- {capital(short.text)}{end}"
        yield from bullets(short.inside, depth + 1)


def joined_to_one(line: Line) -> Line:
    """Returns a sentence with those inside it as one, if that is short.

    Only the last sentence inside may hold others: what follows would seem to belong to it. A
    condition takes no other one: an "otherwise" that follows would seem to belong to that. It
    takes one sentence alone: of several, the last ones would seem to hold without it.
    """
    inside = tuple(map(joined_to_one, line.inside))
    if line.text.startswith(CONDITIONS):
        if len(inside) > 1 or any(inner.text.startswith(CONDITIONS) for inner in inside):
            return Line(line.text, inside)
    is_open = [inner.is_joined or inner.inside for inner in inside]
    if inside and not any(is_open[:-1]) and not inside[-1].inside:
        link = ", " if line.text.startswith(CONDITIONS) else ": "
        text = f"{line.text}{link}{'; '.join(inner.text for inner in inside)}"
        if len(text) < WIDEST:
            return Line(text, is_joined=True)
    return Line(line.text, inside)


def capital(text: str) -> str:
    """Returns a sentence with a capital, unless it begins with a name."""
    first = text.partition(" ")[0].strip(",:")
    return text[:1].upper() + text[1:] if first in OPENERS else text
