"""`sjdsl new`: writes the files of a new game, a small playable game and its tests, or a copy of
another.
"""

from collections.abc import Mapping
from pathlib import Path

import click

from sjdsl.cli.folders import require_folder
from sjdsl.cli.game_file import game_path
from sjdsl.cli.next_commands import echo_next
from sjdsl.files import write_whole
from sjdsl.library.games_folder import bundled
from sjdsl.library.starter import copied_files, starting_files


@click.command("new")
@click.argument("name", required=False)
@click.option(
    "--from",
    "copied",
    metavar="GAME",
    help="Copy a game with its maps and the games that it extends, as NAME.",
)
@click.option(
    "-o", "folder", metavar="FOLDER", default=".", help="Where to write; by default this folder."
)
def command(name: str | None, copied: str | None, folder: str) -> None:
    """Writes NAME.sj, a small commented game, with its map and tests that pass.

    With --from, NAME.sj is a copy of another game, such as `--from clean_up`, for your own game to
    extend.
    """
    if copied is not None:
        origin = game_path(copied)
        try:
            texts = copied_files(origin, name or origin.stem)
        except ValueError as error:
            raise click.ClickException(str(error)) from None
        game, *_ = _write(Path(folder), texts)
        echo_next(
            (f"sjdsl check {game}", "after each change: what is wrong with it"),
            (f"sjdsl play {game}", "control an agent"),
            (
                f'game mine extends "{game.name}" {{ … }}',
                "or, in a file beside it: only what you change",
            ),
        )
        return
    if name is None:
        raise click.UsageError("Missing argument 'NAME'.")
    try:
        texts = starting_files(name)
    except ValueError as error:
        raise click.ClickException(str(error)) from None
    game, *_, tests = _write(Path(folder), texts)
    if name in bundled():
        click.echo(
            f"note: there is a bundled game {name} as well. In commands, `{name}` means that one, "
            f"and `{name}.sj` means yours; another name would keep them apart"
        )
    echo_next(
        (f"sjdsl play {game}", "control an agent"),
        (f"sjdsl check {game}", "after each change: what is wrong with it"),
        (f"sjdsl test {game}", "test its checks"),
        (
            f"pytest {tests}",
            "its tests; needs pytest (pip install pytest), in the same Python environment as sjdsl",
        ),
        (
            f"sjdsl train {game} --preset two_cores",
            "agents that learn in it; takes minutes on two cores",
        ),
        (
            f"sjdsl schelling {game} --cooperators cooperator --defectors defector -o schelling",
            "is it a dilemma for the file's own policies?",
        ),
    )


def _write(folder: Path, texts: Mapping[str, str]) -> list[Path]:
    """Writes files into a folder and prints their paths. Raises ClickException if one of them
    exists.
    """
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
