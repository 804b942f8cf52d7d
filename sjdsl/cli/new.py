"""`sjdsl new`: writes the files of a new game, a small playable game and its tests, or of a package with one."""

from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path

import click

from sjdsl.cli.folders import require_folder
from sjdsl.cli.game_file import game_path
from sjdsl.cli.list import align
from sjdsl.files import write_whole
from sjdsl.library.games_folder import bundled, game_names
from sjdsl.library.starter import copied_files, game_of, package_files, starting_files


@click.command("new")
@click.argument("name", required=False)
@click.option("--from", "copied", metavar="GAME", help="Copy a game with its maps and the games that it extends, as NAME.")
@click.option("--package", "as_package", is_flag=True, help="Make a Python package NAME that others can install.")
@click.option("-o", "folder", metavar="FOLDER", default=".", help="Where to write; by default this folder.")
def command(name: str | None, copied: str | None, as_package: bool, folder: str) -> None:
    """Writes NAME.sj, a small commented game, with its map and tests that pass.

    With --from, NAME.sj is a copy of another game, such as `--from clean_up`, for your own game to extend.

    With --package, NAME is a package of games, such as river_games, in a folder of its own: the game (river), its tests, a pyproject.toml
    for `pip`, and a workflow that tests it on GitHub. Once it is installed, all commands and `sjdsl.make` find the game by name.
    """
    if copied is not None:
        _copy(copied, name, as_package, Path(folder))
        return
    if name is None:
        raise click.UsageError("Missing argument 'NAME'.")
    try:
        texts = package_files(name) if as_package else starting_files(name)
    except ValueError as error:
        raise click.ClickException(str(error)) from None
    if as_package:
        _new_package(name, Path(folder) / name, texts)
    else:
        _new_game(name, Path(folder), texts)


def _copy(copied: str, name: str | None, as_package: bool, folder: Path) -> None:
    if as_package:
        raise click.UsageError("--from copies a game, and --package writes a new one: give only one of them")
    path = game_path(copied)
    name = name or path.stem
    try:
        texts = copied_files(path, name)
    except ValueError as error:
        raise click.ClickException(str(error)) from None
    game, *_ = _write(folder, texts)
    print_next(
        (f"  sjdsl check {game}", "after each change: what is wrong with it"),
        (f"  sjdsl play {game}", "control an agent"),
        (f'  game mine extends "{game.name}" {{ … }}', "or, in a file beside it: only what you change"),
    )


def _new_game(name: str, folder: Path, texts: Mapping[str, str]) -> None:
    game, _, tests = _write(folder, texts)
    if name in game_names():
        click.echo(
            f"note: there is {_kind(name)} game {name} as well. In commands, `{name}` means that one, and `{name}.sj` means yours; "
            "another name would keep them apart"
        )
    print_next(
        (f"  sjdsl play {game}", "control an agent"),
        (f"  sjdsl check {game}", "after each change: what is wrong with it"),
        (f"  sjdsl test {game}", "test its checks"),
        (f"  pytest {tests}", "its tests; needs pytest (pip install pytest), in the same Python environment as sjdsl"),
        (f"  sjdsl train {game} --preset two_cores", "agents that learn in it; takes minutes on two cores"),
        (
            f"  sjdsl schelling {game} --cooperators cooperator --defectors defector -o schelling",
            "is it a dilemma for the file's own policies?",
        ),
    )


def _new_package(package: str, folder: Path, texts: Mapping[str, str]) -> None:
    name = game_of(package)
    if name in game_names():
        raise click.ClickException(f"there is {_kind(name)} game `{name}` already, and names are unique: choose another")
    there = find_spec(package)
    if there is not None and there.origin is not None:
        raise click.ClickException(f"there is a Python package `{package}` already, {there.origin}: choose another name")
    if folder.exists():
        raise click.ClickException(f"{folder} exists already; nothing was written")
    require_folder(folder.parent)
    folder.mkdir()
    _write(folder, texts)
    print_next(
        (f"  cd {folder}", ""),
        ("  pip install -e '.[test]'", "in the same Python environment as sjdsl; its files stay here, and can be changed"),
        ("  pytest", "its scenes, and the checks of its games"),
        (f"  sjdsl doc {name}", "from now on every command knows the game by its name"),
        (f"  sjdsl studio src/{package}/{name}.sj", "change it"),
    )


def print_next(*steps: tuple[str, str]) -> None:
    """Prints the commands to run next, each with its purpose."""
    click.echo("\n".join(align([("next:", ""), *steps])))


def _kind(name: str) -> str:
    return "a bundled" if name in bundled() else "an installed"


def _write(folder: Path, texts: Mapping[str, str]) -> list[Path]:
    """Writes files into a folder and prints their paths. Raises ClickException if one of them exists."""
    paths = {folder / file: text for file, text in texts.items()}
    for path in paths:
        if path.exists():
            raise click.ClickException(f"{path} exists already; nothing was written")
    require_folder(folder)
    for path, text in paths.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, text)
        click.echo(path)
    return list(paths)
