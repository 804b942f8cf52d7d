"""Reads a file into a `Source`, with a clear message if that fails."""

import errno
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import CompileError, Diagnostic, Near, near
from sjdsl.compiler.diagnostics.limits import MAX_BYTES
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.files import read_bytes


def read_source(path: Path | str) -> Source:
    """Returns the text of `path`, without a byte order mark, line ends as they are.

    Raises:
      CompileError: no such file, a folder, a pipe or a device, no permission, too large, not UTF-8.
    """
    path = Path(path)
    name = path.as_posix()
    start = Source(name, "").span(0, 0)
    similar = Near()
    try:
        data = read_bytes(path, MAX_BYTES)
    except FileNotFoundError:
        problem = "there is no such file"
        with suppress(OSError):
            siblings = [p for p in path.parent.iterdir() if p.suffix == path.suffix and p.is_file()]
            similar = near(path.name, [p.name for p in siblings])
    except IsADirectoryError:
        problem = "it is a folder"
    except (OSError, ValueError) as error:
        if isinstance(error, OSError) and error.errno == errno.EFBIG:
            size = path.stat().st_size
            too_large = errors.FileTooLarge(start, size=size, limit=MAX_BYTES)
            raise CompileError([too_large]) from None
        problem = (getattr(error, "strerror", None) or "the name is not one of a file").lower()
    else:
        return replace(decode(data, name), folder=path.parent, file=path.resolve())
    raise CompileError([errors.Unreadable(start, name=name, problem=problem, near=similar)])


def decode(data: bytes, name: str) -> Source:
    """Returns the text that the bytes of a file are. Raises CompileError: too large, not UTF-8."""
    start = Source(name, "").span(0, 0)
    if len(data) > MAX_BYTES:
        raise CompileError([errors.FileTooLarge(start, size=len(data), limit=MAX_BYTES)])
    if b"\0" in data:
        raise CompileError([errors.NotText(start, problem=f"byte {data.index(0)} is NUL")])
    try:
        return Source(name, data.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        problem = f"byte {error.start} is not UTF-8"
        raise CompileError([errors.NotText(start, problem=problem)]) from None


def inside_folder(name: str, span: Span, source: Source, problems: Problems) -> Path | None:
    """Returns the path of a file named by a game.

    None, and reported, if it leaves the game's folder or can't be looked up. Links may lead
    anywhere inside that folder. Where the game's own file is a link, they may also lead inside the
    folder of the file that it leads to: in that folder, the game could name the same files.
    """
    problem: Diagnostic | None
    if source.folder is None:
        problem = errors.NoFile(span, name=name)
    elif not name or "\0" in name or "\\" in name or Path(name).is_absolute():
        problem = errors.FileOutside(span, name=name)
    else:
        folders = [source.folder.resolve()]
        if source.file is not None:
            folders.append(source.file.parent)
        path = folders[0] / name
        try:
            problem = _leads_outside(name, span, folders)
            if problem is None and path.is_symlink() and not path.exists():
                reason = "it is a link to a file that is not there"
                problem = errors.Unreadable(span, name=name, problem=reason)
        except (OSError, RuntimeError) as error:  # RuntimeError: links that lead to each other
            reason = getattr(error, "strerror", None) or "its links lead round in a circle"
            problem = errors.Unreadable(span, name=name, problem=reason.lower())
        if problem is None:
            return path
    problems.add(problem)
    return None


def _leads_outside(name: str, span: Span, folders: Sequence[Path]) -> Diagnostic | None:
    """Returns what is wrong with a path, from the first of some folders, that ends in none of them.

    Raises OSError, or RuntimeError for links that lead to each other.
    """
    path = folders[0] / name
    target = path.resolve()
    path.exists()  # raises OSError for a name that is too long
    if any(target.is_relative_to(folder) for folder in folders):
        return None
    parts = Path(name).parts
    for number in range(1, len(parts) + 1):
        part = folders[0].joinpath(*parts[:number])
        if part.is_symlink() and not part.resolve().is_relative_to(folders[0]):
            link = Path(*parts[:number]).as_posix()
            return errors.LinkOutside(span, name=name, link=link, target=part.readlink().as_posix())
    return errors.FileOutside(span, name=name)
