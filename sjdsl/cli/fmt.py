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


@click.command("fmt")
@click.argument("paths", nargs=-1, required=True, metavar="FILE|FOLDER|-...")
@click.option(
    "--check",
    "only_check",
    is_flag=True,
    help="Write nothing; exit with 1 and name the files that would be reformatted.",
)
def command(paths: tuple[str, ...], only_check: bool) -> int:
    """Formats `.sj` files: spaces, line breaks and columns. Comments stay, and so do line breaks between statements.

    A FOLDER means all `.sj` files in and below it, except in hidden folders. `-` reads a game from standard input and writes it to
    standard output. A file with syntax errors stays as it is; the errors are shown, and the exit status is 1.
    """
    if STDIN in paths:
        if len(paths) > 1:
            raise click.UsageError("`-` reads standard input: don't name other files")
        return _format_stdin(only_check)
    changed, unchanged, problems = 0, 0, 0
    for path in files_of(paths):
        try:
            text = format_source(read_source(path))
        except CompileError as error:
            print_diagnostics(error.diagnostics, err=True)
            problems += 1
            continue
        if path.read_bytes() == text.encode():
            unchanged += 1
            continue
        changed += 1
        if only_check:
            click.echo(f"{path} would be reformatted")
        else:
            write_whole(path.resolve(), text)  # a link to the file stays
            click.echo(f"{path} was reformatted")
    counts = {
        "to be reformatted" if only_check else "reformatted": changed,
        "unchanged": unchanged,
        "with errors": problems,
    }
    number = changed + unchanged + problems
    click.echo(
        f"{number} file{'s' * (number != 1)}: {', '.join(f'{count} {what}' for what, count in counts.items() if count)}"
    )
    return int(problems > 0 or (only_check and changed > 0))


def files_of(paths: Iterable[str]) -> list[Path]:
    """Returns the files that are named, and those in the folders that are named, each once. Raises ClickException if there are none."""
    found: list[Path] = []
    for name in paths:
        path = Path(name)
        if path.is_dir():
            visible = (
                p
                for p in path.rglob("*.sj")
                if not any(part.startswith(".") for part in p.relative_to(path).parts)
            )
            inside = sorted(p for p in visible if p.is_file())
            if not inside:
                raise click.ClickException(f"there are no `.sj` files in the folder {name}")
            found += inside
        elif path.suffix == ".sj" or path.is_file():
            found.append(path)
        else:
            raise click.ClickException(f"there is no file or folder `{name}`")
    return list(dict.fromkeys(found))


def _format_stdin(only_check: bool) -> int:
    data = sys.stdin.buffer.read()
    source = Source(STDIN_NAME, "")
    try:
        source = decode(data, STDIN_NAME)
        text = format_source(source)
    except CompileError as error:
        print_diagnostics(error.diagnostics, {STDIN_NAME: source}, err=True)
        return 1
    if not only_check:
        click.echo(
            text.encode(), nl=False
        )  # as a file has it, whatever the encoding of the terminal
        return 0
    is_same = data == text.encode()
    click.echo(f"{STDIN_NAME} {'is formatted' if is_same else 'would be reformatted'}")
    return int(not is_same)
