"""Steps of one game from one state with very many keys, and what each came to, as small whole numbers by name."""

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

import sjdsl

STEPS, ENVIRONMENTS = 16, 4096  # as a rollout has them
FORWARD, STEP_RIGHT, BACKWARD, STEP_LEFT = 1, 2, 3, 4
AROUND = (
    (0, 6, BACKWARD),
    (1, 7, STEP_LEFT),
    (2, 6, FORWARD),
    (1, 5, STEP_RIGHT),
)  # four agents who all enter one cell
HENS = ((1, 1), (1, 5), (1, 9))  # four open cells around each
PAWNS = ((3, 3), (3, 5))  # face each other, with one cell between them
EAST, WEST = 1, 3
Outcomes = dict[str, np.ndarray]


@cache
def game() -> sjdsl.Environment:
    return sjdsl.make(Path(__file__).with_name("every_draw.sj"))


@cache
def strays() -> sjdsl.Environment:
    return sjdsl.make(Path(__file__).with_name("strays.sj"))


def rollout_keys(seed: int) -> jax.Array:
    """Returns the keys `[T, B]` that a rollout of the trainers uses: each step's split into two, the second into one each environment."""
    steps = jax.vmap(jax.random.split)(jax.random.split(jax.random.key(seed), STEPS))[:, 1]
    return jax.vmap(lambda key: jax.random.split(key, ENVIRONMENTS))(steps)


def counted_keys(first: int) -> jax.Array:
    """Returns keys that differ as little as keys can: `jax.random.key` of numbers in a row."""
    return jax.vmap(jax.random.key)(jnp.arange(first, first + STEPS * ENVIRONMENTS)).reshape(
        STEPS, ENVIRONMENTS
    )


@cache
def outcomes(keys: str) -> Outcomes:
    """Returns what each of the steps came to, `[T, B]` or `[T, B, instances]` each. `keys`: `rollout` or `counted`."""
    made = rollout_keys(3) if keys == "rollout" else counted_keys(10**6)
    return {name: np.asarray(value) for name, value in _run(made).items()}


@jax.jit
def _run(keys: jax.Array) -> dict[str, jax.Array]:
    return jax.vmap(jax.vmap(_one))(keys)


def _one(key: jax.Array) -> dict[str, jax.Array]:
    """Takes one step, and a second one in which those come back who were sent away for a step, and are sent there again, at once."""
    env = game()
    state = start(env)
    actions = jnp.asarray([action for *_, action in AROUND] + [0, 0], jnp.int32)
    after = env.step_env(key, state, actions)[1]
    back = env.step_env(jax.random.fold_in(key, 1), after, jnp.zeros(6, jnp.int32))[1]
    fields = {
        name: getattr(after, f"floor_{name}").astype(jnp.int32)
        for name in ("hit", "tabled", "chain", "number", "wide")
    }
    fields |= {
        name: getattr(after, f"floor_{name}").astype(jnp.int32)
        for name in ("colour", "burden", "picked", "some")
    }
    fields["part"] = jnp.floor((after.floor_part + 1) * 5).astype(
        jnp.int32
    )  # a twentieth of -1 .. 3 each
    place, again = (_cells(env, s) for s in (after, back))
    return {
        **fields,
        "partner": after.agent_partner[:4].astype(jnp.int32),
        "came": after.agent_came[:4].astype(jnp.int32),
        "gate": place[:4],
        "heading": after.heading[:4],
        "den": _first_dens(env, back),
        "returned heading": back.agent_faced[4:].astype(jnp.int32),
        "den again": again[4:],
        "heading again": back.heading[4:],
        "taker": after.den_taker.astype(jnp.int32),
        **_of_movers(key),
    }


def start(env: sjdsl.Environment) -> Any:
    """Returns the state before: four around a cell, two at home."""
    state = env.module.initial_state()
    where = [(row, col) for row, col, _ in AROUND] + [(3, 0), (3, 1)]
    return state.replace(position=_positions(env, where, state))


def _of_movers(key: jax.Array) -> dict[str, jax.Array]:
    """Takes one step of the game of movers: the direction that each hen took, and which of the two pawns came to the cell between them."""
    env = strays()
    state = env.module.initial_state()
    facing = jnp.asarray([EAST, WEST], state.pawn_heading.dtype)
    hens, pawns, agent = (_positions(env, cells, state) for cells in (HENS, PAWNS, [(0, 0)]))
    state = state.replace(
        position=agent, hen_position=hens, pawn_position=pawns, pawn_heading=facing
    )
    after = env.step_env(key, state, jnp.zeros(1, jnp.int32))[1]
    moved = after.pawn_position != state.pawn_position
    return {"strayed": after.hen_heading.astype(jnp.int32), "pushed": moved.astype(jnp.int32)}


def _positions(env: sjdsl.Environment, cells: Sequence[tuple[int, int]], state: Any) -> jax.Array:
    """Returns cells of the map as a state has them."""
    numbers = [
        (row + env.module.PAD) * env.module.FRAME[1] + col + env.module.PAD for row, col in cells
    ]
    return jnp.asarray(numbers, state.position.dtype)


def _cells(env: sjdsl.Environment, state: Any) -> jax.Array:
    """Returns the number of each agent's cell on the map, row by row."""
    row, col = env.cells(state)
    return row * len(env.game.rows[0]) + col


def _first_dens(env: sjdsl.Environment, state: Any) -> jax.Array:
    """Returns the number of the cell to which each of the last two came back, before they were sent again."""
    rows = env.game.rows
    dens = jnp.asarray(
        [
            r * len(rows[0]) + c
            for r, row in enumerate(rows)
            for c, glyph in enumerate(row)
            if glyph == "d"
        ]
    )
    return jnp.stack([dens[jnp.argmax(state.den_guest == agent)] for agent in (4, 5)])
