"""Finds the game of a run, an episode or a sweep by the hash of its rules, even if it has moved."""

from collections.abc import Iterator, Mapping
from itertools import product
from pathlib import Path
from typing import Any

from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.ir.hash import game_hash
from sjdsl.library.checked_game import build_game
from sjdsl.library.games_folder import is_name

# Arguments of `sjdsl.make` on which the rules depend.
ARGUMENTS = ("game", "variant", "num_agents", "params", "map")


class GameMoved(Exception):
    """A file of a game isn't where it was, or has other rules."""


def locate_game(
    stored: Mapping[str, Any],
    rules: str,
    place: Path,
    game: str | None = None,
    map: str | None = None,
) -> dict[str, Any]:
    """Returns stored arguments of `sjdsl.make` with the present paths of its game and its map.

    A file that is gone, or has other rules now, is searched near `place`: by the last parts of its
    path, in that folder and in those above. If the files exist but no rules fit, the stored
    arguments are returned.

    Args:
      stored: the arguments of a run, an episode or a sweep.
      rules: the hash of its rules, "" if it isn't known.
      place: the file or folder that stores them.
      game, map: replace the stored ones: a bundled game or a file, and a file.

    Raises:
      GameMoved: a file is gone, and no file near `place` has these rules; or the replacement has
        other rules.
      CompileError, ValueError, FileNotFoundError: the replacement can't be built.
    """
    replaced = {name: value for name, value in (("game", game), ("map", map)) if value is not None}
    arguments = {**stored, **replaced}
    files: dict[str, Path] = {}
    for name in ("game", "map"):
        if _is_file_name(name, arguments.get(name)):
            files[name] = Path(arguments[name]).absolute()
            arguments[name] = str(files[name])
    if not files and not replaced:
        return arguments
    choices = [
        [path] if name in replaced else [path, *_nearby(path, place)]
        for name, path in files.items()
    ]
    for paths in product(*choices):
        paths_by_name = zip(files, paths, strict=True)
        candidate = arguments | {name: str(path) for name, path in paths_by_name}
        if all(path.is_file() for path in paths) and _rules_of(candidate) == rules:
            return candidate
    missing = [
        f"no {path}" for name, path in files.items() if name not in replaced and not path.is_file()
    ]
    if missing:
        raise GameMoved(
            f"the game of {place} is missing: there is {' and '.join(missing)}, and no file of "
            f"that name near it has the rules {rules}"
        )
    if replaced and not rules:
        raise GameMoved(f"{place} doesn't say which rules its game had")
    if replaced:
        raise GameMoved(
            f"{' and '.join(replaced.values())} has the rules {_hash_of(arguments)}, and those of "
            f"{place} are {rules}"
        )
    return arguments


def _is_file_name(name: str, value: Any) -> bool:
    """Returns whether an argument names a file, not a bundled game or the rows of a map."""
    if not isinstance(value, str):
        return False
    return name == "map" or Path(value).is_absolute() or not is_name(value)


def _nearby(path: Path, place: Path) -> Iterator[Path]:
    """Yields the files in a folder or above it whose paths end like `path`, longest ends first."""
    parts = path.parts[1:] if path.is_absolute() else path.parts
    for folder in (place.resolve(), *place.resolve().parents):
        for first in range(len(parts)):
            candidate = folder.joinpath(*parts[first:])
            if candidate.is_file() and candidate != path:
                yield candidate


def _rules_of(arguments: Mapping[str, Any]) -> str | None:
    """Returns the hash of a game's rules, None if the game can't be built."""
    try:
        return _hash_of(arguments)
    except (CompileError, ValueError, TypeError, KeyError, OverflowError, OSError):
        return None


def _hash_of(arguments: Mapping[str, Any]) -> str:
    of_rules: dict[str, Any] = {name: arguments.get(name) for name in ARGUMENTS}
    build, _ = build_game(**of_rules)
    return game_hash(build.game)
