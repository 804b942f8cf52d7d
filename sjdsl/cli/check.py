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

DiagnosticsByVariant = dict[tuple[str, ...], list[Diagnostic]]


@click.command("check")
@click.argument("files", nargs=-1, required=True, metavar="FILE...")
@variant_option
@click.option("--strict", is_flag=True, help="Exit with 1 if there is a warning.")
@click.option("--json", "as_json", is_flag=True, help="Print the diagnostics as JSON.")
def command(files: tuple[str, ...], variant: str | None, strict: bool, as_json: bool) -> int:
    """Reports all mistakes in games: FILE is a `.sj` file or the name of a bundled game.

    Without --variant, the game itself and each of its variants are checked. The exit status is 1 if
    there is an error; warnings count only with --strict.
    """
    diagnostics: list[Diagnostic] = []  # of all files
    for file in files:
        try:
            problems = find_problems(open_game(file), variant)
        except CompileError as error:  # the file can't be read
            problems = {(): list(error.diagnostics)}
        for of_variant in problems.values():
            diagnostics += of_variant
        if not as_json:
            _print_problems(file, problems)
    if as_json:
        click.echo(json.dumps(to_json(diagnostics, texts_of(diagnostics)), indent=2))
    return int(any(strict or diagnostic.severity == "error" for diagnostic in diagnostics))


def find_problems(source: Source, variant: str | None = None) -> DiagnosticsByVariant:
    """Returns the diagnostics of a game by variant, in the order of the file.

    Each diagnostic is listed once, with the first variant that has it.
    """
    if variant is not None:
        names = split_variants(variant)
        return {names: list(check(source, names))}
    problems: DiagnosticsByVariant = {}
    known = set()  # the labels of a diagnostic don't count: they may differ between variants
    for names, diagnostics in check_variants(source):
        problems[names] = [d for d in diagnostics if (d.code, d.span, d.message) not in known]
        known |= {(d.code, d.span, d.message) for d in diagnostics}
    return problems


def _print_problems(file: str, problems: DiagnosticsByVariant) -> None:
    """Prints the diagnostics of a file, variant by variant, or that it has none."""
    for names, diagnostics in problems.items():
        if diagnostics and names and len(problems) > 1:
            click.echo(f"in variant `{'+'.join(names)}` of {file}:\n")
        print_diagnostics(diagnostics)
    if not any(problems.values()):
        variants = ["+".join(names) for names in problems if names]
        plural = "s" if len(variants) > 1 else ""
        checked = f", with variant{plural} {', '.join(variants)}" if variants else ""
        click.echo(f"{file}: no problems{checked}")
