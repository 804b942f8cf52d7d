"""`sjdsl replay`: shows a recorded episode in the terminal, or writes it as a film or a page."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from sjdsl.cli.environment_options import EnvironmentOptions, make_environment, named_in
from sjdsl.cli.film import SPEED, announced, check_film, write_film
from sjdsl.cli.folders import require_folder_of
from sjdsl.cli.play import begin_session, describe_returns, play_on
from sjdsl.cli.stages import LOADING, stages
from sjdsl.compiler.ir.hash import game_hash
from sjdsl.replay import Recording, RecordingError, load_recording
from sjdsl.replay.recording import check_actions, check_returns, check_rules
from sjdsl.screen.board import board_text, make_screen_looks
from sjdsl.screen.session import written_choice
from sjdsl.screen.sidebar import event_line

if TYPE_CHECKING:
    from sjdsl.render.moment import Moment


@click.command("replay")
@click.argument("file")
@click.option(
    "--episode", type=int, metavar="N", default=0, show_default=True, help="Which episode of a file of many to show; -1 is the last."
)
@click.option("-o", "output", metavar="FILE", help="Write a .gif, .mp4 or .html instead of showing it here.")
@click.option("--speed", type=click.FloatRange(min=0.5, max=1000), metavar="N", default=SPEED, show_default=True, help="Steps a second.")
def command(file: str, episode: int, output: str | None, speed: float) -> int:
    """Shows an episode that `sjdsl play --record` or `sjdsl record` stored, if the rules are still the same."""
    if output is not None:
        check_film(Path(output))
        require_folder_of(Path(output))

    try:
        recording = load_recording(Path(file), episode)
        if output is None:
            show(recording, file, speed)
            return 0

        from sjdsl.replay import replayed

        with stages(LOADING) as say:
            with named_in(file):
                env = make_environment(recording.environment)
            done = write_film(env, announced(replayed(recording, env), env, say), Path(output), speed, say)
        click.echo(done)
    except RecordingError as error:
        raise click.ClickException(str(error)) from None
    return 0


def show(recording: "Recording", file: str, speed: float) -> None:
    """Shows a recorded episode on the screen, or prints its moments one by one where there is no screen.

    Raises RecordingError: the rules have changed, the actions don't exist in the game, or they give other returns than recorded.
    """
    given = recording.environment
    with named_in(file):
        options = EnvironmentOptions(given.get("variant"), given.get("map"), given.get("num_agents"), given.get("params") or {})
        made, values = options.read(given["game"])
    check_rules(recording, game_hash(made.game), made.game.name)
    check_actions(recording, made.game.agents.number, len(made.game.agents.actions))
    session = begin_session(made.game, values, recording.seed, written_choice(recording.actions), None, len(recording.actions))
    looks = make_screen_looks(made.game)

    def print_moment(moment: "Moment") -> None:
        snapshot = moment.snapshot
        click.echo(board_text(looks, snapshot).plain)
        click.echo(f"step {snapshot.step}\n{describe_returns(snapshot.returns)}\n{event_line(moment)}".rstrip() + "\n")

    play_on(session, made.game, values, given, "random", recording.seed, speed, print_moment)
    if session.is_over:
        check_returns(recording, session.moment.snapshot.returns.tolist())
