"""`sjdsl dump`: prints a game after one stage of the compiler."""

import click

from sjdsl.cli.game_file import open_game, split_variants, variant_option
from sjdsl.compiler import STAGES, dump


@click.command("dump")
@click.argument("file")
@click.option("--after", "stage", type=click.Choice(STAGES), required=True, help="The last stage to run.")
@variant_option
@click.option("--no-positions", is_flag=True, help="Leave out the source positions.")
def command(file: str, stage: str, variant: str | None, no_positions: bool) -> None:
    """Prints FILE as it is after one stage of the compiler; equal games give equal text."""
    for line in dump(open_game(file), stage, split_variants(variant), positions=not no_positions):
        click.echo(line)
