"""Finds games by name, bundled ones and those of installed packages, and other games by path."""

from collections.abc import Mapping
from pathlib import Path

from sjdsl.library.game_packages import offered
from sjdsl.near_names import meant
from sjdsl.version import __version__

MELTING_POT = "meltingpot"  # the folder of the games that only Melting Pot has
OURS = "sjdsl"  # as the package of the bundled games is called in `sjdsl:coins`


class GamesClash(ValueError):
    """Several games have the name that was given; the text names them and says what to write."""


def games_folder() -> Path:
    """Returns the folder of the bundled games: inside the installed package, or `games/` of a source tree."""
    here = Path(__file__).resolve().parents[1]
    inside = here / "games"
    return inside if inside.is_dir() else here.parent / "games"


def bundled() -> list[str]:
    """Returns the names of all bundled games; no two folders have a game of the same name."""
    return sorted([*main_games(), *melting_pot_games()])


def main_games() -> list[str]:
    """Returns the names of the games of docs/games.md: those that `generated/` holds."""
    return sorted(path.stem for path in games_folder().glob("*.sj"))


def melting_pot_games() -> list[str]:
    """Returns the names of the further families of Melting Pot, those of the folder `meltingpot`."""
    return sorted(path.stem for path in (games_folder() / MELTING_POT).glob("*.sj"))


def game_names() -> list[str]:
    """Returns what games there are by name, bundled or installed; a name is there once, also if several games have it."""
    return sorted(_homes())


def by_release() -> dict[str, list[str]]:
    """Returns the games of each release, such as `sjdsl 0.1.0`, by names that say which is meant: `coins`, or `sjdsl:coins` if several are."""
    homes = _homes()
    named: dict[str, list[str]] = {release_of(OURS): []}
    for name, files in homes.items():
        for package in files:
            named.setdefault(release_of(package), []).append(name if len(files) == 1 else f"{package}:{name}")
    return {release: sorted(names) for release, names in named.items()}


def release_of(package: str) -> str:
    """Returns the distribution and version that a package of games was installed with: `sjdsl 0.1.0` for `sjdsl`."""
    releases = {found.name: found.release for found in offered().packages}
    return f"{OURS} {__version__}" if package == OURS else releases[package]


def game_problems() -> list[str]:
    """Returns what is wrong with the games of installed packages, a sentence each: packages that offer none, names that several have."""
    return [*offered().problems, *[_clash(name, files) for name, files in sorted(_homes().items()) if len(files) > 1]]


def is_name(game: str | Path) -> bool:
    """Returns whether a game is given by its name, and not by the path of its file."""
    return not (Path(game).suffix == ".sj" or Path(game).is_file())


def find_game(name: str | Path) -> Path:
    """Returns the file of a game: a path to any `.sj` file, or the name of a bundled game or of one of an installed package.

    `PACKAGE:GAME`, such as `river_games:river` or `sjdsl:coins`, is the game of that package alone.
    Raises FileNotFoundError naming the file that was perhaps meant, or the nearest game; GamesClash for a name that several games have.
    """
    path = Path(name)
    if not is_name(name):
        return path
    package, colon, game = str(name).rpartition(":")
    homes = _homes()
    files = {home: file for home, file in homes.get(game, {}).items() if not colon or home == package}
    if len(files) > 1:
        raise GamesClash(_clash(game, files))
    if files:
        return next(iter(files.values()))
    raise FileNotFoundError(_unknown(str(name), homes))


def _homes() -> dict[str, dict[str, Path]]:
    """Returns the file of each game by its name and its package."""
    folder = games_folder()
    found = {path.stem: {OURS: path} for path in (*folder.glob("*.sj"), *(folder / MELTING_POT).glob("*.sj"))}
    for package in offered().packages:
        for name, file in package.games.items():
            there = found.setdefault(name, {})
            if all(file.resolve() != other.resolve() for other in there.values()):  # one folder may have two entry points
                there[package.name] = file
    return found


def _clash(name: str, files: Mapping[str, Path]) -> str:
    *most, last = [f"one of {release_of(package)} ({file})" for package, file in files.items()]
    ways = " or ".join(f"`{package}:{name}`" for package in files)
    return f"{len(files)} games are called `{name}`: {', '.join(most)} and {last}; write {ways}, or uninstall one of them"


def _unknown(name: str, homes: Mapping[str, Mapping[str, Path]]) -> str:
    """Returns the message about a game that is not there."""
    path = Path(name)
    if path.is_dir():
        first = next(iter(sorted(path.glob("*.sj"))), None)
        return f"`{name}` is a folder, and a game is wanted{f'; name a file in it, such as {first}' if first else ''}"
    others = offered()
    sort = "bundled or installed game" if others.packages else "bundled game"
    problems = "".join(f"\nnote: {problem}" for problem in others.problems)
    file = Path(f"{name}.sj")
    if file.is_file():
        return f"there is no {sort} `{name}`; for the file beside you write its whole name: `{file}`{problems}"
    known = [f"{package}:{game}" if ":" in name else game for game, files in sorted(homes.items()) for package in files]
    return f"there is no {sort} `{name}`, and no file of that name{meant(name, known, f'the {sort}s are')}{problems}"
