"""Games of installed packages: what entry points of the group `sjdsl.games` name, found without importing any of those packages.

The value of an entry point is the name of a package, `river_games`, or of one inside it, `river_games.harvest`; each `.sj` file in
that package's own folder is a game, called by the file's name without its ending.
"""

import os
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib.machinery import ModuleSpec
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from pathlib import Path

GROUP = "sjdsl.games"


@dataclass(frozen=True)
class GamePackage:
    """The games of one package, by name.

    `name`: as it is imported; `release`: the distribution that it was installed with, and its version, such as `river-games 0.1.0`.
    """

    name: str
    release: str
    games: Mapping[str, Path]


@dataclass(frozen=True)
class Offered:
    """What the installed packages offer. `problems`: what is wrong with those entry points that offer nothing, a sentence each."""

    packages: tuple[GamePackage, ...]
    problems: tuple[str, ...]


def offered() -> Offered:
    """Returns the games of all installed packages, by the names of the packages; one that is broken does not hide the others."""
    packages: dict[str, GamePackage] = {}
    problems = []
    for entry in _entries(tuple((place, _changed(place)) for place in sys.path)):
        found = _read(entry)
        if isinstance(found, str):
            problems.append(found)
        else:
            packages.setdefault(found.name, found)
    return Offered(tuple(packages[name] for name in sorted(packages)), tuple(dict.fromkeys(problems)))


@lru_cache(maxsize=4)
def _entries(places: tuple[tuple[str, int], ...]) -> tuple[EntryPoint, ...]:
    """Returns the entry points, which take 15 ms to find; they are looked for again when a place where packages are installed changes."""
    del places
    return tuple(sorted(entry_points(group=GROUP), key=lambda entry: (entry.value, entry.name)))


def _changed(place: str) -> int:
    try:
        return os.stat(place or ".").st_mtime_ns
    except OSError:
        return 0


def _read(entry: EntryPoint) -> GamePackage | str:
    """Returns the games that an entry point names, or what is wrong with it."""
    release = f"{entry.dist.name} {entry.dist.version}" if entry.dist is not None else entry.name
    offer = f"{release} offers games by the entry point `{entry.name} = {entry.value}`"
    if ":" in entry.value:
        return f"{offer}, and a package's name is wanted there, without `:` and what follows it"
    try:
        spec = _spec(entry.value.strip())
    except Exception as error:  # whatever finders of packages raise
        return f"{offer}, and looking for that package fails: {type(error).__name__}: {error}"
    if spec is None:
        return f"{offer}, and there is no package of that name: install {release.split()[0]} again, or remove it"
    if spec.submodule_search_locations is None:
        return f"{offer}, and that is a single module: a package is wanted, a folder with `.sj` files in it"
    folders = [Path(folder) for folder in spec.submodule_search_locations]
    if not any(folder.is_dir() for folder in folders):
        return f"{offer}, and that package is not in a folder of its own (perhaps in a zip file), where games could be read"
    games = {file.stem: file for folder in reversed(folders) for file in sorted(folder.glob("*.sj"))}
    if not games:
        return f"{offer}, and there are no `.sj` files in {folders[0]}: does the package's build leave them out?"
    return GamePackage(entry.value.strip(), release, dict(sorted(games.items())))


def _spec(name: str) -> ModuleSpec | None:
    """Returns where a package is. `find_spec` would import the packages around it, and so run their code."""
    outer, *inner = name.split(".")
    spec = find_spec(outer)
    for part in inner:
        if spec is None or spec.submodule_search_locations is None:
            return None
        outer = f"{outer}.{part}"
        path = spec.submodule_search_locations
        spec = next((found for finder in sys.meta_path if (found := finder.find_spec(outer, path)) is not None), None)
    return spec
