"""Writes episodes as GIF, MP4 or HTML files for several commands."""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sjdsl.cli.stages import Say
from sjdsl.extras import require

if TYPE_CHECKING:
    from sjdsl.render import Moment
    from sjdsl.runtime.env import Environment

SPEED = 8.0  # frames a second
PAGE = ".html"
FILMS = (".gif", ".mp4", PAGE)


def check_film(path: Path) -> None:
    """Checks that a file is a film or a page, by its suffix.

    Raises UsageError, or MissingExtra if it needs packages that aren't installed.
    """
    if path.suffix not in FILMS:
        raise click.UsageError(
            f"`{path}` must end in .gif, .mp4 or .html (or .png, for a single picture)"
        )
    if path.suffix == ".mp4":
        require("video", "av")
    if path.suffix != PAGE:
        require("pictures", "PIL", "resvg_py")


def save_film(
    env: "Environment",
    policy: Any,
    path: Path,
    steps: int,
    seed: int,
    say: Say,
    speed: float = SPEED,
    players: Sequence[str] = (),
) -> str:
    """Plays an episode and writes it as a film or a page; returns a line about the file.

    Args:
      say: announces the stages.
      speed: frames a second.
      players: who plays each agent, for a page.
    """
    from sjdsl.render import play_moments

    moments = announced(play_moments(env, policy, steps, seed), env, say)
    return write_film(env, moments, path, speed, say, players, seed)


def announced(moments: "Iterable[Moment]", env: "Environment", say: Say) -> "Iterator[Moment]":
    """Yields the moments of an episode, and announces that it compiles, then that it plays.

    The first two moments wait for the compiler.
    """
    say(f"compiling {env.name}")
    for number, moment in enumerate(moments):
        if number == 1:
            say(f"playing {env.name}")
        yield moment


def write_film(
    env: "Environment",
    moments: "Iterable[Moment]",
    path: Path,
    speed: float,
    say: Say,
    players: Sequence[str] = (),
    seed: int | None = None,
) -> str:
    """Writes moments as a film or a page of `speed` frames a second; returns a line about the
    file. A page names the players of the agents and the seed.
    """
    episode = list(moments)
    if path.suffix == PAGE:
        from sjdsl.render import make_page

        say(f"writing {path}")
        make_page(env.game, episode, speed, players, seed).save(path)
        contents = f"{len(episode)} moments to look at in a browser"
    else:
        from sjdsl.render import draw_film, save_gif, save_mp4

        say("drawing the pictures")
        frames = list(draw_film(env, episode))
        say(f"writing {path}")
        save = save_mp4 if path.suffix == ".mp4" else save_gif
        save(frames, path, round(1000 / speed))
        width, height = frames[0].size
        contents = f"{len(frames)} frames of {width} x {height} pixels"
    return f"{path}  {contents}, {path.stat().st_size / 1000:.0f} kB"
