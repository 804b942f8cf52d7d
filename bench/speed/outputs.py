"""Where figures go besides the screen: a file, and a page with marks for their tables."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import click

from bench.speed.kernels import Kernels
from bench.speed.resuming import Resume
from bench.speed.stored import Found
from bench.speed.substrates import Substrates
from bench.speed.sweep import Sweep
from bench.speed.tables import notes_of, tables_of
from bench.speed.training import Training
from sjdsl.bench.machine import machine_line
from sjdsl.bench.markdown import markdown_section, replace_section, write_section
from sjdsl.bench.stored import write_found
from sjdsl.cli.bench import print_tables


class Outputs(NamedTuple):
    """Where figures go besides the screen."""

    json: str | None
    page: str | None

    def keep(self, found: Found) -> None:
        """Writes figures to the file, if there is one."""
        if self.json:
            write_found(Path(self.json), found)

    def check(self, *sections: str) -> None:
        """Raises ClickException where the page lacks marks for one of the sections: before anything is measured, not an hour later."""
        for section in sections if self.page else ():
            try:
                replace_section(Path(str(self.page)).read_text(encoding="utf-8"), section, "")
            except (OSError, ValueError) as error:
                raise click.ClickException(f"{self.page}: {error}") from None

    def show(self, section: str, found: Found, command: str, notes: Sequence[str] = ()) -> None:
        """Prints the tables, and writes the section of the page. command: what is quoted there; notes: what is missing from the figures."""
        print_tables(tables_of(found), found.machine, [*notes, *notes_of(found)])
        self.write(section, found, command, notes)

    def write(self, section: str, found: Found, command: str, notes: Sequence[str] = ()) -> None:
        """Writes the section of the page, if there is one."""
        if self.page:
            text = markdown_section(command, machine_line(found.machine), [*notes, *notes_of(found)], tables_of(found))
            write_section(Path(self.page), section, text)


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
