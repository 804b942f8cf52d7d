"""`sjdsl list`: a table of all games, of each release that has some."""

from collections.abc import Sequence
from textwrap import wrap

import click

from sjdsl.cli.game_file import open_game
from sjdsl.compiler import build_composition
from sjdsl.compiler.compose import compose
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.library.games_folder import OURS, by_release, game_problems, melting_pot_games

WIDTH = 80  # columns of a terminal


@click.command("list")
def command() -> int:
    """Lists all games: bundled ones and those of installed packages. `sjdsl doc GAME` prints everything about one of them.

    Each package with games has a section of its own. Games with errors are reported at the end, and the exit status is then 1.
    """
    problems = game_problems()
    for line in _groups(problems):
        click.echo(line)
    click.echo("\n`sjdsl doc GAME` prints its rules, actions, parameters, sizes and metrics")
    for problem in problems:
        click.echo(f"error: {problem}", err=True)
    return int(bool(problems))


def _groups(problems: list[str]) -> list[str]:
    """Returns the table of all games, with a heading for each release, no line wider than a terminal.

    Games that don't compile are added to the problems.
    """
    own, *others = by_release().items()
    further = set(melting_pot_games())
    groups = {f"of {own[0]}": [name for name in own[1] if name.removeprefix(f"{OURS}:") not in further]}
    groups |= {f"of {own[0]}, further families of Melting Pot": [name for name in own[1] if name.removeprefix(f"{OURS}:") in further]}
    groups |= {f"of {release}": names for release, names in others}
    rows: dict[str, list[tuple[str, ...]]] = {title: [] for title in groups}
    variants: list[list[str]] = []  # of each game, below its row
    for title, names in groups.items():
        for name in names:
            try:
                composed = compose(open_game(name))
                game = build_composition(composed).game
            except CompileError as error:
                count = f"{len(error.diagnostics)} error{'s' * (len(error.diagnostics) > 1)}"
                problems.append(f"the game `{name}` has {count}; `sjdsl check {name}` shows what to change")
                continue
            rows[title].append((name, str(game.agents.number), f"{len(game.rows)} x {len(game.rows[0])}", str(len(game.agents.actions))))
            named = ", ".join(composed.variants)
            variants.append(wrap(named, WIDTH, initial_indent="    variants ", subsequent_indent=" " * 13))
    head, *lines = align([("game", "agents", "map", "actions"), *(row for found in rows.values() for row in found)])
    table, below = [head], zip(lines, variants, strict=True)
    for title, found in rows.items():
        table += ["", title] if found else []
        for _ in found:
            line, own_variants = next(below)
            table += [line, *own_variants]
    return table


def align(rows: Sequence[tuple[str, ...]]) -> list[str]:
    """Returns rows as lines with aligned columns; a very wide cell doesn't push the next column away."""
    widest = [min(48, max(len(cell) for cell in column)) for column in zip(*rows, strict=True)]
    return ["  ".join(cell.ljust(width) for cell, width in zip(row, widest, strict=True)).rstrip() for row in rows]
