"""The options of commands that train: what a run's configuration is made of."""

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import click

from sjdsl.cli.environment_options import read_texts
from sjdsl.cli.episode_options import SEED
from sjdsl.cli.policies import check_policy, code_option

if TYPE_CHECKING:
    from sjdsl.compiler import ir
    from sjdsl.trainers import Config
    from sjdsl.trainers.runs.loggers import LoggerName

Command = Callable[..., Any]
ALGORITHMS = ("ippo", "mappo", "vdn")
REWARDS = ("individual", "common", "svo", "exchange", "inequity")


@dataclass(frozen=True)
class RunOptions:
    """The values of the options of a run."""

    preset: str | None
    changes: Mapping[str, str]  # --set
    named: Mapping[str, Any]  # settings with an option of their own
    loggers: "tuple[LoggerName, ...]"

    @property
    def settings(self) -> dict[str, Any]:
        """The settings on the command line, as written there; the configuration interprets them."""
        return {**self.changes, **self.named}


def run_options(seeds: int | None = None) -> Callable[[Command], Command]:
    """Returns a decorator that adds the options of a run; the command gets them together as `run`.

    seeds: the default of --seeds.
    """
    options = (
        click.option(
            "--preset",
            metavar="P",
            help="Settings to start from: two_cores (minutes on a CPU), paper, released, overnight, "
            "rl2 or FILE.toml.",
        ),
        click.option(
            "--algorithm", metavar="A", help=f"Learn by {', '.join(ALGORITHMS)} or FILE.py:NAME."
        ),
        click.option(
            "--reward", metavar="R", help=f"Learn from {', '.join(REWARDS)} or FILE.py:NAME."
        ),
        click.option(
            "--set",
            "changes",
            multiple=True,
            metavar="NAME=VALUE",
            help="A setting; `sjdsl train --keys` lists them all.",
        ),
        click.option("--seed", type=SEED, metavar="N", help="The first seed.  [default: 0]"),
        click.option(
            "--seeds",
            type=click.IntRange(min=1),
            default=seeds,
            show_default=True,
            metavar="K",
            help="Train K seeds side by side.",
        ),
        click.option(
            "--init-from", metavar="POLICY", help="Start with RUN, RUN@best or FILE.safetensors."
        ),
        click.option(
            "--partners",
            multiple=True,
            metavar="AGENT=POLICY",
            help="Agents that don't learn: 1=random, 1,2=RUN@best.",
        ),
        code_option,
        click.option(
            "--log",
            "loggers",
            multiple=True,
            type=click.Choice(["tensorboard", "wandb"]),
            help="Log metrics there too.",
        ),
    )

    def add(command: Command) -> Command:
        @functools.wraps(command)
        def with_run(
            *,
            preset: str | None,
            changes: tuple[str, ...],
            loggers: Any,
            partners: tuple[str, ...],
            **others: Any,
        ) -> Any:
            """Calls the command with what the options say of a run."""
            settings = {
                name: others.pop(name)
                for name in ("algorithm", "reward", "seed", "seeds", "init_from")
            }
            settings["partners"] = ",".join(partners) or None
            named = {name: value for name, value in settings.items() if value is not None}
            return command(run=RunOptions(preset, read_texts(changes), named, loggers), **others)

        decorated: Command = with_run
        for option in reversed(options):  # the last one added comes first in the help
            decorated = option(decorated)
        return decorated

    return add


def check_policies(config: "Config", game: "ir.Game") -> None:
    """Raises ClickException for a text in a configuration that can't name a policy of the game."""
    if config.init_from:
        check_policy(config.init_from, game)
    for _, policy in config.partners:
        check_policy(policy, game)
