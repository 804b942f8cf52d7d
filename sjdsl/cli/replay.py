"""`sjdsl replay`: a recorded episode, in the terminal or as a film."""

from pathlib import Path

import click

from sjdsl.cli.environment import make_environment
from sjdsl.cli.film import SPEED, check_film, write_film
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
        click.echo(write_film(env, (moment.snapshot for moment in moments), Path(output), speed))
    except RecordingError as error:
        raise click.ClickException(str(error)) from None
    return 0
