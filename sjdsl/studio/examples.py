"""Bundled games as examples: read where they are, and copied into the user's folder."""

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

PREFIX = "example:"  # of the path of a bundled game, in the page


def examples() -> list[str]:
    """Returns the bundled games by their paths, with the prefix."""
    return [PREFIX + name for name in Folder(games_folder().resolve()).games()]


def example_of(file: Path) -> str | None:
    """Returns the path in the page of a bundled game, None for any other file."""
    file = file.resolve()
    home = games_folder().resolve()
    if not file.is_relative_to(home):
        return None
    return PREFIX + file.relative_to(home).as_posix()


def place_of(path: str, folder: Path) -> tuple[Path, str]:
    """Returns the folder of a game and its path there, by its path in the page.

    It is an example, a game of the tour, or a game in the user's `folder`.
    """
    for prefix, home in ((PREFIX, games_folder()), (tour.PREFIX, tour.tour_folder())):
        if path.startswith(prefix):
            return home.resolve(), path.removeprefix(prefix)
    return folder, path


def copy_beside(example: str, folder: Folder) -> list[str]:
    """Copies the maps and bases of an example into a folder; returns the paths of the new files.

    Raises:
      FileRefused: the folder has another file of that name; and as `Folder` does.
    """
    home, path = place_of(example, folder.root)
    needed = dict(_needed_files(Folder(home), PurePosixPath(path)))
    return _write_missing(needed, folder)


def new_game(path: str, like: str, folder: Folder) -> list[str]:
    """Writes a new game with its map and bases; returns the paths of the new files.

    Args:
      path: of its file, whose name is that of the game.
      like: the path of the game that it copies, "" for the one that `sjdsl new` writes.

    Raises:
      FileRefused: the name isn't one of a game, or there is such a file; and as `Folder` does.
    """
    new_path = PurePosixPath(path)
    if folder.path_of(path).exists():
        raise FileRefused(f"there is a file `{path}` already: choose another name")
    try:
        if like:
            home, path_there = place_of(like, folder.root)
            texts = copied_files(Folder(home).path_of(path_there), new_path.stem)
        else:
            texts = {
                name: text
                for name, text in starting_files(new_path.stem).items()
                if name.endswith((".sj", ".txt"))
            }
    except ValueError as error:
        raise FileRefused(str(error)) from None
    except CompileError as error:
        raise FileRefused(f"`{like}` cannot be copied: {error.diagnostics[0].message}") from None
    files = {(new_path.parent / name).as_posix(): text for name, text in texts.items()}
    return _write_missing(files, folder)


def _write_missing(files: Mapping[str, str], folder: Folder) -> list[str]:
    """Writes the files that don't exist yet, and returns their paths.

    Raises:
      FileRefused: a file exists with another text.
    """
    missing = []
    for path, text in files.items():
        try:
            if folder.read(path).text != text:
                raise FileRefused(
                    f"there is another file `{path}` in this folder: move it away, or start the "
                    "studio in an empty folder"
                )
        except FileRefused:
            if (folder.root / path).exists():
                raise
            missing.append(path)
    for path in missing:
        (folder.root / path).parent.mkdir(parents=True, exist_ok=True)
        folder.write(path, files[path], None)
    return missing


def _needed_files(home: Folder, path: PurePosixPath) -> Iterator[tuple[str, str]]:
    """Yields the maps of a game's variants, its base, and what that needs, with their texts.

    Their paths are beside the copy of the game.
    """
    seen = set[Path]()
    copy = PurePosixPath(path.name)
    while True:
        name = path.as_posix()
        text = home.read(name).text
        if seen:  # a base, not the game itself
            yield copy.as_posix(), text
        if home.path_of(name) in seen:  # the game extends itself
            return
        seen.add(home.path_of(name))
        try:
            file = parse(Source(name, text))
        except CompileError:
            return
        for node in walk(file):
            if isinstance(node, ast.Map) and node.file is not None:
                map_text = home.read((path.parent / node.file.text).as_posix()).text
                yield (copy.parent / node.file.text).as_posix(), map_text
        if file.game.extends is None:
            return
        path = path.parent / file.game.extends.text
        copy = copy.parent / file.game.extends.text
