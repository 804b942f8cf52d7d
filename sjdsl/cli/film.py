"""Writes episodes as GIF or MP4 files for several commands."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from sjdsl.cli.stages import Say

if TYPE_CHECKING:
    from sjdsl.render import Snapshot
    from sjdsl.runtime.env import Environment

SPEED = 8.0  # frames a second


def check_film(path: Path) -> None:
    """Refuses a file that is no film, or one that needs a package that is missing."""
    if path.suffix not in (".gif", ".mp4"):
        raise click.UsageError(
            f"`{path}` must end in .gif or .mp4, or where one picture is drawn in .png", click.get_current_context(silent=True)
        )
    if path.suffix == ".mp4":
        import importlib.util

        if importlib.util.find_spec("av") is None:
            raise click.ClickException("an .mp4 needs the package av: pip install 'sjdsl[video]'; a .gif needs nothing")


def save_film(
    env: "Environment", policy: Any, path: Path, steps: int, seed: int, every: int = 1, speed: float = SPEED, say: Say = lambda _: None
) -> str:
    """Plays, draws and writes a film; returns what there is to say about it. `say` is told what is being done."""
    from sjdsl.render import play

    return write_film(env, told(play(env, policy, steps, seed, every), env, say), path, speed, say)


def told(shots: "Iterable[Snapshot]", env: "Environment", say: Say) -> "Iterator[Snapshot]":
    """Yields the moments of an episode as they are played, and says that they are: the first two wait for the compiler."""
    say(f"compiling {env.name}")
    for number, shot in enumerate(shots):
        if number == 1:
            say(f"playing {env.name}")
        yield shot


def write_film(env: "Environment", shots: "Iterable[Snapshot]", path: Path, speed: float = SPEED, say: Say = lambda _: None) -> str:
    """Draws and writes a film of some moments; returns what there is to say about it."""
    from sjdsl.render import make_painter, save_gif, save_mp4

    shots = list(shots)
    say(f"drawing {len(shots)} pictures")
    painter = make_painter(env)
    frames = [painter.draw(shot) for shot in shots]
    say(f"writing {path}")
    save = save_mp4 if path.suffix == ".mp4" else save_gif
    save(frames, path, round(1000 / speed))
    width, height = frames[0].size
    return f"{path}  {len(frames)} frames of {width} x {height} pixels, {path.stat().st_size / 1000:.0f} kB"
