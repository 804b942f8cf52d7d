"""`sjdsl evaluate RUN --scenario NAME`: what a policy earns as focal agents among the scripted policies of a game's scenarios."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from sjdsl.cli.environment_options import EnvironmentOptions
from sjdsl.cli.experiment_options import echo_files, experiment, playing_in
from sjdsl.cli.policies import warnings_as_notes
from sjdsl.cli.provenance import provenance_of
from sjdsl.cli.stages import Say
from sjdsl.trainers.policy_names import split_name

if TYPE_CHECKING:
    from sjdsl.runtime.env import Environment

OR_A_GAME = ", or, for a policy that is no run, add --game GAME"


def evaluate_in_scenarios(
    policy: str, scenario: str, game: str | None, episodes: int, seed: int, output: str | None, options: EnvironmentOptions
) -> None:
    """Plays a policy in scenarios, prints its scores, and writes `scenarios.json`, or `scenarios_best.json` of the best policy."""
    path, which = split_name(policy)
    folder = Path(output) if output else path if path.is_dir() else Path(_folder_name(game, policy))
    name = "scenarios" if which == "last" else f"scenarios_{which}"
    with _playing(policy, game, folder, options) as (env, say):
        from sjdsl.experiments.scenarios import plan_scenarios, play_planned
        from sjdsl.experiments.summaries import scenarios_text

        with warnings_as_notes():
            planned = plan_scenarios(env, policy, [part.strip() for part in scenario.split(",")], episodes, seed)
        found = play_planned(planned, folder, say, name)
    click.echo(scenarios_text(found))
    echo_files(folder, (f"{name}.json",))


@contextmanager
def _playing(policy: str, game: str | None, folder: Path, options: EnvironmentOptions) -> Iterator[tuple["Environment", Say]]:
    """Yields the environment of --game, or else that of the run, and what says the stages."""
    if game is not None:
        with experiment(game, (policy,), folder, options) as both:
            yield both
        return
    provenance = provenance_of(split_name(policy)[0], OR_A_GAME)
    with playing_in(provenance, folder) as both:
        yield both


def _folder_name(game: str | None, policy: str) -> str:
    """Returns the folder of the results of a policy that is no run: `coins_cooperator_scenarios`."""
    words = re.sub(r"\W+", "_", Path(policy).name).strip("_")
    return f"{Path(game or '').stem}_{words}_scenarios"
