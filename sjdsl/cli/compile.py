"""`sjdsl compile`: writes games as Python modules to `generated/`, or checks that those there are
up to date.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import click

from sjdsl.cli.diagnostics import print_diagnostics
from sjdsl.cli.folders import require_folder
from sjdsl.cli.game_file import game_path, map_option, variant_option
from sjdsl.compiler import build, lower_build
from sjdsl.compiler.diagnostics.diagnostic import CompileError, Diagnostic
from sjdsl.compiler.elaborate import Overrides
from sjdsl.compiler.emit.module import render
from sjdsl.compiler.emit.standalone import standalone
from sjdsl.compiler.syntax.read import read_source
from sjdsl.files import write_whole
from sjdsl.library.checked_game import map_rows, split_variants

FOLDER = Path("generated")


@dataclass(frozen=True)
class Module:
    """A generated module and where it belongs."""

    path: Path
    text: str

    @property
    def summary(self) -> str:
        """`generated/coins.py  13.0 kB  289 lines`."""
        size = len(self.text.encode()) / 1000
        lines = self.text.count("\n")
        return f"{self.path}  {size:.1f} kB  {lines} lines"


@click.command("compile")
@click.argument("files", nargs=-1, required=True, metavar="FILE...")
@click.option(
    "-o",
    "output",
    metavar="PATH",
    help="Where to write: a .py file, or a folder instead of generated/.",
)
@click.option(
    "--check",
    "only_check",
    is_flag=True,
    help="Write nothing; exit with 1 if a file is not up to date.",
)
@click.option(
    "--standalone",
    "is_standalone",
    is_flag=True,
    help="Write NAME_standalone.py, which needs only jax and numpy.",
)
@variant_option
@map_option
def command(
    files: tuple[str, ...],
    output: str | None,
    only_check: bool,
    is_standalone: bool,
    variant: str | None,
    map_file: str | None,
) -> int:
    """Writes each game as a Python module: generated/NAME.py, a variant as
    generated/NAME_VARIANT.py.

    FILE is a `.sj` file or the name of a bundled game. The same game gives the same bytes
    everywhere.
    """
    if output and only_check:
        raise click.UsageError("--check writes nothing: leave out -o")
    if is_standalone and only_check:
        raise click.UsageError(
            "--check looks only at the modules in generated/: leave out --standalone"
        )
    modules = compile_games(files, variant, map_file, output, is_standalone)
    paths = [module.path for module in modules]
    if clash := next((path for path in paths if paths.count(path) > 1), None):
        raise click.ClickException(f"two of these games would be written to {clash}")
    if only_check:
        return _report_differences(modules)
    if output:
        require_folder(modules[0].path.parent)
    for module in modules:
        module.path.parent.mkdir(exist_ok=True)
        write_whole(module.path, module.text)
        click.echo(module.summary)
    return 0


def compile_games(
    names: Iterable[str],
    variant: str | None,
    map_file: str | None,
    output: str | None,
    is_standalone: bool,
) -> list[Module]:
    """Returns the modules of games. Raises CompileError with the faults of all of them."""
    modules: list[Module] = []
    diagnostics: list[Diagnostic] = []
    for name in names:
        try:
            modules.append(compile_game(name, variant, map_file, output, is_standalone))
        except CompileError as error:
            diagnostics += error.diagnostics
    if diagnostics:
        raise CompileError(diagnostics)
    return modules


def compile_game(
    name: str, variant: str | None, map_file: str | None, output: str | None, is_standalone: bool
) -> Module:
    """Returns the module of a game; its warnings go to the terminal. Raises CompileError."""
    source = read_source(game_path(name))
    variants = split_variants(variant)
    try:
        rows, row_spans = map_rows(map_file, source)
        overrides = Overrides(rows=rows, row_spans=row_spans)
        built = build(source, variants, overrides)
    except FileNotFoundError as error:
        raise click.ClickException(str(error)) from None
    print_diagnostics(built.warnings, built.sources, err=True)
    program = lower_build(built, source)
    stem = "_".join((built.game.name, *variants))
    if is_standalone:
        path = Path(output or ".")
        stem += "_standalone"
        text = standalone(program)
    else:
        path = Path(output or FOLDER)
        text = render(program)
    return Module(path if path.suffix == ".py" else path / f"{stem}.py", text)


def _report_differences(modules: list[Module]) -> int:
    """Prints which modules differ from their files; returns the exit status, 1 if one does."""
    is_current = True
    for module in modules:
        if not module.path.is_file():
            click.echo(f"{module.path} is missing")
            is_current = False
        elif module.path.read_bytes() != module.text.encode():
            click.echo(f"{module.path} differs from what its game compiles to now")
            is_current = False
    if is_current:
        click.echo(f"{len(modules)} generated files are up to date")
    else:
        click.echo("compile again to update them")
    return int(not is_current)
