"""`sjdsl studio`: shows a game's text beside its board, in the browser of this machine."""

import os
import socket
import webbrowser
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import click

from sjdsl.cli.asked_episodes import require_model
from sjdsl.cli.environment_options import EnvironmentOptions
from sjdsl.cli.game_file import agents_option, game_path, variant_option
from sjdsl.cli.model_options import limit_options
from sjdsl.cli.policies import (
    FROM_FILE,
    NAMES,
    SIDE_BY_SIDE,
    choose_policy,
    code_option,
    read_seats,
)
from sjdsl.cli.stages import LOADING, stages
from sjdsl.extras import require
from sjdsl.library.cache import cache_folder
from sjdsl.models import Limits
from sjdsl.studio.access import HOST, Access, kept_token
from sjdsl.studio.examples import example_of
from sjdsl.studio.seats import Seats
from sjdsl.trainers.settings.extensions import allowed_code
from sjdsl.trainers.settings.policy_names import YOU

PORT = 8421


@click.command("studio")
@click.argument("game", required=False)
@click.option(
    "--port",
    type=click.IntRange(0, 65535),
    metavar="N",
    help=f"The port; by default {PORT}, or any if that is taken.",
)
@click.option(
    "--slots",
    metavar="P,P,...",
    help=f"Who plays each agent of GAME, `{YOU}` yourself: {NAMES} {SIDE_BY_SIDE}: {FROM_FILE}.",
)
@code_option
@variant_option
@agents_option
@limit_options
@click.option(
    "--browser/--no-browser", default=True, help="Open the page in the browser.  [default: browser]"
)
def command(
    game: str | None,
    port: int | None,
    slots: str | None,
    variant: str | None,
    agents: int | None,
    browser: bool,
    limits: Limits,
) -> None:
    """Opens the games of this folder in the browser: text, board, rules on a page, generated code.

    GAME is the `.sj` file to open first, or a bundled game as an example. The page is served to
    this machine only, needs no internet, and writes a file only when you save it. It needs the
    extra `sjdsl[studio]`.
    """
    require("studio", "starlette", "uvicorn", "websockets", "pygls")
    folder = Path.cwd().resolve()
    options = EnvironmentOptions(variant=variant, num_agents=agents)
    path = None if game is None else _path_in_page(game, folder)
    seats = None
    names: list[str] = []
    if slots is not None or options.names:
        if game is None or path is None:
            raise click.UsageError(
                "--slots, --variant and --agents are about GAME: name a game before them"
            )
        rules = options.check(game)
        if slots is not None:
            names, _ = read_seats(slots, rules)
            _check_players(names, game, options)
            seats = Seats(path, tuple(names), allowed_code(), asdict(limits))
    require_model(limits, names)
    import uvicorn

    from sjdsl.studio.server import FirstGame, make_app

    first = None if path is None else FirstGame(path, variant or "", agents)

    listening = _listen(port)
    access = Access(listening.getsockname()[1], kept_token(cache_folder()))
    click.echo(f"the studio is at {access.address}\nCtrl-C ends it")
    if browser:
        webbrowser.open(access.address)
    settings = uvicorn.Config(
        make_app(folder, access, first, seats),
        log_level="warning",
        ws="websockets-sansio",
        ws_max_size=2**21,
    )
    uvicorn.Server(settings).run(sockets=[listening])


def _check_players(names: Sequence[str], game: str, options: EnvironmentOptions) -> None:
    """Loads who plays, so that the page has no policy that doesn't fit the game.

    Raises PolicyError, ModelError or ConfigError; notes about policies are printed.
    """
    os.environ.setdefault("JAX_PLATFORMS", "cpu")  # an accelerator is left to trainings beside it
    with stages(LOADING):
        from sjdsl.trainers.policies.seating import seated_policy

        seated_policy(names, options.make(game), choose_policy)


def _path_in_page(game: str, folder: Path) -> str:
    """Returns the path by which the page calls a game: relative to the folder, or an example's."""
    path = game_path(game).resolve()
    example = None if path.is_relative_to(folder) else example_of(path)
    if example is not None:
        return example
    if not path.is_file():
        raise click.ClickException(f"there is no file `{game}`; `sjdsl new NAME` makes a game")
    if not path.is_relative_to(folder):
        raise click.ClickException(
            f"`{game}` is outside this folder: start the studio in the game's own folder, "
            f"{path.parent}"
        )
    relative = path.relative_to(folder).as_posix()
    if any("\ud800" <= character <= "\udfff" for character in relative):  # bytes that aren't UTF-8
        raise click.ClickException(
            f"the name `{ascii(relative)[1:-1]}` is not UTF-8, so no page can show it: "
            "rename the file"
        )
    return relative


def _listen(port: int | None) -> socket.socket:
    """Returns a socket at a port; for None at the usual port, or any that is free."""
    for candidate in (PORT, 0) if port is None else (port,):
        listening = socket.socket()
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listening.bind((HOST, candidate))
            listening.listen()  # requests wait until the server has started
            return listening
        except OSError as error:
            listening.close()
            reason = error.strerror
    raise click.ClickException(
        f"port {port} can't be used: {reason}; leave out --port to use any that is free"
    )
