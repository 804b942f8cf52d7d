"""The options of commands that play policies with each other, and the environment they play in."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sjdsl.cli.environment_options import (
    EnvironmentOptions,
    environment_options,
    make_environment,
)
from sjdsl.cli.episode_options import episodes_option, seed_option
from sjdsl.cli.folders import require_writable
from sjdsl.cli.model_options import model_options
from sjdsl.cli.policies import check_policy, code_option
from sjdsl.cli.stages import LOADING, Say, stages

if TYPE_CHECKING:
    from sjdsl.runtime.env import Environment

Command = Callable[..., Any]


def experiment_options(command: Command) -> Command:
    """Adds --episodes, --seed, -o (as `output`) and --allow-code, and the options of an
    environment and of models.
    """
    output = click.option(
        "-o",
        "output",
        metavar="DIR",
        help="Folder of the results; by default GAME_ and the command's name.",
    )
    seed = seed_option("Seed of the episodes.")
    episodes = episodes_option(30, "Episodes of each line-up.")
    return episodes(seed(output(code_option(environment_options(model_options(command))))))


@contextmanager
def prepare_experiment(
    game: str, policies: Sequence[str], folder: Path, options: EnvironmentOptions
) -> Iterator[tuple["Environment", Say]]:
    """Yields the environment of a command and a function that announces stages.

    The options and the names of policies are checked before JAX loads, as far as possible.
    """
    rules = options.check(game)
    for policy in policies:
        check_policy(policy, rules)
    with prepare_environment(folder, options.describe(game)) as env_and_say:
        yield env_and_say


@contextmanager
def prepare_environment(
    folder: Path, arguments: Mapping[str, Any]
) -> Iterator[tuple["Environment", Say]]:
    """Yields the environment of these arguments and a function that announces stages.

    Raises ClickException if nothing can be written to the folder.
    """
    require_writable(folder)
    with stages(LOADING) as say:
        yield make_environment(arguments), say


def echo_files(folder: Path, names: Sequence[str]) -> None:
    """Prints those of the files that exist in one line."""
    written = [name for name in names if (folder / name).is_file()]
    click.echo(f"\n{folder}/: {', '.join(written)}")
