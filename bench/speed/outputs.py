"""Where figures go besides the screen: a file, and a page with marks for their tables."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import click

from bench.speed.everything import Done, read_parts
from bench.speed.kernels import Kernels
from bench.speed.resuming import Resume
from bench.speed.stored import Found, read_found
from bench.speed.substrates import Substrates
from bench.speed.sweep import Sweep
from bench.speed.tables import notes_of, tables_of
from bench.speed.training import Training
from sjdsl.bench.machine import machine_line
from sjdsl.bench.markdown import markdown_section, new_page, replace_section, write_section
from sjdsl.bench.stored import write_found
from sjdsl.cli.bench import print_tables


class Stored(NamedTuple):
    """Figures of one file, where they stand on a page, the command that measured them, and what is missing from them."""

    section: str
    found: Found
    command: str
    notes: tuple[str, ...] = ()


class Outputs(NamedTuple):
    """Where figures go besides the screen."""

    json: str | None
    page: str | None

    def keep(self, found: Found) -> None:
        """Writes figures to the file, if there is one."""
        if self.json:
            write_found(Path(self.json), found)

    def check(self, *sections: str) -> None:
        """Makes a new page with marks for the sections. Raises ClickException where a page that is there lacks some.

        Before anything is measured, not an hour later.
        """
        page = Path(self.page) if self.page else None
        if page is None:
            return
        if not page.is_file():
            new_page(page, sections)
        for section in sections:
            try:
                replace_section(page.read_text(encoding="utf-8"), section, "")
            except ValueError as error:
                raise click.ClickException(f"{page}: {error}") from None

    def show(self, figures: Stored) -> None:
        """Prints the tables, and writes the section of the page."""
        found = figures.found
        print_tables(tables_of(found), found.machine, [*figures.notes, *notes_of(found)])
        self.write(figures)

    def write(self, figures: Stored) -> None:
        """Writes the section of the page, if there is one."""
        if self.page is None:
            return
        found = figures.found
        text = markdown_section(figures.command, machine_line(found.machine), [*figures.notes, *notes_of(found)], tables_of(found))
        write_section(Path(self.page), figures.section, text)


def read_all(path: Path, command: str) -> Iterator[Stored]:
    """Yields the figures of a file, or of every file of a folder that `everything` has left. Raises ClickException.

    Args:
      path: a file of `--json`, or a folder of `everything`.
      command: what is quoted beside the figures of a single file.
    """
    try:
        if not path.is_dir():
            found = read_found(path)
            yield Stored(section_of(found), found, command, ())
            return
        said, parts = read_parts(path)
        for name in dict.fromkeys(part.file for part in parts):
            if (path / name).exists():
                found = read_found(path / name)
                yield Stored(section_of(found), found, said, tuple(_missing(parts, name)))
    except (OSError, ValueError) as error:
        raise click.ClickException(str(error)) from None


def section_of(found: Found) -> str:
    """Returns the marks of a page between which these figures belong: `speed gpu`, `training mlp gpu`, `sweep coins spawn cpu`."""
    match found:
        case Sweep():
            what = f"sweep {found.name} {found.param}"
        case Training():
            what = training_section([(split.network, split.algorithm, split.sharing) for split in found.splits])
        case Kernels():
            what = "kernels"
        case Resume():
            what = "resuming"
        case Substrates():
            what = "substrates"
        case _:
            what = speed_section(found.machine.get("devices", 1))
    return f"{what} {found.machine['platform']}"


def speed_section(devices: int) -> str:
    """Returns the name of the marks for speeds, without the platform: `speed`, or `speed 2 devices`."""
    return "speed" if devices == 1 else f"speed {devices} devices"


def training_section(learnt: Sequence[tuple[str, str, str]]) -> str:
    """Returns the marks on a page of updates by (network, algorithm, sharing): `training mlp`; of others than IPPO with shared networks
    `training mlp ippo,mappo shared`."""
    if not learnt:
        return "training"
    networks, algorithms, sharings = (tuple(dict.fromkeys(words)) for words in zip(*learnt, strict=True))
    what = f"training {','.join(networks)}"
    return what if (algorithms, sharings) == (("ippo",), ("shared",)) else f"{what} {','.join(algorithms)} {','.join(sharings)}"


def _missing(parts: Sequence[Done], file: str) -> Iterator[str]:
    """Yields a note for each part of a file that was not measured."""
    for part in parts:
        if part.file == file and part.status != "measured":
            yield f"not measured: {part.name} ({part.status})"
