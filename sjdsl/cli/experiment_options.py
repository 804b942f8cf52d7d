"""The options of commands that play policies with each other, and the environment they play in."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sjdsl.cli.environment_options import (
    SEED,
    EnvironmentOptions,
    environment_options,
    make_environment,
)
from sjdsl.cli.folders import require_writable
from sjdsl.cli.policies import check_policy, code_option
from sjdsl.cli.stages import LOADING, Say, stages

if TYPE_CHECKING:
    from sjdsl.runtime.env import Environment

Command = Callable[..., Any]


def experiment_options(command: Command) -> Command:
    """Adds --episodes, --seed, -o (as `output`) and --allow-code, and the options of an environment."""
    output = click.option(
        "-o",
        "output",
        metavar="DIR",
        help="Folder of the results; by default GAME_ and the command's name.",
    )
    seed = click.option(
        "--seed", type=SEED, metavar="N", default=0, show_default=True, help="Seed of the episodes."
    )
    episodes = click.option(
        "--episodes",
        type=click.IntRange(min=1),
        metavar="N",
        default=30,
        show_default=True,
        help="Episodes of each line-up.",
    )
    return episodes(seed(output(code_option(environment_options(command)))))


@contextmanager
def experiment(
    game: str, policies: Sequence[str], folder: Path, options: EnvironmentOptions
) -> Iterator[tuple["Environment", Say]]:
    """Yields the environment of a command and a function that announces stages; checks what it can before JAX loads."""
    checked = options.check(game)
    for policy in policies:
        check_policy(policy, checked)
    with playing_in(options.describe(game), folder) as both:
        yield both


@contextmanager
def playing_in(arguments: Mapping[str, Any], folder: Path) -> Iterator[tuple["Environment", Say]]:
    """Yields the environment of these arguments and a function that announces stages."""
    require_writable(folder)
    with stages(LOADING) as say:
        yield make_environment(arguments), say


def echo_files(folder: Path, names: Sequence[str]) -> None:
    """Prints where the results are."""
    click.echo("\n" + "\n".join(f"{folder / name}" for name in names if (folder / name).is_file()))
