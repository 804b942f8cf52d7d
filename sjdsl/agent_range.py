"""Finds how many agents a game can have on its map: the limits of its file, as far as the compiler accepts them."""

from collections.abc import Callable

from sjdsl.compiler import ast, build_composition
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.elaborate import Overrides


def number_of_agents(game: Composition) -> ast.Constant | None:
    """Returns the size that is the number of agents, None if that is no plain size."""
    number = game.number
    if not isinstance(number, ast.Path) or number.steps:
        return None
    return game.constants.get(number.name.text)


def agent_range(composed: Composition) -> tuple[str, int, int] | None:
    """Returns the name of the size that is the number of agents, and the least and the greatest number that is accepted.

    None if the number of agents is no size with limits. All numbers between are accepted too, unless a `require` of the game excludes some.
    Raises CompileError: the game itself is wrong.
    """
    size = number_of_agents(composed)
    if size is None or size.low is None:
        return None
    own = build_composition(composed).game.agents.number

    def is_accepted(number: int) -> bool:
        try:
            return build_composition(composed, Overrides(num_agents=number)).game.agents.number == number
        except CompileError:
            return False

    return size.name.text, -_farthest(-own, lambda n: is_accepted(-n)), _farthest(own, is_accepted)


def _farthest(known: int, is_accepted: Callable[[int], bool]) -> int:
    """Returns the last number from one that is accepted on, of those that follow, that is accepted."""
    step = 1
    while is_accepted(known + step):
        known, step = known + step, step * 2
    refused = known + step
    while refused - known > 1:
        middle = (known + refused) // 2
        known, refused = (middle, refused) if is_accepted(middle) else (known, middle)
    return known
