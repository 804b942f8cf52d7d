"""The current bundled games, to compare the rules and numbers of results with."""

import json
from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

from sjdsl.compiler import build, ir
from sjdsl.compiler.compose import compose
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.ir.hash import game_hash
from sjdsl.compiler.ir.names import param_attribute
from sjdsl.compiler.syntax.read import read_source
from sjdsl.library.games_folder import bundled, find_game

ROUNDING = 1e-5  # tolerance for numbers that were stored as float32


@cache
def _build_current(name: str, variant: str) -> ir.Game | None:
    """Returns the current rules of a bundled game; None for another game, or a variant that no
    longer exists.
    """
    if name not in bundled():
        return None
    variants = tuple(variant.split("+")) if variant else ()
    try:
        return build(read_source(find_game(name)), variants).game
    except CompileError:
        return None


def rules_now(name: str, variant: str) -> tuple[str, int] | None:
    """Returns the current hash and number of agents of a bundled game; None for another game, or a
    variant that no longer exists.
    """
    game = _build_current(name, variant)
    return None if game is None else (game_hash(game), game.agents.number)


@cache
def variant_now(name: str, rules: str) -> str | None:
    """Returns the variant of a bundled game with this hash, `""` for the game itself; None for
    other rules, or another game.
    """
    if name not in bundled():
        return None
    for variant in ("", *compose(read_source(find_game(name))).variants):
        current = rules_now(name, variant)
        if current is not None and current[0] == rules:
            return variant
    return None


def numbers_now(name: str, variant: str) -> dict[str, Any]:
    """Returns the values of a bundled game's parameters by their Python names; none of another
    game.
    """
    game = _build_current(name, variant)
    if game is None:
        return {}
    return {param_attribute(param.name): param.value for param in game.params}


def other_numbers(game: Mapping[str, Any]) -> list[str]:
    """Returns the numbers of a run's game that differ from those of the bundled game or variant
    with its rules, as `name=value`.

    Args:
      game: the game in a manifest, with `name`, `hash` and `params`.

    Returns:
      Those numbers; for the rules of no bundled variant, the ones that differ from the bundled
      game's; none for another game.
    """
    variant = variant_now(game["name"], game["hash"])
    usual = numbers_now(game["name"], variant or "")
    params: Mapping[str, Any] = game["params"]
    return [
        as_assignment(name, params[name])
        for name in sorted(usual.keys() & params.keys())
        if not _are_equal(params[name], usual[name])
    ]


def as_assignment(name: str, value: Any) -> str:
    """Returns `name=value`, without spaces."""
    text = value if isinstance(value, str) else json.dumps(value, separators=(",", ":"))
    return f"{name}={text}"


def is_usual(name: str, variant: str, param: str, value: Any) -> bool:
    """Returns whether a bundled game, with a variant, has this value of a parameter by default;
    False for another game.

    Args:
      param: its Python name, or `num_agents`.
      value: the value that the user has set.
    """
    game = _build_current(name, variant)
    if game is None:
        return False
    usual = numbers_now(name, variant) | {"num_agents": game.agents.number}
    if param not in usual:
        return False
    if _is_numeric(value) and _is_numeric(usual[param]):
        return _are_equal(value, usual[param])
    words = np.asarray(value, object)
    usual_words = np.asarray(usual[param], object)
    return bool(np.array_equal(words, usual_words))


def _is_numeric(value: Any) -> bool:
    """Returns whether a value is a number or a table of numbers, or text of one."""
    try:
        np.asarray(value, np.float64)
    except (TypeError, ValueError):
        return False
    return True


def _are_equal(value: Any, usual: Any) -> bool:
    """Returns whether numbers are equal up to rounding; words of the language, which may be stored
    as numbers, count as equal.
    """
    try:
        numbers = np.asarray(value, np.float64)
        usual_numbers = np.asarray(usual, np.float64)
    except (TypeError, ValueError):
        return True
    if numbers.shape != usual_numbers.shape:
        return False
    return bool(np.allclose(usual_numbers, numbers, rtol=ROUNDING, atol=0.0))
