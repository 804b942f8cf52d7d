"""`sjdsl dump`: prints a game after one stage of the compiler."""

from collections.abc import Iterator, Sequence

import click

from sjdsl.cli.game_file import open_game, variant_option
from sjdsl.compiler import build, compile_build, lower_build
from sjdsl.compiler.ast import printer as ast_printer
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.emit.listing import listing
from sjdsl.compiler.ir import printer as ir_printer
from sjdsl.compiler.syntax.parse import parse
from sjdsl.library.checked_game import split_variants

STAGES = ("ast", "ir", "program", "python")


@click.command("dump")
@click.argument("file")
@click.option(
    "--after", "stage", type=click.Choice(STAGES), required=True, help="The last stage to run."
)
@variant_option
@click.option("--no-positions", is_flag=True, help="Leave out the source positions.")
def command(file: str, stage: str, variant: str | None, no_positions: bool) -> None:
    """Prints FILE as it is after one stage of the compiler; equal games give equal text."""
    for line in dump(open_game(file), stage, split_variants(variant), positions=not no_positions):
        click.echo(line)


def dump(
    source: Source, stage: str, variants: Sequence[str] = (), positions: bool = True
) -> Iterator[str]:
    """Yields a stage of the compiler as stable text, line by line; `positions` only matters to
    `ir`.
    """
    if stage == "ast":
        yield from ast_printer.lines(parse(source))
        return
    built = build(source, variants)
    match stage:
        case "ir":
            yield from ir_printer.game_text(built.game, positions).splitlines()
        case "program":
            yield from listing(lower_build(built, source))
        case "python":
            yield from compile_build(built, source).splitlines()
        case _:
            raise ValueError(f"no stage `{stage}`; the stages are {', '.join(STAGES)}")
