"""`sjdsl replay`: a recorded episode, in the terminal or as a film."""

from pathlib import Path

import click

from sjdsl.cli.environment import make_environment
from sjdsl.cli.film import SPEED, check_film
from sjdsl.cli.play import make_show


@click.command("replay")
@click.argument("file")
@click.option("-o", "output", metavar="FILE", help="Write a .gif or .mp4 instead of showing it here.")
@click.option("--speed", type=click.FloatRange(min=0.5, max=1000), default=SPEED, show_default=True, help="Steps a second.")
def command(file: str, output: str | None, speed: float) -> int:
    """Shows an episode that `sjdsl play --record` kept, after seeing that its rules are still the same."""
    if output is not None:
        check_film(Path(output))

    from sjdsl.replay import RecordingError, load_recording, replayed

    try:
        recording = load_recording(Path(file))
        env = make_environment(recording.environment)
        moments = replayed(recording, env)
        if output is None:
            show = make_show(env, speed)
            for moment in moments:
                show(moment, "")
            return 0
        from sjdsl.render import make_painter, save_gif, save_mp4

        painter, path = make_painter(env), Path(output)
        frames = [painter.draw(moment.snapshot) for moment in moments]
    except RecordingError as error:
        raise click.ClickException(str(error)) from None
    path.parent.mkdir(parents=True, exist_ok=True)
    save = save_mp4 if path.suffix == ".mp4" else save_gif
    save(frames, path, round(1000 / speed))
    click.echo(f"{path}  {len(frames)} frames")
    return 0
