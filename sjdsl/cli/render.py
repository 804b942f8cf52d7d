"""`sjdsl render`: a game as a moving picture, or one moment of it as a still one."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sjdsl.cli.environment import describe_environment, environment_options, make_environment, read_assignments
from sjdsl.cli.evaluate import stored_policy

if TYPE_CHECKING:
    from sjdsl.runtime.env import Environment


@click.command("render")
@click.argument("game")
@click.option("-o", "output", metavar="FILE", help="A .gif, or a .png of the last step; by default GAME.gif.")
@click.option("--steps", type=click.IntRange(min=0), default=100, show_default=True, help="Steps to play.")
@click.option("--every", type=click.IntRange(min=1), default=1, show_default=True, help="Show one step of so many.")
@click.option("--policy", default="random", show_default=True, metavar="P", help="random, stay, or the folder of a training run.")
@click.option("--seed", type=int, default=0, show_default=True)
@click.option("--speed", type=click.FloatRange(min=0.5, max=50), default=8.0, show_default=True, help="Frames a second.")
@environment_options
def command(game: str, output: str | None, steps: int, every: int, policy: str, seed: int, speed: float, **described: Any) -> None:
    """Plays GAME, a bundled one or a `.sj` file, and draws what happens."""
    path = Path(output or f"{Path(game).stem}.gif")
    if path.suffix not in (".gif", ".png"):
        raise click.UsageError(f"`{path}` is no .gif and no .png", click.get_current_context())
    described["params"] = read_assignments(described["params"])
    env = make_environment(describe_environment(game, **described))

    from sjdsl.render import make_painter, play, save_gif, save_png

    painter = make_painter(env)
    shots = play(env, choose_policy(policy, env), steps, seed, every)
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix == ".png":
        *_, last = shots
        save_png(painter.draw(last), path)
        click.echo(f"{path}  step {last.step} of {env.title or env.name}")
        return
    frames = [painter.draw(shot) for shot in shots]
    save_gif(frames, path, round(1000 / speed))
    width, height = frames[0].size
    click.echo(f"{path}  {len(frames)} frames of {width} x {height} pixels, {path.stat().st_size / 1000:.0f} kB")


def choose_policy(name: str, env: "Environment") -> Callable[..., Any]:
    """Returns a policy by name, or the one that a run stored in its folder."""
    from sjdsl.render import random_policy, stay_policy

    match name:
        case "random":
            return random_policy(env)
        case "stay":
            return stay_policy(env)
    if not Path(name).is_dir():
        raise click.ClickException(f"there is no policy `{name}`; it is random, stay, or the folder of a training run")
    return stored_policy(Path(name), env)
