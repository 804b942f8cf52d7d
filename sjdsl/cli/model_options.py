"""The options of commands in which language models may play, and what a dry run prints."""

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sjdsl.models import Limits
from sjdsl.models.account import check_price
from sjdsl.models.asking import PARALLEL

if TYPE_CHECKING:
    from sjdsl.experiments.playing import Experiment

Command = Callable[..., Any]
MANY_CALLS = 1000  # before which a forecast is printed


@dataclass(frozen=True)
class Asking:
    """How models are asked.

    dry_run: they aren't, and what they would be asked is printed; status: what they were asked is.
    """

    limits: Limits
    dry_run: bool = False
    status: bool = False


def limit_options(command: Command) -> Command:
    """Adds the options of limits; the command gets them together as `limits`."""

    @functools.wraps(command)
    def with_limits(
        *, parallel: int, budget: float | None, calls: int | None, **others: Any
    ) -> Any:
        """Calls the command with the options in one object."""
        return command(limits=Limits(parallel, budget, calls), **others)

    parallel_option = click.option(
        "--parallel",
        type=click.IntRange(min=1),
        metavar="N",
        default=PARALLEL,
        show_default=True,
        help="Language models: the most calls at once.",
    )
    budget_option = click.option(
        "--budget",
        type=click.FloatRange(min=0),
        metavar="DOLLARS",
        help="Language models: stop before more is spent, earlier runs of the folder included.",
    )
    calls_option = click.option(
        "--calls",
        type=click.IntRange(min=0),
        metavar="N",
        help="Language models: stop before there are more calls, earlier runs included.",
    )
    return parallel_option(budget_option(calls_option(with_limits)))


def model_options(command: Command) -> Command:
    """Adds the options of experiments with models; the command gets them together as `asking`."""

    @functools.wraps(command)
    def with_asking(*, limits: Limits, dry_run: bool, status: bool, **others: Any) -> Any:
        """Calls the command with the options in one object."""
        return command(asking=Asking(limits, dry_run, status), **others)

    dry_run_option = click.option(
        "--dry-run", is_flag=True, help="Language models: print what they would cost; ask none."
    )
    status_option = click.option(
        "--status", is_flag=True, help="Language models: print what they have been asked so far."
    )
    return limit_options(dry_run_option(status_option(with_asking)))


def show_forecast(
    experiment: "Experiment", asking: Asking, folder: Path, description: Mapping[str, Any]
) -> None:
    """Prints what the models of an experiment are asked, if it is much; a dry run ends then, and so
    does one that only prints what they have been asked in a folder.

    description: everything that the results in the folder depend on.

    Raises UsageError for options about models in an experiment without one, ModelError for a budget
    without a price, and ExperimentError if what they have been asked is wanted of a folder that
    holds another experiment.
    """
    limits = asking.limits
    if not experiment.hosts:
        if asking.dry_run or asking.status or limits.budget is not None or limits.calls is not None:
            raise click.UsageError(
                "--budget, --calls, --dry-run and --status are for language models, and none plays"
            )
        return
    from sjdsl.experiments.usage import forecasts, status_text

    if asking.status:
        click.echo(status_text(experiment, folder, description))
        raise click.exceptions.Exit(0)
    for pool in experiment.hosts:
        for player in pool.players:
            assert player.host is not None
            check_price(player.host, limits)
    of_models = forecasts(experiment)
    calls = sum(forecast.calls for forecast in of_models.values())
    if asking.dry_run or calls > MANY_CALLS:
        for name, forecast in of_models.items():
            click.echo(f"{name}: {forecast.text()}", err=not asking.dry_run)
    if asking.dry_run:
        raise click.exceptions.Exit(0)
