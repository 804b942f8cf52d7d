"""Bundled games as examples: read where they are, and copied into the folder of whoever wants to change one."""

from collections.abc import Iterator, Mapping
from pathlib import Path, PurePosixPath

from sjdsl.compiler import ast
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.diagnostics.tree import walk
from sjdsl.compiler.syntax.parse import parse
from sjdsl.library.games_folder import games_folder
from sjdsl.library.starter import copied_files, starting_files
from sjdsl.studio import tour
from sjdsl.studio.folder import FileRefused, Folder

PREFIX = "example:"  # of the path of a bundled game, as the page has it


def examples() -> list[str]:
    """Returns the bundled games by their paths, with the prefix."""
    return [PREFIX + name for name in Folder(games_folder().resolve()).games()]


def example_of(file: Path) -> str | None:
    """Returns the path, as the page has it, of a bundled game; None for any other file."""
    file, home = file.resolve(), games_folder().resolve()
    return PREFIX + file.relative_to(home).as_posix() if file.is_relative_to(home) else None


def place_of(path: str, folder: Path) -> tuple[Path, str]:
    """Returns the folder that a path of the page is in, and the path there: an example, a game of the tour, or of somebody's own."""
    for prefix, home in ((PREFIX, games_folder()), (tour.PREFIX, tour.tour_folder())):
        if path.startswith(prefix):
            return home.resolve(), path.removeprefix(prefix)
    return folder, path


def copy_beside(example: str, folder: Folder) -> list[str]:
    """Copies what an example needs beside its own text, maps and bases, into a folder; returns what was written.

    Raises FileRefused: a file of that name is there and says something else; and what `Folder` raises.
    """
    home, path = place_of(example, folder.root)
    return _write_missing(dict(_needed(Folder(home), PurePosixPath(path))), folder)


def new_game(path: str, like: str, folder: Folder) -> list[str]:
    """Writes a new game into a folder, with its map and the games that it extends; returns what was written.

    path: of its file, whose name is that of the game; like: the path of the game it is a copy of, "" for the starting one of `sjdsl new`.
    Raises FileRefused: the name is none for a game, or there is such a file already; and what `Folder` raises.
    """
    place = PurePosixPath(path)
    if folder.inside(path).exists():
        raise FileRefused(f"there is a file `{path}` already: choose another name")
    try:
        if like:
            home, inside = place_of(like, folder.root)
            texts = copied_files(Folder(home).inside(inside), place.stem)
        else:
            texts = {
                name: text
                for name, text in starting_files(place.stem).items()
                if name.endswith((".sj", ".txt"))
            }
    except ValueError as error:
        raise FileRefused(str(error)) from None
    except CompileError as error:
        raise FileRefused(f"`{like}` cannot be copied: {error.diagnostics[0].message}") from None
    return _write_missing(
        {(place.parent / name).as_posix(): text for name, text in texts.items()}, folder
    )


def _write_missing(wanted: Mapping[str, str], folder: Folder) -> list[str]:
    """Writes the files that are not there yet, and returns their paths. Raises FileRefused: one is there and says something else."""
    missing = []
    for needed, text in wanted.items():
        try:
            if folder.read(needed)[0] != text:
                raise FileRefused(
                    f"there is another file `{needed}` in this folder: move it away, or start the studio in an empty folder"
                )
        except FileRefused:
            if (folder.root / needed).exists():
                raise
            missing.append(needed)
    for needed in missing:
        (folder.root / needed).parent.mkdir(parents=True, exist_ok=True)
        folder.write(needed, wanted[needed], None)
    return missing


def _needed(home: Folder, path: PurePosixPath) -> Iterator[tuple[str, str]]:
    """Yields the files that a game names, with their texts: the game that it extends, with what that needs, and the maps of all variants."""
    seen = set[Path]()
    place = PurePosixPath(path.name)  # of the file beside the copy
    while home.inside(path.as_posix()) not in seen:  # else the game extends itself
        seen.add(home.inside(path.as_posix()))
        try:
            file = parse(Source(path.as_posix(), home.read(path.as_posix())[0]))
        except CompileError:
            return
        for node in walk(file):
            if isinstance(node, ast.Map) and node.file is not None:
                yield (
                    (place.parent / node.file.text).as_posix(),
                    home.read((path.parent / node.file.text).as_posix())[0],
                )
        if file.game.extends is None:
            return
        path = path.parent / file.game.extends.text
        place = place.parent / file.game.extends.text
        yield place.as_posix(), home.read(path.as_posix())[0]
