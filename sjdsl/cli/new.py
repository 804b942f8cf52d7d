"""`sjdsl new`: writes the files of a new game: a small playable game and its tests."""

from pathlib import Path

import click

from sjdsl.cli.folders import require_folder
from sjdsl.cli.list import align
from sjdsl.games_folder import bundled
from sjdsl.starter import starting_files


@click.command("new")
@click.argument("name")
@click.option("-o", "folder", metavar="FOLDER", default=".", help="Where to write; by default here.")
def command(name: str, folder: str) -> int:
    """Writes NAME.sj, a small commented game, with its map and tests that pass."""
    try:
        texts = starting_files(name)
    except ValueError as error:
        raise click.ClickException(str(error)) from None
    paths = {Path(folder) / file: text for file, text in texts.items()}
    for path in paths:
        if path.exists():
            raise click.ClickException(f"{path} is there already; nothing was written")
    require_folder(Path(folder))
    for path, text in paths.items():
        path.write_text(text, encoding="utf-8", newline="\n")
        click.echo(path)
    if name in bundled():
        click.echo(
            f"note: there is a bundled game {name} as well. To the commands `{name}` means that one, and `{name}.sj` means yours; "
            "another name would keep them apart"
        )
    game, _, tests = paths
    for line in align([("next:", ""), *next_steps(game, tests)]):
        click.echo(line)
    return 0


def next_steps(game: Path, tests: Path) -> list[tuple[str, str]]:
    """Returns what can be done with a new game, and what each command does and needs."""
    return [
        (f"  sjdsl play {game}", "steer an agent; needs a terminal"),
        (f"  sjdsl check {game}", "after each change: what is wrong with it"),
        (f"  sjdsl test {game}", "test its checks"),
        (f"  pytest {tests}", "its tests; needs pytest (pip install pytest), in the same Python environment as sjdsl"),
        (f"  sjdsl train {game} --preset two_cores", "agents that learn in it; takes minutes on two cores"),
        (
            f"  sjdsl schelling {game} --cooperators cooperator --defectors defector -o schelling",
            "is it a dilemma for the file's own policies?",
        ),
    ]
