"""`sjdsl evaluate RUN --scenario NAME`: what a policy earns as focal agents among the scripted
policies of a game's scenarios."""

import re
from pathlib import Path

import click

from sjdsl.cli.environment_options import EnvironmentOptions
from sjdsl.cli.experiment_options import echo_files, prepare_environment, prepare_experiment
from sjdsl.cli.model_options import Asking, show_forecast
from sjdsl.cli.policies import warnings_as_notes
from sjdsl.cli.provenance import arguments_of_run
from sjdsl.library.tasks import replaced_tasks
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
    asking: Asking,
) -> None:
    """Plays a policy in scenarios, prints its scores, and writes `scenarios.json`.

    The file of the best policy of a run is `scenarios_best.json`.
    """
    path, which = split_name(policy)
    if output:
        folder = Path(output)
    elif path.is_dir():
        folder = path
    else:
        policy_words = re.sub(r"\W+", "_", Path(policy).name).strip("_")
        folder = Path(f"{Path(game or '').stem}_{policy_words}_scenarios")
    if game is None:
        arguments = replaced_tasks(arguments_of_run(path, OR_A_GAME), options.of_tasks)
        prepared = prepare_environment(folder, arguments)
    else:
        prepared = prepare_experiment(game, (policy,), folder, options)
    stem = "scenarios" if which == "last" else f"scenarios_{which}"
    names = [name.strip() for name in scenario.split(",")]
    with prepared as (env, say):
        from sjdsl.experiments.scenarios import plan_scenarios, play_planned
        from sjdsl.experiments.summaries import scenarios_text

        with warnings_as_notes():
            plan = plan_scenarios(env, policy, names, episodes, seed)
        show_forecast(plan.experiment, asking, folder / stem, plan.describe())
        results = play_planned(plan, folder, say, stem, asking.limits)
    click.echo(scenarios_text(results))
    echo_files(folder, (f"{stem}.json",))
