"""Optimisation of the typed IR: small passes in a visible order; none changes a draw or a value.

ir.Game -> ir.Game
"""

from collections.abc import Callable

from sjdsl.compiler import ir
from sjdsl.compiler.optimise.drop_impossible import drop_impossible
from sjdsl.compiler.optimise.drop_unused import drop_unused
from sjdsl.compiler.optimise.fold_constants import fold_constants

Pass = Callable[[ir.Game], ir.Game]
PASSES: tuple[Pass, ...] = (fold_constants, drop_impossible, drop_unused)


def optimise(game: ir.Game, passes: tuple[Pass, ...] = PASSES) -> ir.Game:
    """Returns the game after the passes, in order."""
    for pass_ in passes:
        game = pass_(game)
    return game
