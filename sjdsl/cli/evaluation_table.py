"""The table of `sjdsl evaluate`: figures of whole episodes with their intervals, a column for each policy."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from sjdsl.runtime.env import Environment
    from sjdsl.trainers import Estimate


def echo_table(env: "Environment", columns: Mapping[str, "Mapping[str, Estimate]"], episodes: int, played: str = "") -> None:
    """Prints the figures of all agents, not of each, that a reader asks for. `columns`: by title; `played`: what, after the game's title."""
    undeclared = {f"{'final' if measure.mean else 'mean'} {measure.name}" for measure in env.game.measures}
    names = [name for name in next(iter(columns.values())) if name.startswith("return of") or " of agent " not in name]
    names = [name for name in names if name not in undeclared]
    shown = [("", *columns), *((name, *(interval(figures[name]) for figures in columns.values())) for name in names)]
    widths = [max(len(row[column]) for row in shown) for column in range(len(columns) + 1)]
    click.echo(f"\n{env.title or env.name}{played}: means of {episodes} episodes with their 95 % confidence intervals")
    for row in shown:
        click.echo("  " + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())


def interval(figure: "Estimate") -> str:
    """Returns `97.3 [95.1, 99.4]`; what some episode does not define has no mean."""
    if math.isnan(figure.mean):
        return "not defined"
    return f"{figure.mean:.4g} [{figure.low:.4g}, {figure.high:.4g}]"
