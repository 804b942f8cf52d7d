"""`sjdsl new`: the files that a game starts with."""

from pathlib import Path

import click

from sjdsl.cli.folders import require_folder
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
    first = next(iter(paths))
    click.echo(f"next: sjdsl play {first}   pytest {Path(folder) / f'test_{name}.py'}   sjdsl train {first}")
    return 0
