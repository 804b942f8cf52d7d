"""`sjdsl bench --training`: an update of training, by network, algorithm and sharing of parameters; hours extrapolated from it."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from sjdsl.cli.bench_options import ALGORITHMS, NETWORKS, SHARINGS, Steps, Words, flat

if TYPE_CHECKING:
    from sjdsl.bench import Task, Training

Command = Callable[..., Any]


class Asked(NamedTuple):
    """What was asked of training: empty where nothing was said."""

    networks: tuple[Any, ...]
    algorithms: tuple[Any, ...]
    sharings: tuple[Any, ...]
    hours: int | None

    def check(self, stored: bool) -> None:
        """Raises UsageError for options of training without it, and for what no algorithm has."""
        context = click.get_current_context(silent=True)
        if (self.algorithms or self.sharings) and not self.networks:
            raise click.UsageError("--algorithm and --sharing are of --training: say its networks, such as --training mlp", context)
        if self.hours is not None and not self.networks and not stored:
            raise click.UsageError("--hours are extrapolated from updates of training: say --training mlp, or --from a file of it", context)
        if "vdn" in self.algorithms and "shared" not in (self.sharings or ("shared",)):
            raise click.UsageError("vdn has one network for all agents: add shared to --sharing, or leave vdn out", context)


def training_options(command: Command) -> Command:
    """Adds --training, --algorithm, --sharing and --hours; they arrive together, as `training`."""
    options = (
        click.option(
            "--training", "networks", type=Words(NETWORKS), metavar="NETWORKS", help="Instead: updates of training: mlp, cnn or mlp,cnn."
        ),
        click.option(
            "--algorithm",
            "algorithms",
            type=Words(ALGORITHMS),
            multiple=True,
            metavar="NAMES",
            help="Of training: ippo (the default), mappo, vdn, or several: ippo,mappo,vdn.",
        ),
        click.option(
            "--sharing",
            "sharings",
            type=Words(SHARINGS),
            multiple=True,
            metavar="NAMES",
            help="Of training: which agents have one network: shared (the default), per_agent, by_role, or several.",
        ),
        click.option(
            "--hours", type=Steps(), metavar="STEPS", help="Of training: the hours to so many environment steps, extrapolated: 1e9."
        ),
    )
    for option in reversed(options):
        command = option(command)
    return command


def asked_of(options: dict[str, Any]) -> Asked:
    """Takes the options of training out of a command's."""
    networks, hours = options.pop("networks") or (), options.pop("hours")
    return Asked(networks, flat(options.pop("algorithms")), flat(options.pop("sharings")), hours)


def plan_training(
    asked: Asked,
    tasks: "Sequence[Task]",
    num_envs: int | None,
    num_steps: int | None,
    repeats: int,
    keep: "Callable[[Training], None]",
) -> "tuple[str, Callable[[Callable[[str], object]], Training]]":
    """Returns the section of a page and the measurement. Raises ClickException, now or when measuring, where nothing can be measured."""
    from sjdsl.bench import measure_training, training_setups

    envs = [(task.name, task.env) for task in tasks if task.env is not None]
    learners = asked.algorithms or ("ippo",), asked.sharings or ("shared",)
    setups, refused = training_setups(envs, asked.networks, *learners, num_envs, num_steps)

    def measured(tell: Callable[[str], object]) -> "Training":
        found = measure_training(setups, repeats, tell, asked.hours, refused, keep)
        if not found.splits:
            raise click.ClickException("; ".join(found.left_out))
        return found

    if not setups:
        raise click.ClickException("; ".join(refused))
    return training_section([(setup.network, *setup.learning) for setup in setups]), measured


def training_section(learnt: "Sequence[tuple[str, str, str]]") -> str:
    """Returns the marks on a page of updates by (network, algorithm, sharing): `training mlp`; of others than IPPO with shared networks
    `training mlp ippo,mappo shared`."""
    if not learnt:
        return "training"
    networks, algorithms, sharings = (tuple(dict.fromkeys(words)) for words in zip(*learnt, strict=True))
    what = f"training {','.join(networks)}"
    return what if (algorithms, sharings) == (("ippo",), ("shared",)) else f"{what} {','.join(algorithms)} {','.join(sharings)}"


def with_hours(found: Any, env_steps: int | None) -> Any:
    """Returns figures that were measured before; those of training with the hours to so many environment steps, unless it is None."""
    from dataclasses import replace

    from sjdsl.bench.extrapolation import hours_to

    if env_steps is None or not hasattr(found, "splits"):
        return found
    return replace(found, hours_to=env_steps, hours=hours_to(env_steps, found.splits))
