"""Finds rules that a game has changed of the game that it extends, and a variant of that game changes back.

Numbers and maps are left out: a variant is chosen for those it brings.
"""

from collections.abc import Iterable, Iterator, Mapping

from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import Diagnostic, Label
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.source import Span


class Change(Record):
    """What a file says of one name, outside of variants: its text without layout. is_drop: it takes the name away, whatever it is of."""

    span: Span
    text: str
    is_drop: bool


def undone(files: Iterable[str], said_last: Mapping[str, Change], variant: str, changes: Mapping[str, Change]) -> Iterator[Diagnostic]:
    """Yields a warning for each change of an extending game that a change of a variant of its base replaces.

    `files`: those of the game, the outermost base first. `said_last`: what they say of each name.
    """
    order = {file: place for place, file in enumerate(files)}
    for key, change in changes.items():
        for other, before in said_last.items():
            if order[before.span.file] > order[change.span.file] and before.text != change.text and _meet(key, change, other, before):
                label = Label(change.span, f"`{variant}` changes it here")
                yield errors.UndoneByVariant(before.span, labels=(label,), name=other, variant=variant)


def _meet(key: str, change: Change, other: str, before: Change) -> bool:
    if change.is_drop or before.is_drop:
        key, other = key.rpartition(" ")[2], other.rpartition(" ")[2]
    return touches(key, other)


def touches(a: str, b: str) -> bool:
    """Returns whether two keys name the same thing, or one an entry of the other: `pay` and `pay[red]`."""
    return a == b or a.startswith(f"{b}[") or b.startswith(f"{a}[")
