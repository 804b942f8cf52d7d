"""`sjdsl doc`: prints all the rules of a game on a page."""

from pathlib import Path

import click

from sjdsl.cli.folders import require_folder_of
from sjdsl.cli.game_file import open_game, variant_option
from sjdsl.doc import read_written, rule_sheet
from sjdsl.files import write_whole
from sjdsl.library.checked_game import split_variants


@click.command("doc")
@click.argument("game")
@variant_option
@click.option("-o", "output", metavar="FILE", help="Write to this file instead of printing.")
def command(game: str, variant: str | None, output: str | None) -> None:
    """Prints all the rules of GAME on a page, in the order of the ODD protocol for agent-based
    models (Grimm et al. 2020): tables of actions, numbers, sources and what agents see, and each
    rule as written, with its comments.

    GAME is a `.sj` file or a bundled game.
    """
    if output is not None:
        require_folder_of(Path(output))
    text = rule_sheet(read_written(open_game(game), split_variants(variant)))
    if output is None:
        click.echo(text, nl=False)
    else:
        write_whole(Path(output), text)
        click.echo(f"{output}  {len(text.splitlines())} lines")
