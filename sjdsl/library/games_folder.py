"""Finds bundled games by name, and other games by path."""

from pathlib import Path

from sjdsl.near_names import meant

MELTING_POT = "meltingpot"  # the folder of the games that only Melting Pot has


def games_folder() -> Path:
    """Returns the folder of the bundled games, in the installed package or in a source tree."""
    package = Path(__file__).resolve().parents[1]
    installed = package / "games"
    return installed if installed.is_dir() else package.parent / "games"


def bundled() -> list[str]:
    """Returns the names of all bundled games."""
    return sorted([*main_games(), *melting_pot_games()])


def main_games() -> list[str]:
    """Returns the names of the games in docs/games.md, whose modules are in `generated/`."""
    return sorted(path.stem for path in games_folder().glob("*.sj"))


def melting_pot_games() -> list[str]:
    """Returns the names of the other games of Melting Pot, those in the folder `meltingpot`."""
    return sorted(path.stem for path in (games_folder() / MELTING_POT).glob("*.sj"))


def is_name(game: str | Path) -> bool:
    """Returns whether a text is the name of a game, not the path of a file."""
    return not (Path(game).suffix == ".sj" or Path(game).is_file())


def find_game(name: str | Path) -> Path:
    """Returns the file of a game: a path to any `.sj` file, or the name of a bundled game.

    Raises:
      FileNotFoundError: there is no such bundled game; the message suggests a file or a game.
    """
    if not is_name(name):
        return Path(name)
    folder = games_folder()
    for path in (*folder.glob("*.sj"), *(folder / MELTING_POT).glob("*.sj")):
        if path.stem == str(name):
            return path
    raise FileNotFoundError(_unknown_game(str(name)))


def _unknown_game(name: str) -> str:
    """Returns the message about a game that doesn't exist."""
    path = Path(name)
    if path.is_dir():
        games = sorted(path.glob("*.sj"))
        example = f"; name a file in it, such as {games[0]}" if games else ""
        return f"`{name}` is a folder, and a game is wanted{example}"
    file = Path(f"{name}.sj")
    if file.is_file():
        return (
            f"there is no bundled game `{name}`; for the file beside you write its whole name: "
            f"`{file}`"
        )
    suggestion = meant(name, bundled(), "the bundled games are")
    return f"there is no bundled game `{name}`, and no file of that name{suggestion}"
