"""Opens the game that a command line names: a bundled one, one of an installed package, or any `.sj` file."""

from pathlib import Path

import click

from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.elaborate import Overrides
from sjdsl.compiler.elaborate.world_map import parse_file
from sjdsl.compiler.syntax.read import read_source
from sjdsl.games_folder import GamesClash, find_game


def open_game(name: str) -> Source:
    """Returns the text of a game. Raises ClickException for an unknown name, CompileError for an unreadable file."""
    return read_source(game_path(name))


def game_path(name: str) -> Path:
    """Returns the file of a game, relative to this folder if it is inside it."""
    try:
        path = find_game(name)
    except (FileNotFoundError, GamesClash) as error:
        raise click.ClickException(str(error)) from None
    return path.relative_to(Path.cwd()) if path.is_absolute() and path.is_relative_to(Path.cwd()) else path


def split_variants(text: str | None) -> tuple[str, ...]:
    """Returns the variants of `a+b`, left to right."""
    return tuple(text.split("+")) if text else ()


def read_map(file: str | None, source: Source) -> Overrides:
    """Returns the rows of a map file as overrides; none without a file. Raises CompileError for a file that isn't a map."""
    if file is None:
        return Overrides()
    path = Path(file)
    if not path.is_file():
        raise click.ClickException(f"there is no map file `{file}`")
    problems = Problems()
    rows, spans = parse_file(path, file, source.span(0, 0), problems)
    if problems.found:
        raise CompileError(problems.found)
    return Overrides(rows=rows, row_spans=spans)


variant_option = click.option("--variant", metavar="V", help="A variant of the game; several as a+b.")
map_option = click.option("--map", "map_file", metavar="FILE", help="Another map, drawn with the game's glyphs.")
