"""`sjdsl list`: a table of all bundled games."""

from collections.abc import Sequence
from textwrap import wrap

import click

from sjdsl.cli.game_file import open_game
from sjdsl.compiler import build_composition
from sjdsl.compiler.compose import compose
from sjdsl.library.games_folder import main_games, melting_pot_games

WIDTH = 80  # columns of a terminal


@click.command("list")
def command() -> None:
    """Lists the bundled games. `sjdsl doc GAME` prints everything about one of them."""
    rows: list[tuple[str, ...]] = []
    variants: list[list[str]] = []  # of each game, the lines below its row
    for name in (*main_games(), *melting_pot_games()):
        composed = compose(open_game(name))
        game = build_composition(composed).game
        rows.append(
            (
                name,
                str(game.agents.number),
                f"{len(game.rows)} x {len(game.rows[0])}",
                str(len(game.agents.actions)),
            )
        )
        named = ", ".join(composed.variants)
        variants.append(
            wrap(named, WIDTH, initial_indent="    variants ", subsequent_indent=" " * 13)
        )
    head, *lines = align([("game", "agents", "map", "actions"), *rows])
    click.echo(head)
    for number, (line, own_variants) in enumerate(zip(lines, variants, strict=True)):
        if number == len(main_games()):
            click.echo("\nfurther families of Melting Pot")
        click.echo("\n".join([line, *own_variants]))
    click.echo("\n`sjdsl doc GAME` prints its rules, actions, parameters, sizes and metrics")


def align(rows: Sequence[tuple[str, ...]]) -> list[str]:
    """Returns rows as lines with aligned columns; a very wide cell doesn't push the next column away."""
    widest = [min(48, max(len(cell) for cell in column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widest, strict=True)).rstrip()
        for row in rows
    ]
