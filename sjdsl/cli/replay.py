"""`sjdsl replay`: prints the boards of a recorded episode, or writes it as a film or a page."""

from pathlib import Path

import click

import sjdsl
from sjdsl.cli.environment_options import without_quoting_game
from sjdsl.cli.film import SPEED, announced, check_film, write_film
from sjdsl.cli.folders import require_folder_of
from sjdsl.cli.game_file import map_option
from sjdsl.cli.play import moment_lines
from sjdsl.cli.policies import warnings_as_notes
from sjdsl.cli.provenance import locate
from sjdsl.cli.stages import LOADING, stages
from sjdsl.interpreter.board import board_of
from sjdsl.printable import printable
from sjdsl.render.letters import make_letters
from sjdsl.replay import RecordingError, load_recording
from sjdsl.replay.asked import calls_of, told_messages


@click.command("replay")
@click.argument("file")
@click.option(
    "--episode",
    type=int,
    metavar="N",
    default=0,
    show_default=True,
    help="Which episode of a file of many to show; -1 is the last.",
)
@click.option(
    "-o",
    "output",
    metavar="FILE",
    help="Write a .gif, .mp4 or .html instead of printing the boards.",
)
@click.option("--game", metavar="GAME", help="Where the episode's game is now.")
@map_option
@click.option(
    "--speed",
    type=click.FloatRange(min=0.5, max=1000),
    metavar="N",
    default=SPEED,
    show_default=True,
    help="Steps a second.",
)
@click.option("--messages", is_flag=True, help="Print what models were asked, and their replies.")
@click.option(
    "--agent", type=int, metavar="I", multiple=True, help="With --messages: only of this agent."
)
def command(
    file: str,
    episode: int,
    output: str | None,
    game: str | None,
    map_file: str | None,
    speed: float,
    messages: bool,
    agent: tuple[int, ...],
) -> None:
    """Shows an episode that `sjdsl play --record` or `sjdsl record` stored, if the rules are still
    the same. FILE may be the folder of an experiment in which language models played: their reasons
    are shown as well."""
    if agent and not messages:
        raise click.UsageError("--agent goes with --messages")
    if messages and output is not None:
        raise click.UsageError("--messages are printed, so -o is not for them")
    if output is not None:
        check_film(Path(output))
        require_folder_of(Path(output))
    try:
        with warnings_as_notes():
            recording = load_recording(Path(file), episode)
        from sjdsl.replay import replayed
        from sjdsl.replay.episode_player import player_of

        with stages(LOADING) as say:
            retry = f"sjdsl replay {file} --game GAME"
            arguments = locate(
                recording.environment, recording.hash, Path(file), retry, game, map_file
            )
            with without_quoting_game(file):
                env = sjdsl.make(**arguments)
            if messages:
                calls = calls_of(Path(file), episode, recording.seed)
                player = player_of(recording, env)
                agents = agent or range(env.num_agents)
                report = "\n".join(told_messages(recording, player, calls, agents))
                click.echo(printable(report, lines=True))
                return
            moments = announced(replayed(recording, env), env, say)
            seats = recording.players or ()
            if output is not None:
                report = write_film(env, moments, Path(output), speed, say, seats, recording.seed)
            else:
                letters = make_letters(env.game)
                board = board_of(env.game)
                boards = [
                    "\n".join(moment_lines(moment, letters, board, seats=seats))
                    for moment in moments
                ]
                report = "\n\n".join([letters.legend_line(), *boards])
    except RecordingError as error:
        raise click.ClickException(str(error)) from None
    click.echo(report)
