"""The compiler: one `.sj` text becomes one readable Python module, stage by stage.

text -> ast.File -> Composition -> ir.Game -> ir.Game -> Program -> text
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from sjdsl.compiler import ast, ir
from sjdsl.compiler.checks.ways_out import with_ways_out
from sjdsl.compiler.compose import compose
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import CompileError, Diagnostic, near
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.compiler.elaborate import Overrides, elaborate
from sjdsl.compiler.optimise import PASSES, Pass, optimise
from sjdsl.compiler.program import Program
from sjdsl.compiler.syntax.parse import parse
from sjdsl.compiler.syntax.read import inside_folder, read_source

STAGES = ("ast", "ir", "optimised", "program", "python")


@dataclass(frozen=True)
class Build:
    """A checked game: its typed rules, the warnings, and the texts they came from by name."""

    game: ir.Game
    warnings: tuple[Diagnostic, ...]
    sources: dict[str, Source]


def build(source: Source, variants: Sequence[str] = (), overrides: Overrides | None = None) -> Build:
    """Returns the typed rules of a game in a variant. Raises CompileError with every problem of the failing stage."""
    game = compose(source, parse(source), tuple(variants), load_base)
    typed, found = elaborate(game, overrides or Overrides())
    if typed is None:
        raise CompileError(with_ways_out(found, source, game, lambda text: _attempt(replace(source, text=text), variants, overrides)))
    return Build(typed, tuple(found), game.sources)


def _attempt(source: Source, variants: Sequence[str], overrides: Overrides | None) -> list[Diagnostic]:
    """Returns the errors of a changed text."""
    try:
        game = compose(source, parse(source), tuple(variants), load_base)
        typed, found = elaborate(game, overrides or Overrides())
        if typed is not None:
            lower_build(Build(typed, (), game.sources), source)
    except CompileError as refused:
        found = list(refused.diagnostics)
    return [d for d in found if d.severity == "error"]


def number_names(source: Source, variants: Sequence[str] = ()) -> tuple[list[str], list[str]]:
    """Returns the names of a game's sizes and of its parameters, without checking the rest."""
    constants = compose(source, parse(source), tuple(variants), load_base).constants
    return [n for n, c in constants.items() if c.is_size], [n for n, c in constants.items() if not c.is_size]


def lower_build(made: Build, source: Source, passes: tuple[Pass, ...] = PASSES) -> Program:
    """Returns the array program of a checked game. Raises CompileError for what cannot be compiled exactly."""
    from sjdsl.compiler.lower import NotSupported, lower

    try:
        rules = made.game.model_copy(update={"looks": ()})
        return lower(optimise(rules, passes), Path(source.name).name)
    except NotSupported as refused:
        found = errors.Unsupported(refused.origin, what=refused.what, help=refused.instead)  # type: ignore[arg-type]
        raise CompileError([found]) from None


def compile_build(made: Build, source: Source, passes: tuple[Pass, ...] = PASSES) -> str:
    """Returns the Python module of a checked game."""
    from sjdsl.compiler.emit.module import render

    return render(lower_build(made, source, passes), made.game)


def compile_source(source: Source, variants: Sequence[str] = (), overrides: Overrides | None = None) -> str:
    """Returns the Python module for one `.sj` file. Raises CompileError with every problem of the failing stage."""
    return compile_build(build(source, variants, overrides), source)


def check(source: Source, variants: Sequence[str] = (), overrides: Overrides | None = None) -> tuple[Diagnostic, ...]:
    """Returns every error and warning of a file, in file order; what compiles has no errors."""
    try:
        made = build(source, variants, overrides)
        lower_build(made, source)
    except CompileError as error:
        return error.diagnostics
    return CompileError(made.warnings).diagnostics


def load_base(name: str, span: Span, source: Source) -> tuple[Source, ast.File]:
    """Returns the game a file `extends`, read from the file's own folder."""
    problems = Problems()
    path = inside_folder(name, span, source, problems)
    if path is None:
        raise CompileError(problems.found)
    if not path.is_file():
        beside = [p.name for p in path.parent.glob("*.sj")] if path.parent.is_dir() else []
        raise CompileError([errors.NoFile(span, name=name, near=near(path.name, beside))])
    found = read_source(path)
    base = Source((Path(source.name).parent / name).as_posix(), found.text, path.parent)
    return base, parse(base)


def dump(source: Source, stage: str, variants: Sequence[str] = (), positions: bool = True) -> Iterator[str]:
    """Yields a stage of the compiler as stable text, line by line; `positions` only matters to `ir` and `optimised`."""
    from sjdsl.compiler import program
    from sjdsl.compiler.ast import printer as ast_printer
    from sjdsl.compiler.ir import printer as ir_printer

    if stage == "ast":
        yield from ast_printer.lines(parse(source))
        return
    made = build(source, variants)
    match stage:
        case "ir":
            yield from ir_printer.game(made.game, positions).splitlines()
        case "optimised":
            yield from ir_printer.game(optimise(made.game), positions).splitlines()
        case "program":
            yield from program.dump(lower_build(made, source))
        case "python":
            yield from compile_build(made, source).splitlines()
        case _:
            raise ValueError(f"no stage `{stage}`; the stages are {', '.join(STAGES)}")
