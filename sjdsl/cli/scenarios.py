"""`sjdsl evaluate RUN --scenario NAME`: what a policy earns as focal agents among the scripted policies of a game's scenarios."""

import re
from pathlib import Path

import click

from sjdsl.cli.environment_options import EnvironmentOptions
from sjdsl.cli.experiment_options import echo_files, experiment, playing_in
from sjdsl.cli.policies import warnings_as_notes
from sjdsl.cli.provenance import provenance_of
from sjdsl.trainers.settings.policy_names import split_name

OR_A_GAME = ", or add --game GAME for a policy that isn't a run"


def evaluate_in_scenarios(
    policy: str,
    scenario: str,
    game: str | None,
    episodes: int,
    seed: int,
    output: str | None,
    options: EnvironmentOptions,
) -> None:
    """Plays a policy in scenarios, prints its scores, and writes `scenarios.json`, or `scenarios_best.json` of the best policy."""
    path, which = split_name(policy)
    words = re.sub(r"\W+", "_", Path(policy).name).strip("_")
    folder = (
        Path(output)
        if output
        else path
        if path.is_dir()
        else Path(f"{Path(game or '').stem}_{words}_scenarios")
    )
    name = "scenarios" if which == "last" else f"scenarios_{which}"
    playing = (
        playing_in(provenance_of(path, OR_A_GAME), folder)
        if game is None
        else experiment(game, (policy,), folder, options)
    )
    with playing as (env, say):
        from sjdsl.experiments.scenarios import plan_scenarios, play_planned
        from sjdsl.experiments.summaries import scenarios_text

        with warnings_as_notes():
            planned = plan_scenarios(
                env, policy, [part.strip() for part in scenario.split(",")], episodes, seed
            )
        found = play_planned(planned, folder, say, name)
    click.echo(scenarios_text(found))
    echo_files(folder, (f"{name}.json",))
