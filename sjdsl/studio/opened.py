"""The text of a game as it is opened: checked rules in the chosen variant, with the numbers somebody has set."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from sjdsl.compiler import Build, build_composition, ir
from sjdsl.compiler.compose import Composition, compose
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.elaborate import Overrides
from sjdsl.interpreter.numbers import real
from sjdsl.interpreter.state import Value
from sjdsl.library.parameters import param_values, split_sizes


@dataclass(frozen=True)
class Opened:
    """A checked game. values: of every param, as the interpreter has them; left: numbers that were set and that this text does not take."""

    source: Source
    composition: Composition
    build: Build
    values: dict[str, Value]
    left: tuple[str, ...] = ()

    @property
    def game(self) -> ir.Game:
        return self.build.game


def open_text(
    source: Source, variants: tuple[str, ...], agents: int | None, params: Mapping[str, Any]
) -> Opened:
    """Returns the game of a text. Raises CompileError with every problem of the failing stage.

    agents: None for as many as the file says; params: numbers by name, sizes among them.
    Numbers that the text no longer takes, for it has no such name, other limits or another `require`, are left out and named.
    """
    composition = compose(source, variants)
    names = composition.number_names()
    known = {name for of in names for name in of}
    left = [name for name in params if name not in known]
    sizes, rest = split_sizes(
        *names, {name: value for name, value in params.items() if name in known}
    )
    build = build_composition(composition, Overrides(sizes, agents))
    taken: dict[str, Any] = {}
    for name, value in rest.items():
        try:
            param_values(build.game, {**taken, name: value}, check_requires=False)
            taken[name] = value
        except ValueError:
            left.append(name)
    while True:
        try:
            values = interpreted_values(build.game, taken)
            break
        except (
            ValueError
        ):  # a `require` of several numbers, each of which is allowed: the last one set goes first
            if not taken:
                raise
            left.append(taken.popitem()[0])
    return Opened(source, composition, build, values, tuple(left))


def interpreted_values(game: ir.Game, given: Mapping[str, Any]) -> dict[str, Value]:
    """Returns the value of every param as the interpreter has it; `given`: of some. Raises ValueError for one that the game does not take."""
    reals = {param.name for param in game.params if param.type.kind == "real"}
    return {
        name: real(value) if name in reals else value
        for name, value in param_values(game, given).items()
    }
