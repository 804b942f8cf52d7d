"""`sjdsl fmt`: formats `.sj` files; their meaning and comments stay."""

import sys
from collections.abc import Iterable
from pathlib import Path

import click

from sjdsl.cli.diagnostics import print_diagnostics
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.read import decode, read_source
from sjdsl.files import write_whole
from sjdsl.format import format_source

STDIN = "-"
STDIN_NAME = "standard input"
UNCHANGED = "unchanged"
WITH_ERRORS = "with errors"


@click.command("fmt")
@click.argument("paths", nargs=-1, required=True, metavar="FILE|FOLDER|-...")
@click.option(
    "--check",
    "only_check",
    is_flag=True,
    help="Write nothing; exit with 1 and name the files that would be reformatted.",
)
def command(paths: tuple[str, ...], only_check: bool) -> int:
    """Formats `.sj` files: spaces, line breaks and columns. Comments stay, and so do line breaks
    between statements.

    A FOLDER means all `.sj` files in and below it, except in hidden folders. `-` reads a game from
    standard input and writes it to standard output. A file with syntax errors stays as it is; the
    errors are shown, and the exit status is 1.
    """
    if STDIN in paths:
        if len(paths) > 1:
            raise click.UsageError("`-` reads standard input: don't name other files")
        return _format_stdin(only_check)
    changed = "to be reformatted" if only_check else "reformatted"
    counts = dict.fromkeys((changed, UNCHANGED, WITH_ERRORS), 0)
    for path in files_of(paths):
        try:
            text = format_source(read_source(path))
        except CompileError as error:
            print_diagnostics(error.diagnostics, err=True)
            counts[WITH_ERRORS] += 1
            continue
        if path.read_bytes() == text.encode():
            counts[UNCHANGED] += 1
            continue
        counts[changed] += 1
        if only_check:
            click.echo(f"{path} would be reformatted")
        else:
            write_whole(path.resolve(), text)  # a link to the file stays
            click.echo(f"{path} was reformatted")
    number = sum(counts.values())
    plural = "" if number == 1 else "s"
    listed = ", ".join(f"{count} {state}" for state, count in counts.items() if count)
    click.echo(f"{number} file{plural}: {listed}")
    return int(counts[WITH_ERRORS] > 0 or (only_check and counts[changed] > 0))


def files_of(paths: Iterable[str]) -> list[Path]:
    """Returns the files in `paths`, and the `.sj` files in the folders there, each once.

    Raises ClickException for a missing path, and for a folder without such files.
    """
    files: list[Path] = []
    for name in paths:
        path = Path(name)
        if path.is_dir():
            games = sorted(file for file in path.rglob("*.sj") if _is_visible(file, path))
            if not games:
                raise click.ClickException(f"there are no `.sj` files in the folder {name}")
            files += games
        elif path.suffix == ".sj" or path.is_file():
            files.append(path)
        else:
            raise click.ClickException(f"there is no file or folder `{name}`")
    return list(dict.fromkeys(files))


def _is_visible(path: Path, folder: Path) -> bool:
    """Whether a path is a file that is in no hidden folder below `folder`."""
    parts = path.relative_to(folder).parts
    return path.is_file() and not any(part.startswith(".") for part in parts)


def _format_stdin(only_check: bool) -> int:
    """Formats standard input; returns the exit status."""
    data = sys.stdin.buffer.read()
    source = Source(STDIN_NAME, "")
    try:
        source = decode(data, STDIN_NAME)
        text = format_source(source)
    except CompileError as error:
        print_diagnostics(error.diagnostics, {STDIN_NAME: source}, err=True)
        return 1
    if not only_check:
        click.echo(text.encode(), nl=False)  # UTF-8, whatever the encoding of the terminal
        return 0
    is_same = data == text.encode()
    click.echo(f"{STDIN_NAME} {'is formatted' if is_same else 'would be reformatted'}")
    return int(not is_same)
