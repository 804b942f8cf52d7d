"""The bundled games as they are now: whether results are of the same rules and numbers."""

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

from sjdsl.compiler import build, ir
from sjdsl.compiler.compose import compose
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.ir.hash import game_hash
from sjdsl.compiler.ir.names import param_attribute
from sjdsl.compiler.syntax.read import read_source
from sjdsl.games_folder import OURS, bundled, find_game

ROUNDING = 1e-5  # of numbers that were float32 on their way


def _file(name: str) -> Source:
    return read_source(find_game(f"{OURS}:{name}"))  # an installed package may have a game of this name, too


@cache
def _game(name: str, variant: str) -> ir.Game | None:
    """Returns the rules of a bundled game as it is now; None for another game, or a variant that is gone."""
    if name not in bundled():
        return None
    try:
        return build(_file(name), tuple(variant.split("+")) if variant else ()).game
    except CompileError:
        return None


def rules_now(name: str, variant: str) -> tuple[str, int] | None:
    """Returns the hash and the number of agents of a bundled game as it is now; None for another game, or a variant that is gone."""
    game = _game(name, variant)
    return None if game is None else (game_hash(game), game.agents.number)


@cache
def variant_now(name: str, rules: str) -> str | None:
    """Returns the variant of a bundled game that has a hash now, `""` for the game itself; None for other rules, or another game."""
    if name not in bundled():
        return None
    variants = ["", *compose(_file(name)).variants]
    return next((variant for variant in variants if (rules_now(name, variant) or ("",))[0] == rules), None)


def other_numbers(described: Mapping[str, Any]) -> list[str]:
    """Returns the numbers of a run's game that are not those of the bundled game, as `name=value`; nothing of another game.

    Args:
      described: `name` and `params` of the game as a manifest has them.
    """
    game = _game(described["name"], "")
    usual = {} if game is None else {param_attribute(param.name): param.value for param in game.params}
    params: Mapping[str, Any] = described["params"]
    return [f"{name}={params[name]}" for name in sorted(usual.keys() & params.keys()) if not _same(params[name], usual[name])]


def is_usual(name: str, variant: str, param: str, value: Any) -> bool:
    """Returns whether a bundled game, with a variant of it, has this value of a parameter without being asked; False of another game.

    Args:
      param: as Python names it, or `num_agents`.
      value: as it was asked for.
    """
    game = _game(name, variant)
    if game is None:
        return False
    usual = {param_attribute(own.name): own.value for own in game.params} | {"num_agents": game.agents.number}
    if param not in usual:
        return False
    if _is_numeric(value) and _is_numeric(usual[param]):
        return _same(value, usual[param])
    return bool(np.array_equal(np.asarray(value, object), np.asarray(usual[param], object)))  # words


def _is_numeric(value: Any) -> bool:
    """Returns whether a value is a number or a table of numbers, also as they are typed."""
    try:
        np.asarray(value, np.float64)
    except (TypeError, ValueError):
        return False
    return True


def _same(value: Any, usual: Any) -> bool:
    """Returns whether numbers are the same to rounding; words of the language, which are encoded as numbers elsewhere, are not compared."""
    try:
        before, now = np.asarray(usual, np.float64), np.asarray(value, np.float64)
    except (TypeError, ValueError):
        return True
    return before.shape == now.shape and bool(np.allclose(before, now, rtol=ROUNDING, atol=0.0))
