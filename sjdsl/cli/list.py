"""`sjdsl list`: a table of all bundled games."""

import shutil
import sys
from collections.abc import Iterable, Sequence

import click

from sjdsl.cli.game_file import open_game
from sjdsl.compiler import build_composition, ir
from sjdsl.compiler.compose import compose
from sjdsl.compiler.ir.queries import task_space
from sjdsl.library.games_folder import main_games, melting_pot_games

HEAD = ("game", "agents", "map", "actions", "title")


@click.command("list")
def command() -> None:
    """Lists the bundled games. `sjdsl doc GAME` prints everything about one of them."""
    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else None
    _echo_games(main_games(), width)
    click.echo("\nfurther games of Melting Pot")
    _echo_games(melting_pot_games(), width)
    click.echo(
        "\n`sjdsl doc GAME` prints its rules, actions, variants, parameters, sizes and metrics"
    )


def _echo_games(names: Iterable[str], width: int | None) -> None:
    """Prints a line for each game, cut at `width` columns of a terminal."""
    rows: list[tuple[str, ...]] = [HEAD]
    for name in names:
        composition = compose(open_game(name))
        game = build_composition(composition).game
        size = f"{len(game.rows)} x {len(game.rows[0])}"
        described = _describe(game, composition.variants)
        actions = str(len(game.agents.actions))
        rows.append((name, str(game.agents.number), size, actions, described))
    for line in align(rows):
        if width is not None and len(line) > width:
            line = f"{line[: width - 1]}…"
        click.echo(line)


def _describe(game: ir.Game, variants: Iterable[str]) -> str:
    """Returns the title of a game, how many tasks it has, and its variants."""
    parts = [game.title]
    if game.task is not None:
        parts.append(f"{task_space(game.task):,} tasks")
    names = ", ".join(variants)
    if names:
        parts.append(f"variants {names}")
    return "; ".join(parts)


def align(rows: Sequence[tuple[str, ...]]) -> list[str]:
    """Returns rows as lines with aligned columns of at most 48 characters; a wider cell sticks
    out.
    """
    widths = [min(48, max(len(cell) for cell in column)) for column in zip(*rows, strict=True)]
    lines = []
    for row in rows:
        cells = [cell.ljust(width) for cell, width in zip(row, widths, strict=True)]
        lines.append("  ".join(cells).rstrip())
    return lines
