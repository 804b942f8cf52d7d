"""`sjdsl list`: a table of all bundled games."""

from collections.abc import Iterable, Iterator, Sequence
from textwrap import fill

import click

from sjdsl.cli.game_file import open_game
from sjdsl.compiler import build_composition, ir
from sjdsl.compiler.compose import compose
from sjdsl.compiler.ir.queries import task_space
from sjdsl.library.games_folder import main_games, melting_pot_games

WIDTH = 80  # columns of a terminal


@click.command("list")
def command() -> None:
    """Lists the bundled games. `sjdsl doc GAME` prints everything about one of them."""
    rows: list[tuple[str, ...]] = [("game", "agents", "map", "actions")]
    notes: list[str] = []  # of each game: how many tasks it has, and its variants
    for name in (*main_games(), *melting_pot_games()):
        composition = compose(open_game(name))
        game = build_composition(composition).game
        size = f"{len(game.rows)} x {len(game.rows[0])}"
        rows.append((name, str(game.agents.number), size, str(len(game.agents.actions))))
        notes.append("\n".join(_notes(game, composition.variants)))
    head, *lines = align(rows)
    click.echo(head)
    for number, (line, note) in enumerate(zip(lines, notes, strict=True)):
        if number == len(main_games()):
            click.echo("\nfurther families of Melting Pot")
        click.echo(line)
        if note:
            click.echo(note)
    click.echo("\n`sjdsl doc GAME` prints its rules, actions, parameters, sizes and metrics")


def _notes(game: ir.Game, variants: Iterable[str]) -> Iterator[str]:
    """Yields the lines below a game."""
    if game.task is not None:
        yield f"    tasks    {task_space(game.task):,}"
    names = ", ".join(variants)
    if names:
        yield fill(names, WIDTH, initial_indent="    variants ", subsequent_indent=" " * 13)


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
