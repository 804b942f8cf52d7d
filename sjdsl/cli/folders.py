"""Checks where output goes: a missing folder is reported, not made, as it may be a typing mistake; work that is stored is not lost."""

import shlex
import sys
from pathlib import Path

import click


def require_folder_of(file: Path) -> None:
    """Asks whether to make the folder of a file that is to be written; see `require_folder`."""
    require_folder(file.parent, f" to write {file.name} to")


def require_unused(file: Path, what: str) -> None:
    """Refuses a file that is there, so that earlier work is not lost. Raises ClickException."""
    if file.exists():
        raise click.ClickException(f"`{file}` is there already; name another file with -o, or move it away, so that no {what} are lost")


def require_folder(folder: Path, purpose: str = "") -> None:
    """Makes a folder that is not there if the person at the terminal says so.

    Raises ClickException where they say no, or nobody can be asked: before anything has been played or measured.
    """
    if folder.is_dir():
        return
    missing = f"there is no folder `{folder}`{purpose}"
    if folder.exists():
        raise click.ClickException(f"`{folder}` is a file, not a folder{purpose}; name another place")
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        raise click.ClickException(f"{missing}; make it first (mkdir -p {shlex.quote(str(folder))}), or name another place")
    if not click.confirm(f"{missing[0].upper()}{missing[1:]}. Make it?", default=True, err=True):
        raise click.ClickException("nothing was written")
    folder.mkdir(parents=True)
