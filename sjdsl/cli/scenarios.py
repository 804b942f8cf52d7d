"""`sjdsl evaluate RUN --scenario NAME`: what a policy earns as focal agents among the scripted policies of a game's scenarios."""

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sjdsl.cli.environment_options import environment_options
from sjdsl.cli.experiment_options import echo_files, experiment, playing_in
from sjdsl.cli.policies import warnings_as_notes
from sjdsl.cli.provenance import provenance_of
from sjdsl.cli.stages import Say
from sjdsl.trainers.policy_names import split_name

if TYPE_CHECKING:
    from sjdsl.runtime.env import Environment

Command = Callable[..., Any]
OR_A_GAME = ", or, for a policy that is no run, add --game GAME"


def scenario_options(command: Command) -> Command:
    """Adds --scenario, --game, -o and the options of an environment; they arrive as `scenario`, `game`, `output` and those of one."""
    scenario = click.option(
        "--scenario", metavar="NAME|all", help="Play RUN as the focal agents of a scenario of the game's file, of several (A,B), or of all."
    )
    game = click.option(
        "--game",
        metavar="GAME",
        help="The game that a POLICY plays in, which is no run; with --scenario also for RUN in another form of its game.",
    )
    output = click.option(
        "-o",
        "output",
        metavar="FILE|DIR",
        help="The .json file for the figures of a POLICY; the folder for the results of scenarios, that of RUN unless given.",
    )
    return scenario(game(output(environment_options(command))))


def check_scenario_options(scenario: str | None, game: str | None, output: str | None, described: Mapping[str, Any]) -> None:
    """Raises UsageError for options that mean nothing without --scenario or --game."""
    context = click.get_current_context(silent=True)
    names = {"variant": "--variant", "map_file": "--map", "agents": "--agents", "params": "--param"}
    given = [names[name] for name, value in described.items() if value not in (None, ())]
    if game is not None:
        return
    if scenario is None and output:
        raise click.UsageError("-o is for --scenario and --game; without them the figures of a run are written to its folder", context)
    if given:
        raise click.UsageError(f"{given[0]} is for --game; without it a run plays in the game that it was trained in", context)


def evaluate_in_scenarios(
    policy: str, scenario: str, game: str | None, episodes: int, seed: int, output: str | None, described: dict[str, Any]
) -> None:
    """Plays a policy in scenarios, prints its scores, and writes `scenarios.json`, or `scenarios_best.json` of the best policy."""
    path, which = split_name(policy)
    folder = Path(output) if output else path if path.is_dir() else Path(_folder_name(game, policy))
    name = "scenarios" if which == "last" else f"scenarios_{which}"
    with _playing(policy, game, folder, described) as (env, say):
        from sjdsl.experiments.scenarios import plan_scenarios, play_planned
        from sjdsl.experiments.summaries import scenarios_text

        with warnings_as_notes():
            planned = plan_scenarios(env, policy, [part.strip() for part in scenario.split(",")], episodes, seed)
        found = play_planned(planned, folder, say, name)
    click.echo(scenarios_text(found))
    echo_files(folder, (f"{name}.json",))


@contextmanager
def _playing(policy: str, game: str | None, folder: Path, described: dict[str, Any]) -> Iterator[tuple["Environment", Say]]:
    """Yields the environment of --game, or else that of the run, and what says the stages."""
    if game is not None:
        with experiment(game, (policy,), folder, described) as both:
            yield both
        return
    provenance = provenance_of(split_name(policy)[0], OR_A_GAME)
    with playing_in(provenance, folder) as both:
        yield both


def _folder_name(game: str | None, policy: str) -> str:
    """Returns the folder of the results of a policy that is no run: `coins_cooperator_scenarios`."""
    words = re.sub(r"\W+", "_", Path(policy).name).strip("_")
    return f"{Path(game or '').stem}_{words}_scenarios"
