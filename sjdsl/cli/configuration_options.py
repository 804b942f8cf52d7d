"""The options of commands that train: what a configuration is made of."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

from sjdsl.cli.environment_options import SEED, refuse_second
from sjdsl.cli.policies import check_policy, code_option

if TYPE_CHECKING:
    from sjdsl.compiler import ir
    from sjdsl.trainers import Config

Command = Callable[..., Any]
ALGORITHMS = ("ippo", "mappo", "irat", "vdn")
REWARDS = ("individual", "common", "svo", "exchange", "inequity")


def configuration_options(command: Command) -> Command:
    """Adds --algorithm, --reward, --preset, --set, --seed, --init-from, --partners and --allow-code; `--set` arrives as `changes`."""
    options = (
        click.option(
            "--algorithm",
            metavar="A",
            help=f"How to learn: {', '.join(ALGORITHMS)}, or FILE.py:FUNCTION; ippo unless the preset has another.",
        ),
        click.option(
            "--reward",
            metavar="R",
            help=f"Reward to learn from: {', '.join(REWARDS)}, or FILE.py:FUNCTION. Unless the preset has another, each agent learns from its "
            "own (individual), and with vdn all from the common one.",
        ),
        click.option(
            "--preset",
            metavar="P",
            help="Values to begin with: paper, released, two_cores, overnight, quick, or a .toml file, which may name the game.",
        ),
        click.option(
            "--set",
            "changes",
            multiple=True,
            metavar="NAME=VALUE",
            help="A value of the configuration, such as total_timesteps=1e6; `sjdsl train --keys` lists them. own.NAME=VALUE is a setting "
            "that code of your own takes.",
        ),
        click.option("--seed", type=SEED, metavar="N", help="Seed of the run, of several the first: 0 unless the preset has another."),
        click.option(
            "--init-from",
            metavar="POLICY",
            help="Start with the parameters of a policy: RUN, RUN@best, RUN@UPDATE or a .safetensors file.",
        ),
        click.option(
            "--partners",
            multiple=True,
            metavar="AGENT=POLICY",
            help="Agents that act by a policy and do not learn, such as 1=random or 1,2=RUN@best.",
        ),
        code_option,
    )
    for option in reversed(options):
        command = option(command)
    return command


def log_option(command: Command) -> Command:
    """Adds --log, which arrives as `loggers`."""
    return click.option(
        "--log",
        "loggers",
        multiple=True,
        type=click.Choice(["tensorboard", "wandb"]),
        help="Where metrics go besides files; a run that is resumed keeps its own.",
    )(command)


def read_configuration(
    algorithm: str | None, reward: str | None, seed: int | None, seeds: int | None, init_from: str | None, partners: tuple[str, ...]
) -> dict[str, Any]:
    """Returns the keys of the configuration that the options give, with their values."""
    given: dict[str, Any] = {"algorithm": algorithm, "reward": reward, "seed": seed, "seeds": seeds, "init_from": init_from}
    given["partners"] = ",".join(partners) or None
    return {name: value for name, value in given.items() if value is not None}


def read_texts(given: tuple[str, ...]) -> dict[str, str]:
    """Returns `name=value` as a mapping of texts: the configuration knows what they mean."""
    pairs = [text.partition("=") for text in given]
    for text, (name, equals, _) in zip(given, pairs, strict=True):
        if not equals or not name:
            raise click.UsageError(f"`{text}` must have the form name=value", click.get_current_context(silent=True))
    values: dict[str, str] = {}
    for name, _, value in pairs:
        if name.strip() in values:
            refuse_second(name.strip())
        values[name.strip()] = value.strip()
    return values


def check_policies(config: "Config", game: "ir.Game") -> None:
    """Raises ClickException for what a configuration names as a policy and what cannot be one."""
    for named in filter(None, (config.init_from, *(policy for _, policy in config.partners))):
        check_policy(named, game)
