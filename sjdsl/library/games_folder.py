"""Finds bundled games by name, and other games by path."""

from pathlib import Path

from sjdsl.near_names import meant

MELTING_POT = "meltingpot"  # the folder of the games that only Melting Pot has


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


def is_name(game: str | Path) -> bool:
    """Returns whether a game is given by its name, and not by the path of its file."""
    return not (Path(game).suffix == ".sj" or Path(game).is_file())


def find_game(name: str | Path) -> Path:
    """Returns the file of a game: a path to any `.sj` file, or the name of a bundled game.

    Raises FileNotFoundError naming the file that was perhaps meant, or the nearest game.
    """
    if not is_name(name):
        return Path(name)
    folder = games_folder()
    files = {
        path.stem: path for path in (*folder.glob("*.sj"), *(folder / MELTING_POT).glob("*.sj"))
    }
    if str(name) not in files:
        raise FileNotFoundError(_unknown(str(name)))
    return files[str(name)]


def _unknown(name: str) -> str:
    """Returns the message about a game that is not there."""
    path = Path(name)
    if path.is_dir():
        first = next(iter(sorted(path.glob("*.sj"))), None)
        return f"`{name}` is a folder, and a game is wanted{f'; name a file in it, such as {first}' if first else ''}"
    file = Path(f"{name}.sj")
    if file.is_file():
        return f"there is no bundled game `{name}`; for the file beside you write its whole name: `{file}`"
    return f"there is no bundled game `{name}`, and no file of that name{meant(name, bundled(), 'the bundled games are')}"
