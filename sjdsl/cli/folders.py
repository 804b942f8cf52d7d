"""Checks where output goes: a missing folder is reported, not made, as it may be a typing mistake; stored work isn't overwritten."""

import shlex
import sys
from pathlib import Path

import click


def require_folder_of(file: Path) -> None:
    """Asks whether to make the folder of an output file; see `require_folder`."""
    require_folder(file.parent, f" to write {file.name} to")


def require_unused(file: Path, what: str) -> None:
    """Raises ClickException if a file exists already, so that earlier work isn't lost."""
    if file.exists():
        raise click.ClickException(f"`{file}` exists already; name another file with -o, or move it away, so that no {what} are lost")


def require_folder(folder: Path, purpose: str = "") -> None:
    """Makes a missing folder if the person at the terminal agrees.

    Raises ClickException if they don't, or nobody can be asked.
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
