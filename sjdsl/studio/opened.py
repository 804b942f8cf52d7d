"""A game that is open: its checked rules with the chosen variants and the params that are set."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from sjdsl.compiler import Build, ast, build_composition, ir
from sjdsl.compiler.compose import Composition, compose
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.elaborate import Overrides
from sjdsl.interpreter.numbers import real
from sjdsl.interpreter.state import Value
from sjdsl.library.parameters import param_values, split_sizes
from sjdsl.library.tasks import with_tasks


@dataclass(frozen=True)
class Opened:
    """A checked game.

    values: of every param, as the interpreter has them; left: the names of params and sizes that
    were set but don't fit this text.
    """

    source: Source
    composition: Composition
    build: Build
    values: dict[str, Value]
    left: tuple[str, ...] = ()

    @property
    def game(self) -> ir.Game:
        return self.build.game

    @property
    def agents_are_free(self) -> bool:
        """Whether a `size` of the file says how many agents there are."""
        return isinstance(self.composition.number, ast.Path)


def open_text(
    source: Source, variants: tuple[str, ...], agents: int | None, params: Mapping[str, Any]
) -> Opened:
    """Returns the game of a text, with the tasks that `sjdsl.make` plays by default.

    Args:
      agents: how many, None for as many as the file says.
      params: values of params and sizes. Those that don't fit the text, because it has no such
        name, other limits or another `require`, are left out and named in the result.

    Raises:
      CompileError: with every problem of the failing stage.
    """
    composition = compose(source, variants)
    names = composition.number_names()
    known = set[str]().union(*names)
    left = [name for name in params if name not in known]
    fitting = {name: value for name, value in params.items() if name in known}
    sizes, candidates = split_sizes(*names, fitting)
    build = build_composition(composition, Overrides(sizes, agents))
    build = replace(build, game=with_tasks(build.game))
    accepted: dict[str, Any] = {}
    for name, value in candidates.items():
        try:
            param_values(build.game, {**accepted, name: value}, check_requires=False)
            accepted[name] = value
        except ValueError:
            left.append(name)
    while True:
        try:
            values = interpreted_values(build.game, accepted)
            break
        except ValueError:  # a `require` of several params: drop the one that was set last
            if not accepted:
                raise
            left.append(accepted.popitem()[0])
    return Opened(source, composition, build, values, tuple(left))


def interpreted_values(game: ir.Game, params: Mapping[str, Any]) -> dict[str, Value]:
    """Returns the value of every param as the interpreter has it.

    Args:
      params: values that differ from the game's.

    Raises:
      ValueError: the game doesn't accept a value.
    """
    reals = {param.name for param in game.params if param.type.kind == "real"}
    return {
        name: real(value) if name in reals else value
        for name, value in param_values(game, params).items()
    }
