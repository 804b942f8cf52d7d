"""`sjdsl list`: a table of all bundled games."""

from collections.abc import Sequence
from textwrap import fill

import click

from sjdsl.cli.game_file import open_game
from sjdsl.compiler import build_composition
from sjdsl.compiler.compose import compose
from sjdsl.library.games_folder import main_games, melting_pot_games

WIDTH = 80  # columns of a terminal


@click.command("list")
def command() -> None:
    """Lists the bundled games. `sjdsl doc GAME` prints everything about one of them."""
    rows: list[tuple[str, ...]] = [("game", "agents", "map", "actions")]
    variants: list[str] = []  # the variants of each game
    for name in (*main_games(), *melting_pot_games()):
        composition = compose(open_game(name))
        game = build_composition(composition).game
        size = f"{len(game.rows)} x {len(game.rows[0])}"
        rows.append((name, str(game.agents.number), size, str(len(game.agents.actions))))
        variants.append(", ".join(composition.variants))
    head, *lines = align(rows)
    click.echo(head)
    for number, (line, names) in enumerate(zip(lines, variants, strict=True)):
        if number == len(main_games()):
            click.echo("\nfurther families of Melting Pot")
        click.echo(line)
        if names:
            click.echo(
                fill(names, WIDTH, initial_indent="    variants ", subsequent_indent=" " * 13)
            )
    click.echo("\n`sjdsl doc GAME` prints its rules, actions, parameters, sizes and metrics")


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
