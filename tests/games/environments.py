"""Compiled environments of the bundled games, each made once in a session."""

import os
from functools import cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from sjdsl import Environment, make
from sjdsl.testing import Stage

HARVESTS = ("harvest_open", "harvest_closed", "harvest_partnership")
FIVE = ("coins", *HARVESTS, "clean_up")
NINE = (*FIVE, "coop_mining", "gift_refinement", "mushrooms", "pd_arena")

Cell = tuple[int, int]
BRIEFLY = "SJDSL_ALL_TESTS" not in os.environ


def environment(game: str, variant: str | None = None, agents: int | None = None) -> Environment:
    """Returns a bundled game, as it is unless a variant or a number of agents is named."""
    return _environment(game, variant, agents)


@cache
def _environment(game: str, variant: str | None, agents: int | None) -> Environment:
    return make(game, variant=variant, num_agents=agents)


def stage_of(game: str, *board: Any, **settings: Any) -> Stage:
    """Returns a stage where the interpreter takes the steps; with all tests, the compiled game does too.

    `tests/differential/test_equal.py` plays each game on both.
    """
    return Stage(game, *board, interpreted=BRIEFLY, **settings)


def frame_cells(env: Environment, places: Any) -> np.ndarray:
    """Returns the numbers of (row, col) cells, in the last axis of `places`, as states hold them."""
    places = np.asarray(places)
    return (
        (places[..., 0] + env.module.PAD) * env.module.FRAME[1] + places[..., 1] + env.module.PAD
    ).astype(np.int32)


def places(env: Environment, position: Any) -> np.ndarray:
    """Returns the (row, col) of positions, in a new last axis."""
    position, pad, cols = np.asarray(position), env.module.PAD, env.module.FRAME[1]
    return np.stack([position // cols - pad, position % cols - pad], axis=-1)


def placed(env: Environment, cells: list[Cell], headings: Any = 0, **fields: Any) -> Any:
    """Returns a first state with the agents on these (row, col) cells, and attributes of the state as given."""
    _, state = env.reset(jax.random.key(0))
    changed = {
        name: jnp.asarray(value, getattr(state, name).dtype) for name, value in fields.items()
    }
    assert all(changed[name].shape == getattr(state, name).shape for name in changed)
    heading = jnp.broadcast_to(jnp.asarray(headings, jnp.int32), (env.num_agents,))
    return state.replace(position=jnp.asarray(frame_cells(env, cells)), heading=heading, **changed)


def cells_of(env: Environment, kind: str) -> list[Cell]:
    """Returns the cells of a kind in reading order."""
    glyphs = {g.glyph for g in env.game.glyphs if g.kind == kind}
    return [
        (r, c)
        for r, row in enumerate(env.game.rows)
        for c, glyph in enumerate(row)
        if glyph in glyphs
    ]


def words_of(env: Environment, kind: str, field: str) -> tuple[str, ...]:
    """Returns the words of a cell field, in the order of their numbers."""
    return next(
        f.type.words for k in env.game.kinds if k.name == kind for f in k.fields if f.name == field
    )
