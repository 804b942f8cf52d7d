"""`sjdsl check`: prints all mistakes in a game and in each of its variants."""

import json

import click

from sjdsl.cli.diagnostics import print_diagnostics, texts_of
from sjdsl.cli.game_file import open_game, variant_option
from sjdsl.compiler import check, check_variants
from sjdsl.compiler.diagnostics.diagnostic import CompileError, Diagnostic
from sjdsl.compiler.diagnostics.report import to_json
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.library.checked_game import split_variants

Found = dict[tuple[str, ...], list[Diagnostic]]


@click.command("check")
@click.argument("files", nargs=-1, required=True, metavar="FILE...")
@variant_option
@click.option("--strict", is_flag=True, help="Exit with 1 if there is a warning.")
@click.option("--json", "as_json", is_flag=True, help="Print the diagnostics as JSON.")
def command(files: tuple[str, ...], variant: str | None, strict: bool, as_json: bool) -> int:
    """Reports all mistakes in games: FILE is a `.sj` file or the name of a bundled game.

    Without --variant, the game itself and each of its variants are checked. The exit status is 1 if there is an error; warnings
    count only with --strict.
    """
    everything: list[Diagnostic] = []
    for file in files:
        try:
            source = open_game(file)
            found = find_problems(source, variant)
        except CompileError as error:  # unreadable
            found = {(): list(error.diagnostics)}
        everything += [d for problems in found.values() for d in problems]
        if not as_json:
            _print_problems(file, found)
    if as_json:
        click.echo(json.dumps(to_json(everything, texts_of(everything)), indent=2))
    return int(any(strict or d.severity == "error" for d in everything))


def find_problems(source: Source, variant: str | None = None) -> Found:
    """Returns the diagnostics of a game by variant, in the order of the file; each is listed once, with the first variant that has it."""
    if variant is not None:
        chosen = split_variants(variant)
        return {chosen: list(check(source, chosen))}
    found: Found = {}
    known = set()  # by these alone: in each variant a label may point elsewhere
    for name, problems in check_variants(source):
        found[name] = [d for d in problems if (d.code, d.span, d.message) not in known]
        known |= {(d.code, d.span, d.message) for d in problems}
    return found


def _print_problems(file: str, found: Found) -> None:
    for name, problems in found.items():
        if problems and name and len(found) > 1:
            click.echo(f"in variant `{'+'.join(name)}` of {file}:\n")
        print_diagnostics(problems)
    if not any(found.values()):
        variants = ["+".join(name) for name in found if name]
        beside = (
            f", with variant{'s' if len(variants) > 1 else ''} {', '.join(variants)}"
            if variants
            else ""
        )
        click.echo(f"{file}: no problems{beside}")
