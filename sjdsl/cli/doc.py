"""`sjdsl doc`: the rules of a game in plain English, and the page of all bundled games."""

import os
from pathlib import Path

import click

from sjdsl.cli.game_file import open_game, split_variants, variant_option


@click.command("doc")
@click.argument("file", required=False, metavar="GAME")
@variant_option
@click.option("-o", "output", metavar="FILE", help="Write there instead of printing.")
def command(file: str | None, variant: str | None, output: str | None) -> int:
    """Prints the rule sheet of GAME, a `.sj` file or a bundled game: its rules in words, in the order of the ODD protocol."""
    if file is None:
        raise click.UsageError("name a game", click.get_current_context())
    from sjdsl.doc import read_written, rule_sheet

    text = rule_sheet(read_written(open_game(file), split_variants(variant)))
    if output is None:
        click.echo(text, nl=False)
    else:
        write_text(Path(output), text)
        click.echo(f"{output}  {len(text.splitlines())} lines")
    return 0


def write_text(path: Path, text: str) -> None:
    """Writes a text whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    unfinished = path.with_name(f"{path.name}.{os.getpid()}")
    unfinished.write_text(text, encoding="utf-8", newline="\n")
    os.replace(unfinished, path)
