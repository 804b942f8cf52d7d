"""Reads a file into a `Source`, with a clear message if that fails."""

from pathlib import Path

from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import CompileError, Near, near
from sjdsl.compiler.diagnostics.limits import MAX_BYTES
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.diagnostics.source import Source, Span


def read_source(path: Path | str) -> Source:
    """Returns the text of `path`, without a byte order mark, line ends as they are.

    Raises CompileError: no such file, a folder, no permission, too large, not UTF-8.
    """
    path = Path(path)
    name = path.as_posix()
    start = Source(name, "").span(0, 0)
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
            size = path.stat().st_size
    except FileNotFoundError:
        raise CompileError([errors.Unreadable(start, name=name, problem="there is no such file", near=_neighbour(path))]) from None
    except IsADirectoryError:
        raise CompileError([errors.Unreadable(start, name=name, problem="it is a folder")]) from None
    except (OSError, ValueError) as error:
        problem = (getattr(error, "strerror", None) or "the name is not one of a file").lower()
        raise CompileError([errors.Unreadable(start, name=name, problem=problem)]) from None
    return decode(data, name, path.parent, max(size, len(data)))


def decode(data: bytes, name: str, folder: Path | None = None, size: int | None = None) -> Source:
    """Returns the text that the bytes of a file are. `size`: of the whole file, where `data` is only its beginning.

    Raises CompileError: too large, not UTF-8.
    """
    start = Source(name, "").span(0, 0)
    if len(data) > MAX_BYTES:
        raise CompileError([errors.FileTooLarge(start, given=size or len(data), limit=MAX_BYTES)])
    if b"\0" in data:
        raise CompileError([errors.NotText(start, problem=f"byte {data.index(0)} is NUL")])
    try:
        return Source(name, data.decode("utf-8-sig"), folder)
    except UnicodeDecodeError as error:
        raise CompileError([errors.NotText(start, problem=f"byte {error.start} is not UTF-8")]) from None


def inside_folder(name: str, span: Span, source: Source, problems: Problems) -> Path | None:
    """Returns the path of a file named by a game; None, and reported, if it leaves the game's folder."""
    given = Path(name)
    if source.folder is None:
        problems.add(errors.NoFile(span, name=name))
        return None
    folder = source.folder.resolve()
    if not name or "\0" in name or "\\" in name or given.is_absolute():
        problems.add(errors.FileOutside(span, name=name))
        return None
    try:
        path = (folder / given).resolve()
        path.exists()
    except (OSError, RuntimeError) as error:  # RuntimeError: links that lead to each other
        problem = (getattr(error, "strerror", None) or "its links lead round in a circle").lower()
        problems.add(errors.Unreadable(span, name=name, problem=problem))
        return None
    if not path.is_relative_to(folder):
        problems.add(errors.FileOutside(span, name=name))
        return None
    return path


def _neighbour(path: Path) -> Near:
    """Returns the game beside `path` whose name is nearest, or nothing."""
    try:
        names = [p.name for p in path.parent.iterdir() if p.suffix == path.suffix and p.is_file()]
    except OSError:
        return Near()
    return near(path.name, names)
