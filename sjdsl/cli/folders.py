"""Checks where output goes, before anything is played: that it can be written, and that stored work
isn't overwritten.

If the folder of an output file is missing, the user is asked, as it may be a typing mistake. The
folder of an experiment is made, with those above it.
"""

import shlex
import sys
import tempfile
from pathlib import Path

import click


def require_folder_of(file: Path) -> None:
    """Checks that the folder of an output file can be written to; `require_folder` makes it."""
    require_folder(file.parent, f" to write {file.name} to")
    require_writable(file.parent)


def require_writable(folder: Path) -> None:
    """Checks that files can be written to a folder, or to the nearest existing one above it.

    Raises ClickException.
    """
    existing = next(path for path in (folder, *folder.parents, Path.cwd()) if path.exists())
    if not existing.is_dir():
        raise click.ClickException(f"`{existing}` is a file, not a folder; name another place")
    try:
        with tempfile.TemporaryFile(dir=existing):
            pass
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise click.ClickException(
            f"nothing can be written to `{existing}`: {reason}; name another place"
        ) from None


def require_unused(file: Path, contents: str) -> None:
    """Raises ClickException if a file exists already, so that earlier work isn't lost."""
    if file.exists():
        raise click.ClickException(
            f"`{file}` exists already; name another file with -o, or move it away, "
            f"so that no {contents} are lost"
        )


def require_folder(folder: Path, purpose: str = "") -> None:
    """Makes a missing folder if the person at the terminal agrees.

    Raises ClickException if they don't, or nobody can be asked.
    """
    if folder.is_dir():
        return
    if folder.exists():
        raise click.ClickException(
            f"`{folder}` is a file, not a folder{purpose}; name another place"
        )
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        raise click.ClickException(
            f"there is no folder `{folder}`{purpose}; "
            f"make it first (mkdir -p {shlex.quote(str(folder))}), or name another place"
        )
    question = f"There is no folder `{folder}`{purpose}. Make it?"
    if not click.confirm(question, default=True, err=True):
        raise click.ClickException("nothing was written")
    folder.mkdir(parents=True)
