"""The compiler: one `.sj` text becomes one readable Python module, stage by stage.

Source -> Composition -> ir.Game -> Program -> text
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

from sjdsl.compiler import ir
from sjdsl.compiler.checks.declarations import check_state_names, check_timers, check_unused
from sjdsl.compiler.checks.placement import check_placement
from sjdsl.compiler.checks.policies import check_policies
from sjdsl.compiler.checks.whole_numbers import check_whole_numbers
from sjdsl.compiler.checks.write_conflicts import check_conflicts
from sjdsl.compiler.compose import Composition, compose
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import CompileError, Diagnostic
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.elaborate import Overrides, elaborate
from sjdsl.compiler.elaborate.declaration_labels import with_declaration_labels
from sjdsl.compiler.ir.hash import printed_digest
from sjdsl.compiler.lower import NotSupported, lower
from sjdsl.compiler.program import Program


class Build(Record):
    """A checked game: its typed rules, the warnings, and the texts they came from by name."""

    game: ir.Game
    warnings: tuple[Diagnostic, ...]
    sources: dict[str, Source]


def compile_source(source: Source, variants: Sequence[str] = ()) -> str:
    """Returns the Python module for one `.sj` file.

    Raises CompileError with every problem of the failing stage.
    """
    return compile_build(build(source, variants), source)


def build(
    source: Source, variants: Sequence[str] = (), overrides: Overrides | None = None
) -> Build:
    """Returns the typed rules of a game in a variant.

    Raises CompileError with every problem of the failing stage.
    """
    return build_composition(compose(source, variants), overrides)


def build_composition(composition: Composition, overrides: Overrides | None = None) -> Build:
    """Returns the typed rules of a game that is put together.

    Raises CompileError with every problem of the failing stage.
    """
    problems = Problems()
    overrides = overrides or Overrides()
    game, declarations = elaborate(composition, overrides, problems)
    if game is not None:
        check_state_names(game, problems)
        check_timers(game, composition, problems)
        check_conflicts(game, problems)
        check_policies(game, composition.sources, problems)
    if game is not None and game.rows and not problems.failed:
        if not overrides.placed_by_hand:
            check_placement(game, composition.sources, problems)
        check_whole_numbers(game, problems)
    if game is not None and not problems.failed:
        check_unused(game, declarations, composition, problems)
    diagnostics = with_declaration_labels(problems.diagnostics, composition)
    if game is None or problems.failed:
        raise CompileError(diagnostics)
    return Build(game, tuple(diagnostics), composition.sources)


def lower_build(built: Build, source: Source) -> Program:
    """Returns the array program of a checked game.

    Raises CompileError for what cannot be compiled exactly.
    """
    try:
        return lower(built.game.rules, Path(source.name).name, built.sources)
    except NotSupported as refused:
        span = refused.origin or source.span(0, 0)
        unsupported = errors.Unsupported(span, feature=refused.feature, help=refused.instead)
        raise CompileError([unsupported]) from None


def compile_build(built: Build, source: Source) -> str:
    """Returns the Python module of a checked game."""
    from sjdsl.compiler.emit.module import render

    return render(lower_build(built, source))


def compile_rules(built: Build) -> str:
    """Returns the Python module of a checked game without the files and lines of its text.

    Games of the same rules have the same.
    """
    from sjdsl.compiler.emit.module import render

    program = lower_build(replace(built, sources={}), Source(f"the rules of {built.game.name}", ""))
    functions = tuple(
        replace(f, body=tuple(replace(statement, origin=None) for statement in f.body))
        for f in program.functions
    )
    numbers = tuple(replace(n, comment="") if n.group == "stream" else n for n in program.numbers)
    return render(replace(program, functions=functions, numbers=numbers))


def check(source: Source, variants: Sequence[str] = ()) -> tuple[Diagnostic, ...]:
    """Returns every error and warning of a file, in file order; what compiles has no errors."""
    try:
        composition = compose(source, variants)
    except CompileError as error:
        return error.diagnostics
    return check_composition(composition)


def check_composition(
    composition: Composition, overrides: Overrides | None = None
) -> tuple[Diagnostic, ...]:
    """Returns every error and warning of a game that is put together, in file order.

    Its `references` are then known.
    """
    try:
        built = build_composition(composition, overrides)
        _lowered(_Rules(built, composition.sources[composition.file]))
    except CompileError as error:
        return error.diagnostics
    return CompileError(built.warnings).diagnostics


class _Rules:
    """A checked game, equal to others by its rules.

    Where they are written makes no difference to whether they can be lowered.
    """

    def __init__(self, built: Build, source: Source) -> None:
        self.built = built
        self.source = source
        self._digest = printed_digest(built.game)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Rules) and self._digest == other._digest

    def __hash__(self) -> int:
        return hash(self._digest)


# An edit of a remark, a scene or one variant leaves most rules as they were; those refused are not
# kept.
@lru_cache(maxsize=16)
def _lowered(rules: _Rules) -> None:
    """Lowers a game, to see whether that can be done. Raises CompileError."""
    lower_build(rules.built, rules.source)


def check_variants(source: Source) -> Iterator[tuple[tuple[str, ...], tuple[Diagnostic, ...]]]:
    """Yields every error and warning of a file: as it is, then in each of its variants."""
    try:
        names = [(), *((name,) for name in compose(source).variants)]
    except CompileError as error:
        yield (), error.diagnostics
        return
    for name in names:
        yield name, check(source, name)
