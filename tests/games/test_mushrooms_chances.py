"""The chances of Mushrooms, counted: what grows after a meal."""

from collections.abc import Sequence
from functools import cache
from math import comb
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from .chance import assert_shares, many
from .environments import Cell, environment, placed

pytestmark = pytest.mark.optimised

GAME = "mushrooms"
RED, GREEN, BLUE, ORANGE = KINDS = 1, 2, 3, 4
NAMES = {RED: "red", GREEN: "green", BLUE: "blue", ORANGE: "orange"}
ZAP, STAY, FORWARD = 7, 6, 4
MOST = 8  # of one kind that can come in these tests
# chance of each trial. Sources: the paper; the released code; Melting Pot
CHANCE = {RED: 0.25, GREEN: 0.4, BLUE: 0.6, ORANGE: 1.0}
# trials of red, green, blue, orange after a meal. Source: the released code
TRIALS = {RED: (2, 0, 0, 0), GREEN: (2, 2, 0, 0), BLUE: (2, 2, 2, 0), ORANGE: (2, 0, 0, 1)}
# Source: Melting Pot
TRIALS_OF_THREE = {RED: (3, 0, 0, 0), GREEN: (3, 3, 0, 0), BLUE: (3, 3, 3, 0), ORANGE: (0, 0, 0, 1)}


@cache
def counter(variant: str | None) -> Any:
    """Counts how many mushrooms of each kind came, over many steps from one state."""

    def look(before: Any, after: Any, _: Any) -> Any:
        new = (after.ground_grows[None] == jnp.array(KINDS, jnp.uint8)[:, None]) & (
            before.ground_grows == 0
        )[None]
        number = jnp.sum(new, axis=1, dtype=jnp.int32)
        together = number[0] * MOST**2 + number[1] * MOST + number[2]
        return {
            "new": new,
            "numbers": jax.nn.one_hot(together, MOST**3, dtype=jnp.int32),
            "orange": jax.nn.one_hot(number[3], MOST, dtype=jnp.int32),
        }

    return many(environment(GAME, variant), look)


def binomial(trials: int, probability: float) -> np.ndarray:
    """Returns the probabilities of 0, 1, … MOST - 1 successes."""
    return np.array(
        [
            comb(trials, k) * probability**k * (1 - probability) ** max(0, trials - k)
            for k in range(MOST)
        ]
    )


def assert_grown(seen: Any, trials: Sequence[int], within: float) -> None:
    """Asserts how many of each kind came: red, green and blue independent of one another, orange for certain."""
    red, green, blue = (binomial(n, CHANCE[kind]) for n, kind in zip(trials[:3], KINDS))
    wanted = red[:, None, None] * green[:, None] * blue
    assert_shares(seen["numbers"].reshape(wanted.shape), wanted, within)
    assert_shares(seen["orange"], binomial(trials[3], CHANCE[ORANGE]), within)


def first_of(kind: int, variant: str | None = None) -> Cell:
    """Returns the cell of a kind's first mushroom on the map."""
    rows = environment(GAME, variant).game.rows
    return next((r, row.index("?RGBO"[kind])) for r, row in enumerate(rows) if "?RGBO"[kind] in row)


def before_meals(
    kinds: Sequence[int], variant: str | None = None, **fields: Any
) -> tuple[Any, list[int]]:
    """Returns a state and actions with which the first agents each eat a mushroom, coming from the cell below it."""
    env = environment(GAME, variant)
    eaters = [(first_of(kind, variant)[0] + 1, first_of(kind, variant)[1]) for kind in kinds]
    state = placed(env, [*eaters, *[(0, c) for c in range(env.num_agents - len(kinds))]], **fields)
    north = FORWARD
    return state, [north] * len(kinds) + [STAY] * (env.num_agents - len(kinds))


@pytest.mark.thorough
@pytest.mark.parametrize("variant", [None, "meltingpot"])
@pytest.mark.parametrize("kind", KINDS, ids=NAMES.get)
def test_what_grows_after_a_meal(kind: int, variant: str | None) -> None:
    """In the step of the meal; two trials or, in Melting Pot, three, and there orange sows no red."""
    env = environment(GAME, variant)
    state, actions = before_meals([kind], variant)
    params = (
        env.params.replace(poison=jnp.float32(0)) if variant else env.params
    )  # else some of the red ones make room
    seen = counter(variant)(kind, state, actions, params, 4)
    assert_grown(seen, (TRIALS_OF_THREE if variant else TRIALS)[kind], 0.03)


@pytest.mark.thorough
@pytest.mark.parametrize("kind", KINDS, ids=NAMES.get)
def test_as_released_spores_come_a_step_later(kind: int) -> None:
    """Two trials of red, after orange too; nothing in the step of the meal. Source: the released code."""
    env = environment(GAME, "socialjax")
    state, actions = before_meals([kind], "socialjax")
    seen = counter("socialjax")(kind, state, actions, env.params, 1)
    assert not seen["new"].any()
    _, after, *_ = env.step_env(jax.random.key(0), state, jnp.asarray(actions))
    assert_grown(
        counter("socialjax")(kind, after, [STAY] * env.num_agents, env.params, 4),
        TRIALS[kind],
        0.03,
    )
