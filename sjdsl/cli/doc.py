"""`sjdsl doc`: prints the rules of a game in plain English, and writes the pages of all bundled games."""

from pathlib import Path

import click

from sjdsl.cli.folders import require_folder_of
from sjdsl.cli.game_file import open_game, split_variants, variant_option
from sjdsl.cli.games_page import PAGE, make_page, page_problems
from sjdsl.cli.melting_pot_page import PAGE as MELTING_POT_PAGE
from sjdsl.cli.melting_pot_page import make_melting_pot_page, melting_pot_problems
from sjdsl.cli.page_text import write_text
from sjdsl.doc import read_written, rule_sheet


@click.command("doc")
@click.argument("game", required=False)
@variant_option
@click.option(
    "-o",
    "output",
    metavar="FILE",
    help="Write to this file instead of printing. With --all: write the page of the games here, and no other page.",
)
@click.option(
    "--all", "everything", is_flag=True, help="Write docs/games.md and docs/meltingpot.md: all bundled games, with pictures and figures."
)
@click.option("--fresh", is_flag=True, help="With --all: measure and draw again, also if the rules have not changed.")
@click.option("--check", "only_check", is_flag=True, help="With --all: write nothing; exit with 1 if the page is not up to date.")
def command(game: str | None, variant: str | None, output: str | None, everything: bool, fresh: bool, only_check: bool) -> int:
    """Prints the rule sheet of GAME, a `.sj` file or a bundled or installed game: its rules in words, in the order of the ODD protocol."""
    if everything == (game is not None) or (everything and variant) or ((fresh or only_check) and not everything):
        raise click.UsageError("name one game, perhaps with a variant, or say --all", click.get_current_context())
    if everything:
        return _pages(output, fresh, only_check)

    if output is not None:
        require_folder_of(Path(output))
    text = rule_sheet(read_written(open_game(game or ""), split_variants(variant)))
    if output is None:
        click.echo(text, nl=False)
    else:
        write_text(Path(output), text)
        click.echo(f"{output}  {len(text.splitlines())} lines")
    return 0


def _pages(output: str | None, fresh: bool, only_check: bool) -> int:
    """Writes or checks the page of the games and, unless that goes elsewhere, the page of Melting Pot's substrates."""
    path = Path(output or PAGE)
    if not only_check:
        make_page(path, fresh)
        if output is None:
            make_melting_pot_page(MELTING_POT_PAGE, fresh)
        return 0
    problems = [*page_problems(path), *(melting_pot_problems(MELTING_POT_PAGE) if output is None else [])]
    for problem in problems:
        click.echo(problem)
    again = "sjdsl doc --all" if output is None else f"sjdsl doc --all -o {path}"
    click.echo(f"`{again}` brings everything up to date" if problems else f"{path} is up to date")
    return int(bool(problems))
