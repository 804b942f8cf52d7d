"""`sjdsl render`: writes a game as a film or a page, or one moment of it as a picture."""

from collections import deque
from contextlib import ExitStack
from pathlib import Path

import click

from sjdsl.cli.asked_episodes import asked_policy, calls_beside, host_of, require_model
from sjdsl.cli.environment_options import EnvironmentOptions, environment_options
from sjdsl.cli.episode_options import SEED_OF_FIRST, seed_option
from sjdsl.cli.film import announced, check_film, save_film
from sjdsl.cli.folders import require_folder_of
from sjdsl.cli.model_options import limit_options
from sjdsl.cli.policies import (
    check_policy,
    choose_policy,
    code_option,
    players_of,
    policy_option,
)
from sjdsl.cli.stages import LOADING, stages
from sjdsl.extras import require
from sjdsl.models import Limits


@click.command("render")
@click.argument("game")
@click.option(
    "-o",
    "output",
    metavar="FILE",
    help="A .gif, .mp4 or .html, or a .png of the last step; by default GAME.gif.",
)
@click.option(
    "--steps",
    type=click.IntRange(min=0),
    metavar="N",
    default=100,
    show_default=True,
    help="Steps to play.",
)
@policy_option
@code_option
@seed_option(SEED_OF_FIRST)
@click.option(
    "--speed",
    type=click.FloatRange(min=0.5, max=50),
    metavar="N",
    default=8.0,
    show_default=True,
    help="Frames a second.",
)
@environment_options
@limit_options
def command(
    game: str,
    output: str | None,
    steps: int,
    policy: str,
    seed: int,
    speed: float,
    options: EnvironmentOptions,
    limits: Limits,
) -> None:
    """Plays GAME, a bundled one or a `.sj` file, and draws what happens: by default cooperators
    beside defectors."""
    path = Path(output or f"{Path(game).stem}.gif")
    if path.suffix == ".png":
        require("pictures", "PIL", "resvg_py")
    else:
        check_film(path)
    check_policy(policy, options.check(game))
    require_folder_of(path)
    require_model(limits, [policy])
    host = host_of(policy)
    with stages(LOADING) as say, ExitStack() as stack:
        env = options.make(game)
        from sjdsl.render import make_painter, play_moments, save_png

        if host is None:
            act = choose_policy(policy, env)
        else:
            calls = calls_beside(path, policy, env, seed, limits, say)
            act = asked_policy(env, host, stack.enter_context(calls), seed)
        if path.suffix == ".png":
            moments = announced(play_moments(env, act, steps, seed), env, say)
            *before, last = deque(moments, maxlen=2)  # `before` is empty after no step
            snapshot_before = before[0].snapshot if before else None
            painter = make_painter(env, [last.snapshot])
            save_png(painter.draw(last.snapshot, last.actions, snapshot_before), path)
            summary = f"{path}  step {last.snapshot.step} of {env.title or env.name}"
        else:
            players = players_of(policy, env.game)
            summary = save_film(env, act, path, steps, seed, say, speed, players)
    click.echo(summary)
