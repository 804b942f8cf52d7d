"""Level-Based Foraging, scene by scene and counted: who takes what together, how it is shared, loading in vain, where it all begins."""

from collections.abc import Mapping

import jax
import numpy as np
import pytest

from sjdsl.testing import Scene, Stage

from .chance import BATCH, assert_shares, assert_uniform
from .environments import environment, placed, places, stage_of

GAME = "lb_foraging"
ROWS = (".......", ".......", ".......", ".......", "PPPP...")
STAGE = stage_of(GAME, ROWS, 4)
Cell = tuple[int, int]


def put(
    stands: Mapping[int, Cell], foods: Mapping[Cell, int], levels: list[int], stage: Stage = STAGE
) -> Scene:
    """Returns a scene with agents and food on these cells; agents that are not told of wait in the corner."""
    cells = {agent: stands.get(agent, (4, agent)) for agent in range(4)}
    rows = [list(row) for row in ROWS]
    for row, column in cells.values():
        rows[row][column] = "^"
    told = [
        "".join(
            str(agent)
            for _, agent in sorted((c, agent) for agent, (r, c) in cells.items() if r == row)
        )
        for row in range(5)
    ]
    picture = [
        f"{''.join(row)}  {numbers}".rstrip() for row, numbers in zip(rows, told, strict=True)
    ]
    fields = {
        "floor.food": {
            cell: foods.get(cell, 0)
            for row in range(5)
            for cell in [(row, c) for c in range(7)]
            if ROWS[row][cell[1]] == "."
        }
    }
    return stage.put(*picture, fields={**fields, "agent.level": levels})


def load(*agents: int) -> str:
    return ", ".join("load" if agent in agents else "stay" for agent in range(4))


SPOT, FAR = (1, 3), {(3, 6): 3}  # the food under test; a food far away keeps the episode going
AROUND: dict[int, Cell] = {0: (0, 3), 1: (1, 2), 2: (1, 4), 3: (2, 3)}


@pytest.mark.parametrize(
    ("food", "levels", "loading", "rewards"),
    [
        (1, [1, 1, 1, 1], (0,), [1, 0, 0, 0]),
        (2, [2, 1, 1, 1], (0,), [2, 0, 0, 0]),
        (1, [2, 1, 1, 1], (0,), [1, 0, 0, 0]),  # more than needed pays no more
        (2, [1, 1, 1, 1], (0, 1), [1, 1, 0, 0]),
        (3, [2, 1, 1, 1], (0, 1), [2, 1, 0, 0]),  # by level
        (3, [2, 2, 1, 1], (0, 1, 2), [1.2, 1.2, 0.6, 0]),
        (3, [2, 2, 2, 2], (0, 1, 2, 3), [0.75] * 4),
        (2, [1, 1, 1, 1], (0,), [-0.1, 0, 0, 0]),  # in vain
        (3, [1, 1, 1, 2], (0, 1), [-0.1, -0.1, 0, 0]),  # who stands by does not count
    ],
)
def test_levels_that_add_up_take_food_and_share_it(
    food: int, levels: list[int], loading: tuple[int, ...], rewards: list[float]
) -> None:
    """Source: SocialJax, released code: in proportion to levels; 0.1 less for who loads in vain."""
    taken = min(rewards) >= 0
    scene = put(AROUND, {SPOT: food, **FAR}, levels).step(load(*loading))
    scene.has({"reward": rewards, "event taken": int(taken)})
    scene.has(
        {"event shared" if taken else "event vain": [int(agent in loading) for agent in range(4)]}
    )
    assert scene.value("floor.food")[1 * 7 + 3] == (0 if taken else food)


@pytest.mark.parametrize(
    ("cell", "reaches"),
    [((1, 2), True), ((0, 3), True), ((0, 2), False), ((1, 1), False), ((3, 3), False)],
)
def test_only_who_stands_beside_food_loads_it(cell: Cell, reaches: bool) -> None:
    scene = put({0: cell}, {SPOT: 1, **FAR}, [2, 1, 1, 1]).step(load(0))
    scene.has({"reward": [int(reaches), 0, 0, 0], "event vain": [0] * 4})


def test_food_is_in_the_way() -> None:
    scene = put({0: (1, 2)}, {SPOT: 1, **FAR}, [1, 1, 1, 1]).step("step_right, stay, stay, stay")
    assert scene.places()[0] == (1, 2)
    scene.step(load(0)).step("step_right, stay, stay, stay")
    assert scene.places()[0] == SPOT


@pytest.mark.parametrize("left", [0, 1])
def test_the_last_food_ends_the_episode(left: int) -> None:
    """On the bundled map, with one food left or two: the agents stand around the middle row."""
    env = environment(GAME)
    _, state = env.reset(jax.random.key(0))
    cells = [
        (row, column)
        for row, line in enumerate(env.game.rows)
        for column, glyph in enumerate(line)
        if glyph == "."
    ]
    foods = {(1, 3): 1} | ({(5, 5): 1} if left else {})
    floor = np.array([foods.get(cell, 0) for cell in cells])
    state = placed(
        env, [(2, 3), (4, 4), (2, 4), (4, 3)], floor_food=floor.astype(state.floor_food.dtype)
    )
    _, _, reward, done, info = env.step(jax.random.key(1), state, np.array([5, 0, 0, 0]))
    assert (reward[0], bool(done), bool(info["truncated"])) == (1, not left, False)


def test_where_and_with_what_an_episode_begins() -> None:
    """Agents on the four starts, all food on free floor; levels of both are drawn evenly."""
    env = environment(GAME)
    _, states = jax.jit(jax.vmap(env.reset))(jax.random.split(jax.random.key(0), BATCH))
    stands = {tuple(map(tuple, row.tolist())) for row in places(env, states.position)}
    assert {cell for row in stands for cell in row} == {(2, 3), (2, 4), (4, 3), (4, 4)}
    assert len(stands) == 24, "in any order"
    food, levels = np.asarray(states.floor_food), np.asarray(states.agent_level)
    assert food.shape == (BATCH, 26)
    assert ((food > 0).sum(axis=1) == 4).all()
    assert_uniform([(food == level).sum() for level in (1, 2, 3)], within=0.2)
    assert_uniform([(levels == level).sum() for level in (1, 2)], within=0.2)
    assert_uniform((food > 0).sum(axis=0), within=0.4)


@pytest.mark.thorough
def test_as_released_food_is_lost_where_it_cannot_lie() -> None:
    """Each of four tries draws one of 56 cells, 26 of them floor, and is lost on other cells and where food lies already."""
    env = environment(GAME, "socialjax")
    _, states = jax.jit(jax.vmap(env.reset))(jax.random.split(jax.random.key(0), BATCH))
    food = np.asarray(states.floor_food)
    shares = np.eye(5)[0]
    for _ in range(4):
        placed_now = shares[:4] * (26 - np.arange(4)) / 56
        shares = shares - np.append(placed_now, 0) + np.append(0, placed_now)
    assert_shares(np.bincount((food > 0).sum(axis=1), minlength=5), shares, within=0.05)
    assert_uniform([(food == level).sum() for level in (1, 2, 3)], within=0.2)
    assert_uniform((food > 0).sum(axis=0), within=0.6)
