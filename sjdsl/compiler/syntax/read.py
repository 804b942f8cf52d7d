"""Reads a file into a `Source`, with a clear message if that fails."""

from contextlib import suppress
from pathlib import Path

from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import CompileError, Diagnostic, Near, near
from sjdsl.compiler.diagnostics.limits import MAX_BYTES
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.diagnostics.source import Source, Span


def read_source(path: Path | str) -> Source:
    """Returns the text of `path`, without a byte order mark, line ends as they are.

    Raises CompileError: no such file, a folder, no permission, too large, not UTF-8.
    """
    path = Path(path)
    name = path.as_posix()
    near_by = Near()
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
            size = path.stat().st_size
    except FileNotFoundError:
        problem = "there is no such file"
        with suppress(OSError):
            near_by = near(path.name, [p.name for p in path.parent.iterdir() if p.suffix == path.suffix and p.is_file()])
    except IsADirectoryError:
        problem = "it is a folder"
    except (OSError, ValueError) as error:
        problem = (getattr(error, "strerror", None) or "the name is not one of a file").lower()
    else:
        return decode(data, name, path.parent, max(size, len(data)))
    raise CompileError([errors.Unreadable(Source(name, "").span(0, 0), name=name, problem=problem, near=near_by)])


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
    problem: Diagnostic
    if source.folder is None:
        problem = errors.NoFile(span, name=name)
    elif not name or "\0" in name or "\\" in name or Path(name).is_absolute():
        problem = errors.FileOutside(span, name=name)
    else:
        folder = source.folder.resolve()
        try:
            path = (folder / name).resolve()
            path.exists()
            if path.is_relative_to(folder):
                return path
            problem = errors.FileOutside(span, name=name)
        except (OSError, RuntimeError) as error:  # RuntimeError: links that lead to each other
            why = (getattr(error, "strerror", None) or "its links lead round in a circle").lower()
            problem = errors.Unreadable(span, name=name, problem=why)
    problems.add(problem)
    return None
