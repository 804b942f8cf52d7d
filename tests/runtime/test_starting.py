"""Phases with which an episode begins: what the first observation has of them, and what trials keep."""

from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import sjdsl
from sjdsl.runtime.env import Environment
from sjdsl.testing import Stage

CASE = Path(__file__).parents[1] / "cases" / "starting.sj"


@pytest.fixture(scope="module")
def env() -> Environment:
    return sjdsl.make(CASE)


def soil_of(rows: tuple[str, ...]) -> list[tuple[int, int]]:
    """Returns the cells of soil in reading order."""
    return [(r, c) for r, row in enumerate(rows) for c, glyph in enumerate(row) if glyph == "."]


def distance(a: tuple[int, int], b: tuple[int, int]) -> int:
    return abs(a[0] - b[0]) + abs(a[1] - b[1])


def test_the_first_state_and_observation_have_what_was_computed_from_places(
    env: Environment,
) -> None:
    _, state = env.reset(jax.random.key(5))
    rows, cols = env.cells(state)
    places = list(zip(np.asarray(rows).tolist(), np.asarray(cols).tolist(), strict=True))
    owners = []
    for cell in soil_of(env.game.rows):
        first, second = (distance(place, cell) for place in places)
        owners.append(-1 if first == second else int(second < first))
    assert np.asarray(state.soil_owner).tolist() == owners
    counted = 10 * int(state.world_begun) + sum(owner >= 0 for owner in owners)
    assert int(state.world_owned) == counted
    content = env.token_planes[0].labels
    reset = jax.jit(jax.vmap(env.reset))
    observations, _ = reset(jax.random.split(jax.random.key(0), 32))
    seen = {content[token] for token in np.unique(np.asarray(observations)[..., 0]).tolist()}
    assert any("owner=mine" in label or "owner=others" in label for label in seen)


def test_what_they_write_to_kept_fields_counts_once(env: Environment) -> None:
    """`begun` is kept: each beginning adds 1, and later trials lose that before they go on."""
    _, state = env.reset(jax.random.key(0))
    stay = jnp.full(env.num_agents, env.action_names.index("stay"))
    taken = np.asarray(state.soil_taken)
    for step in range(11):
        _, state, *_ = env.step(jax.random.key(step), state, stay)
        assert int(state.world_begun) == 1
        assert np.asarray(state.soil_taken).tolist() == taken.tolist()
        assert int(state.world_owned) // 10 >= 1
    assert int(state.world_trial) == 2


def test_in_a_scene_they_are_played_from_its_picture() -> None:
    """Nobody leaves the place that the picture shows."""
    scene = Stage(CASE, interpreted=True).put("v.k.c", "d...H", "..c<d")
    owners = dict(zip(soil_of(scene.stage.env.game.rows), scene.value("soil.owner"), strict=True))
    assert owners[1, 1] == 0
    assert owners[1, 3] == 1
    scene.shows("v.k.c", "d...H", "..c<d")
