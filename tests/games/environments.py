"""Compiled environments of the bundled games, each made once in a session."""

from collections.abc import Mapping
from functools import cache
from typing import Any

import jax.numpy as jnp
import numpy as np

import sjdsl
from sjdsl.compiler import build, compile_build
from sjdsl.compiler.elaborate import Overrides
from sjdsl.compiler.read import read_source
from sjdsl.games_folder import find_game
from sjdsl.make import load_module
from sjdsl.parameters import build_params
from sjdsl.runtime.env import Environment

HARVESTS = ("harvest_open", "harvest_closed", "harvest_partnership")
FIVE = ("coins", *HARVESTS, "clean_up")
NINE = (*FIVE, "coop_mining", "gift_refinement", "mushrooms", "pd_arena")

Cell = tuple[int, int]


@cache
def environment(game: str) -> Environment:
    """Returns a bundled game as it is."""
    return sjdsl.make(game)


@cache
def on_map(game: str, rows: tuple[str, ...], agents: int, sizes: tuple[tuple[str, int], ...] = ()) -> Environment:
    """Returns a bundled game on a small map with so many agents; the map need not do for the game's own number."""
    source = read_source(find_game(game))
    built = build(source, (), Overrides(dict(sizes), agents, rows))
    module = load_module(compile_build(built, source), f"<{game} on a small map>", game)
    return Environment(built.game, module, build_params(built.game, module, {}), "small", "tokens")


def with_params(env: Environment, given: Mapping[str, float]) -> Any:
    """Returns the environment's parameters with some replaced."""
    return env.params.replace(**{name: jnp.asarray(value, getattr(env.params, name).dtype) for name, value in given.items()})


def frame_cells(env: Environment, places: Any) -> np.ndarray:
    """Returns the numbers of (row, col) cells, in the last axis of `places`, as states hold them."""
    places = np.asarray(places)
    return ((places[..., 0] + env.module.PAD) * env.module.FRAME[1] + places[..., 1] + env.module.PAD).astype(np.int32)


def places(env: Environment, position: Any) -> np.ndarray:
    """Returns the (row, col) of positions, in a new last axis."""
    position, pad, cols = np.asarray(position), env.module.PAD, env.module.FRAME[1]
    return np.stack([position // cols - pad, position % cols - pad], axis=-1)


def cells_of(env: Environment, kind: str) -> list[Cell]:
    """Returns the cells of a kind in reading order."""
    glyphs = {g.glyph for g in env.game.glyphs if g.kind == kind}
    return [(r, c) for r, row in enumerate(env.game.rows) for c, glyph in enumerate(row) if glyph in glyphs]


def words_of(env: Environment, kind: str, field: str) -> tuple[str, ...]:
    """Returns the words of a cell field, in the order of their numbers."""
    return next(f.type.words for k in env.game.kinds if k.name == kind for f in k.fields if f.name == field)
