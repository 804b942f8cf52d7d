"""The options of commands that play episodes: how many, and with which random numbers."""

from collections.abc import Callable
from typing import Any

import click

Command = Callable[..., Any]
# JAX makes keys from the lower 32 bits, so a larger seed would repeat one of these.
SEED = click.IntRange(0, 2**32 - 1)
SEED_OF_FIRST = "Seed of the first episode; then N + 1, N + 2, …."


def seed_option(help: str) -> Callable[[Command], Command]:
    """Adds --seed with the default 0."""
    return click.option("--seed", type=SEED, metavar="N", default=0, show_default=True, help=help)


def episodes_option(default: int, help: str) -> Callable[[Command], Command]:
    """Adds --episodes."""
    return click.option(
        "--episodes",
        type=click.IntRange(min=1),
        metavar="N",
        default=default,
        show_default=True,
        help=help,
    )
