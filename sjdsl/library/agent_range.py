"""Finds how many agents a game can have on its map: the limits of its file, as far as the compiler accepts them."""

from collections.abc import Callable

from sjdsl.compiler import ast, build_composition
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import CompileError, Diagnostic
from sjdsl.compiler.diagnostics.limits import MAX_AGENTS
from sjdsl.compiler.elaborate import Overrides

ROOM = (errors.TooFewCells, errors.TooFewFreeCells, errors.TooFewToStart)  # they say how many cells there are, and for how many


def number_of_agents(game: Composition) -> ast.Constant | None:
    """Returns the size that is the number of agents, None if that is no plain size."""
    number = game.number
    if not isinstance(number, ast.Path) or number.steps:
        return None
    return game.constants.get(number.name.text)


def agent_range(composed: Composition, own: int | None = None) -> tuple[str, int, int] | None:
    """Returns the name of the size that is the number of agents, and the least and the greatest number that is accepted.

    own: how many agents the game has as it is, for callers that have built it. None is returned if the number of agents is no size with
    limits. All numbers between are accepted too, unless a `require` of the game excludes some. Raises CompileError: the game itself is wrong.
    """
    size = number_of_agents(composed)
    if size is None or size.low is None:
        return None
    if own is None:
        own = build_composition(composed).game.agents.number

    def refused(number: int) -> list[Diagnostic]:
        try:
            build_composition(composed, Overrides(num_agents=number))
        except CompileError as error:
            return [d for d in error.diagnostics if d.severity == "error"]
        return []

    least, most = (size.low, 1), (size.high, MAX_AGENTS)
    low, high = (bound.value if isinstance(bound, ast.Int) else otherwise for bound, otherwise in (least, most))
    fewest = -_farthest(-own, 1 - max(low, 1), lambda n: _too_many(refused(-n)))
    return size.name.text, fewest, _farthest(own, min(high, MAX_AGENTS) + 1, lambda n: _too_many(refused(n)))


def _farthest(accepted: int, refused: int, too_many: Callable[[int], int | None]) -> int:
    """Returns the last number that is accepted between one that is and one that is not.

    The limit of the file is tried first, for most games have room for all; where they have not, the number for which they seem to have.
    too_many: of a number, by how many it seems to be too many: 0 if it is accepted, None if nobody knows.
    """
    guess = refused - 1
    while refused - accepted > 1:
        surplus = too_many(guess)
        if surplus == 0:
            accepted, guess = guess, guess + 1
        else:
            refused = guess
            guess = (accepted + refused) // 2 if surplus is None else max(guess - surplus, accepted + 1)
    return accepted


def _too_many(problems: list[Diagnostic]) -> int | None:
    """Returns by how many agents are too many, as far as the messages tell.

    Limits and the room on the map refuse all numbers beyond the first that they refuse. A `require` may refuse any: then each is tried.
    """
    if not problems:
        return 0
    if any(isinstance(d, errors.RequireFalse) for d in problems):
        return 1
    return max((max(1, d.agents - d.cells) for d in problems if isinstance(d, ROOM)), default=None)
