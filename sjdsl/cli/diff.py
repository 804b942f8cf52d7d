"""`sjdsl diff`: prints what differs between two variants of a game, or between two games."""

import click

from sjdsl.cli.game_file import open_game
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.doc import Written, read_written, report
from sjdsl.library.checked_game import split_variants
from sjdsl.near_names import meant

DEFAULT = "default"


@click.command("diff")
@click.argument("games", nargs=-1, required=True, metavar="GAME [OTHER]")
@click.option(
    "--variants",
    nargs=2,
    metavar="A B",
    help="The variants to compare; `default` is the game without one.",
)
def command(games: tuple[str, ...], variants: tuple[str, str] | None) -> None:
    """Prints the numbers and declarations that differ between two variants of GAME, or between GAME
    and OTHER.

    A game is a `.sj` file or the name of a bundled one. Layout, comments and the order of
    declarations don't count as differences.
    """
    if len(games) > 2 or (len(games) == 1 and variants is None):
        raise click.UsageError("name two games, or one game and two variants (--variants A B)")
    old_variant, new_variant = variants or (DEFAULT, DEFAULT)
    old = read_variant(open_game(games[0]), old_variant)
    new = read_variant(open_game(games[-1]), new_variant)
    click.echo(report(old, new), nl=False)


def read_variant(source: Source, variant: str) -> Written:
    """Returns a game in a variant (`a+b`: in both).

    Raises ClickException for a variant that the game doesn't have, CompileError for mistakes.
    """
    plain = read_written(source)
    if variant == DEFAULT:
        return plain
    names = split_variants(variant)
    known = [DEFAULT, *(declared for declared, _ in plain.variants)]
    for name in names:
        if name not in known[1:]:
            raise click.ClickException(
                f"`{plain.file}` has no variant `{name}`{meant(name, known, 'its variants are')}"
            )
    return read_written(source, names)
