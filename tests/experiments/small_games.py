"""Games of the tests, made once: a matrix game of two, and public goods of several, linear or with a threshold; and policies that always do the same."""

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp

import sjdsl

GAMES = Path(__file__).parent / "games"
MATRIX, GOODS, THRESHOLD = (
    GAMES / "matrix_game.sj",
    GAMES / "public_goods.sj",
    GAMES / "threshold_goods.sj",
)


@cache
def matrix_game(variant: str | None = None) -> Any:
    """Four steps; `stay` cooperates and `betray` defects."""
    return sjdsl.make(MATRIX, variant=variant)


@cache
def public_goods(players: int, ranked: float = 0.0) -> Any:
    """Two steps; who stays gives 1, who `keep`s does not. With `ranked` the agent's number is added, or a hundred of it taken."""
    return sjdsl.make(GOODS, params={"players": players, "ranked": ranked})


@cache
def threshold_goods(players: int) -> Any:
    """Two steps; who stays pays 1, who `keep`s does not, and all have 4 where 2 at least have paid."""
    return sjdsl.make(THRESHOLD, params={"players": players})


@cache
def always(action: int) -> Callable[[jax.Array, jax.Array], jax.Array]:
    """Returns the policy under which all agents take one action."""
    return lambda _, observation: jnp.full(len(observation), action, jnp.int32)


STAY, OTHER = always(0), always(1)
