"""`sjdsl doc`: prints the rules of a game in plain English, and writes the page of all bundled games."""

from pathlib import Path

import click

from sjdsl.cli.folders import require_folder_of
from sjdsl.cli.game_file import open_game, split_variants, variant_option
from sjdsl.cli.games_page import PAGE, make_page, page_problems, write_text
from sjdsl.doc import read_written, rule_sheet


@click.command("doc")
@click.argument("game", required=False)
@variant_option
@click.option("-o", "output", metavar="FILE", help="Where to write, instead of printing; with --all, instead of docs/games.md.")
@click.option("--all", "everything", is_flag=True, help="The page of all bundled games, with pictures and figures.")
@click.option("--fresh", is_flag=True, help="With --all: measure and draw again, also if the rules have not changed.")
@click.option("--check", "only_check", is_flag=True, help="With --all: write nothing; exit with 1 if the page is not up to date.")
def command(game: str | None, variant: str | None, output: str | None, everything: bool, fresh: bool, only_check: bool) -> int:
    """Prints the rule sheet of GAME, a `.sj` file or a bundled game: its rules in words, in the order of the ODD protocol."""
    if everything == (game is not None) or (everything and variant) or ((fresh or only_check) and not everything):
        raise click.UsageError("name one game, perhaps with a variant, or say --all", click.get_current_context())
    if everything:
        return _page(Path(output or PAGE), fresh, only_check)

    if output is not None:
        require_folder_of(Path(output))
    text = rule_sheet(read_written(open_game(game or ""), split_variants(variant)))
    if output is None:
        click.echo(text, nl=False)
    else:
        write_text(Path(output), text)
        click.echo(f"{output}  {len(text.splitlines())} lines")
    return 0


def _page(path: Path, fresh: bool, only_check: bool) -> int:
    if not only_check:
        make_page(path, fresh)
        return 0
    problems = page_problems(path)
    for problem in problems:
        click.echo(problem)
    click.echo(f"`sjdsl doc --all -o {path}` brings it up to date" if problems else f"{path} is up to date")
    return int(bool(problems))
