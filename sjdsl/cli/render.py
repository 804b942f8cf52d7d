"""`sjdsl render`: writes a game as a film or a page, or one moment of it as a picture."""

from pathlib import Path
from typing import Any

import click

from sjdsl.cli.environment_options import (
    SEED,
    check_environment,
    describe_environment,
    environment_options,
    make_environment,
    read_assignments,
)
from sjdsl.cli.film import PAGE, check_film, save_film, told
from sjdsl.cli.folders import require_folder_of
from sjdsl.cli.policies import check_policy, choose_policy, code_option, policy_option
from sjdsl.cli.stages import LOADING, stages


@click.command("render")
@click.argument("game")
@click.option(
    "-o",
    "output",
    metavar="FILE",
    help="The file to write: a .gif or .mp4, an .html page that plays in a browser, or a .png of the last step; by default GAME.gif.",
)
@click.option("--steps", type=click.IntRange(min=0), metavar="N", default=100, show_default=True, help="Steps to play.")
@click.option(
    "--every", type=click.IntRange(min=1), metavar="N", default=1, show_default=True, help="Draw one step of every N; a page has them all."
)
@policy_option
@code_option
@click.option("--seed", type=SEED, metavar="N", default=0, show_default=True, help="Seed of the episode.")
@click.option("--speed", type=click.FloatRange(min=0.5, max=50), metavar="N", default=8.0, show_default=True, help="Frames a second.")
@environment_options
def command(game: str, output: str | None, steps: int, every: int, policy: str, seed: int, speed: float, **described: Any) -> None:
    """Plays GAME, a bundled or installed one or a `.sj` file, and draws what happens."""
    path = Path(output or f"{Path(game).stem}.gif")
    if path.suffix != ".png":
        check_film(path)
    if path.suffix == PAGE and every > 1:
        raise click.UsageError("an .html page holds every step: leave out --every", click.get_current_context(silent=True))
    described["params"] = read_assignments(described["params"])
    check_policy(policy, check_environment(game, **described))
    require_folder_of(path)
    with stages(LOADING) as say:
        env = make_environment(describe_environment(game, **described))

        from sjdsl.render import make_painter, one_of, play_moments, save_png

        chosen = choose_policy(policy, env)
        if path.suffix == ".png":
            *_, last = one_of(every, told(play_moments(env, chosen, steps, seed), env, say))
            save_png(make_painter(env).draw(last.snapshot), path)
            done = f"{path}  step {last.snapshot.step} of {env.title or env.name}"
        else:
            done = save_film(env, chosen, path, steps, seed, every, speed, say)
    click.echo(done)
