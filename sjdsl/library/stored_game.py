"""Finds the game of a run, an episode or a sweep by the hash of its rules, also when the files have moved."""

from collections.abc import Iterator, Mapping
from itertools import product
from pathlib import Path
from typing import Any

from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.ir.hash import game_hash
from sjdsl.library.checked_game import build_game
from sjdsl.library.games_folder import is_name

ARGUMENTS = (
    "game",
    "variant",
    "num_agents",
    "params",
    "map",
)  # of `sjdsl.make` on which the rules depend


class GameMoved(Exception):
    """A file of a game isn't where it was, or has other rules."""


def locate_game(
    stored: Mapping[str, Any],
    rules: str,
    place: Path,
    game: str | None = None,
    map: str | None = None,
) -> dict[str, Any]:
    """Returns stored arguments of `sjdsl.make`, with the paths that its game and its map have now.

    A file that is gone, or has other rules now, is looked for near `place`: by the last parts of its path, in that folder and in
    all above it. If only the rules of existing files differ, the arguments are returned as they are.

    Args:
      stored: the arguments that a run, an episode or a sweep was made with.
      rules: the hash of its rules; empty if it isn't known.
      place: the file or folder that stores them.
      game, map: instead of the stored ones: a bundled game or a file, and a file.
    Raises:
      GameMoved: a file is gone, and no file near `place` has these rules; or what is given instead has others.
      CompileError, ValueError, FileNotFoundError: what is given instead can't be made.
    """
    instead = {name: value for name, value in (("game", game), ("map", map)) if value is not None}
    given = {**stored, **instead}
    files = {
        name: Path(given[name]).absolute()
        for name in ("game", "map")
        if _is_file_name(name, given.get(name))
    }
    given |= {name: str(path) for name, path in files.items()}
    if not files and not instead:
        return given
    choices = [
        [path] if name in instead else [path, *_nearby(path, place)] for name, path in files.items()
    ]
    for paths in product(*choices):
        arguments = given | {name: str(path) for name, path in zip(files, paths, strict=True)}
        if all(path.is_file() for path in paths) and _rules_of(arguments) == rules:
            return arguments
    missing = [
        f"no {path}" for name, path in files.items() if name not in instead and not path.is_file()
    ]
    if missing:
        raise GameMoved(
            f"the game of {place} is missing: there is {' and '.join(missing)}, and no file of that name near it has the rules {rules}"
        )
    if instead and not rules:
        raise GameMoved(f"{place} doesn't say which rules its game had")
    if instead:
        raise GameMoved(
            f"{' and '.join(instead.values())} has the rules {_hash_of(given)}, and those of {place} are {rules}"
        )
    return given


def _is_file_name(name: str, value: Any) -> bool:
    """Whether an argument names a file; a game may also be a bundled one, and a map given by its rows."""
    return isinstance(value, str) and (
        name == "map" or Path(value).is_absolute() or not is_name(value)
    )


def _nearby(path: Path, place: Path) -> Iterator[Path]:
    """Yields the files that have the last parts of a path, as many as possible first, in a folder or one above it."""
    parts = path.parts[1:] if path.is_absolute() else path.parts
    for folder in (place.resolve(), *place.resolve().parents):
        for first in range(len(parts)):
            found = folder.joinpath(*parts[first:])
            if found.is_file() and found != path:
                yield found


def _rules_of(arguments: Mapping[str, Any]) -> str | None:
    """Returns the hash of a game's rules; None if it can't be made."""
    try:
        return _hash_of(arguments)
    except (CompileError, ValueError, TypeError, KeyError, OverflowError, OSError):
        return None


def _hash_of(arguments: Mapping[str, Any]) -> str:
    known: dict[str, Any] = {name: arguments.get(name) for name in ARGUMENTS}
    made, _ = build_game(**known)
    return game_hash(made.game)
