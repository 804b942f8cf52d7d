"""`sjdsl bench --everything` measures all figures of a device; `--from` makes the tables from stored figures."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import click

from sjdsl.cli.bench_training import training_section

if TYPE_CHECKING:
    from sjdsl.bench import Task
    from sjdsl.bench.everything import Done
    from sjdsl.bench.stored import Found

SCALED = (1024, 4096, 16_384, 65_536)  # environments, on a device that wants many
WORKERS = 8  # programs compiled at the same time


class Stored(NamedTuple):
    """Figures of one file, where they stand on a page, the command that measured them, and what is missing from them."""

    section: str
    found: "Found"
    command: str
    notes: tuple[str, ...]


def measure_all(
    games: Sequence[str], tasks: Sequence["Task"], envs: Sequence[int] | None, repeats: int, minutes: float, folder: Path, command: str
) -> None:
    """Measures everything of the games' forms and prints how each part ended. Raises ClickException where nothing could be measured."""
    import jax

    from sjdsl.bench.everything import Plan, measure_everything, parts_of

    on_cpu = jax.default_backend() == "cpu"
    plan = Plan(
        tasks,
        envs or SCALED,
        repeats,
        games[0],
        training_envs=16 if on_cpu else 256,
        convolutional=3,
        workers=1 if on_cpu else WORKERS,
    )
    parts = tuple(parts_of(plan, lambda _: None))
    done = measure_everything(parts, folder, minutes, command, tell=click.echo)
    missing = [part for part in done if part.status != "measured"]
    for part in missing:
        click.echo(f"not measured: {part.name} ({part.status})", err=True)
    if len(missing) == len(done):
        raise click.ClickException(f"nothing could be measured; {folder / 'parts.json'} says why")
    click.echo(f"{len(done) - len(missing)} of {len(done)} parts measured; figures in {folder}; tables: sjdsl bench --from {folder}")


def read_all(path: Path, command: str) -> Iterator[Stored]:
    """Yields the figures of a file, or of every file of a folder that `--everything` has left. Raises ClickException.

    Args:
      path: a file of `--json`, or a folder of `--everything`.
      command: what is quoted beside the figures of a single file.
    """
    from sjdsl.bench.everything import read_parts
    from sjdsl.bench.stored import read_found

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


def speed_section(devices: int) -> str:
    """Returns the name of the marks for speeds, without the platform: `speed`, or `speed 2 devices`."""
    return "speed" if devices == 1 else f"speed {devices} devices"


def section_of(found: "Found") -> str:
    """Returns the marks of a page between which these figures belong: `speed gpu`, `training mlp gpu`, `sweep coins spawn cpu`."""
    from sjdsl.bench import Sweep, Training
    from sjdsl.bench.kernels import Kernels
    from sjdsl.bench.resuming import Resume
    from sjdsl.bench.substrates import Substrates

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


def _missing(parts: Sequence["Done"], file: str) -> Iterator[str]:
    """Yields a note for each part of a file that was not measured."""
    for part in parts:
        if part.file == file and part.status != "measured":
            yield f"not measured: {part.name} ({part.status})"
