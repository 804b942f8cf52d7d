"""`sjdsl schelling`: what cooperators and defectors earn together, and whether the game is a
dilemma for them."""

from pathlib import Path

import click

from sjdsl.cli.environment_options import EnvironmentOptions
from sjdsl.cli.experiment_options import echo_files, experiment_options, prepare_experiment
from sjdsl.cli.model_options import Asking, show_forecast
from sjdsl.cli.policies import NAMES, warnings_as_notes
from sjdsl.extras import require

FILES = ("schelling.json", "schelling.png", "schelling.svg")


@click.command("schelling")
@click.argument("game")
@click.option("--cooperators", required=True, metavar="P", help=f"The cooperators' policy: {NAMES}")
@click.option("--defectors", required=True, metavar="P", help="The defectors' policy.")
@experiment_options
def command(
    game: str,
    cooperators: str,
    defectors: str,
    episodes: int,
    seed: int,
    output: str | None,
    options: EnvironmentOptions,
    asking: Asking,
) -> None:
    """Plays GAME with k cooperators and N - k defectors, for k = 0 .. N, and says whether it is a
    dilemma for them, at 95 %.

    A RUN of several seeds is a pool: seed i of one plays with seed i of the other, and the
    intervals are over seeds.
    """
    require("plots", "matplotlib")
    folder = Path(output or f"{Path(game).stem}_schelling")
    with prepare_experiment(game, (cooperators, defectors), folder, options) as (env, say):
        from sjdsl.experiments.schelling import describe_diagram, plan_diagram, play_diagram
        from sjdsl.experiments.summaries import diagram_text

        with warnings_as_notes():
            plan = plan_diagram(env, cooperators, defectors, episodes, seed)
        show_forecast(plan, asking, folder, describe_diagram(plan))
        diagram = play_diagram(plan, folder, say, asking.limits)
    click.echo(diagram_text(diagram))
    echo_files(folder, FILES)
