"""What a report consists of: sections with tables, pictures, and the commands that fill what is empty."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Table:
    """A table as text under headings, the first `labels` columns words; and as records, a row of its CSV each, with everything in it."""

    name: str  # of its CSV
    title: str
    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    records: tuple[Mapping[str, Any], ...]
    labels: int = 1


@dataclass(frozen=True)
class Picture:
    """A picture that is drawn when it is written."""

    name: str
    title: str
    draw: Callable[[], "Figure"]


@dataclass(frozen=True)
class Section:
    """A part of a report. `text`: paragraphs; `fill`: commands that find what is empty.

    `stamp`: a digest of what a section is made of that needs an extra, so that without the extra an earlier text can stay; `lacks`: what to
    install, where it is missing.
    """

    title: str
    text: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()
    pictures: tuple[Picture, ...] = ()
    fill: tuple[str, ...] = ()
    stamp: str = ""
    lacks: str = ""
