"""Opens the game that a command line names: a bundled one, or any `.sj` file."""

from pathlib import Path

import click

from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.read import read_source
from sjdsl.library.games_folder import find_game


def open_game(name: str) -> Source:
    """Returns the text of a game.

    Raises ClickException for an unknown name, CompileError for an unreadable file.
    """
    return read_source(game_path(name))


def game_path(name: str) -> Path:
    """Returns the file of a game, relative to the current folder if it is inside it."""
    try:
        path = find_game(name)
    except FileNotFoundError as error:
        raise click.ClickException(str(error)) from None
    return path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path


variant_option = click.option(
    "--variant", metavar="V", help="A variant of the game; several as a+b."
)
agents_option = click.option(
    "--agents", type=click.IntRange(min=1), metavar="N", help="The number of agents."
)
map_option = click.option(
    "--map", "map_file", metavar="FILE", help="Another map, drawn with the game's glyphs."
)
