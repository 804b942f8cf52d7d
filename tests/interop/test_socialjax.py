"""The SocialJax adapter: a client that makes the suite's calls, its compass, its channels cell by cell, its scales."""

import importlib
import math
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.interop import socialjax, spaces

DEPTHS = {
    "coin_game": 14,
    "harvest_common_open": 15,
    "clean_up": 19,
    "coop_mining": 12,
    "mushrooms": 16,
    "gift": 13,
    "pd_arena": 22,
    "territory_open": 19,
}
LEFT, RIGHT, UP, DOWN, STAY = 2, 3, 4, 5, 6  # the suite's numbers
COMPASS = {LEFT: (0, 1), RIGHT: (0, -1), UP: (1, 0), DOWN: (-1, 0)}
COMPASS_OF_MINING = {2: (0, -1), 3: (0, 1), 4: (-1, 0), 5: (1, 0)}


def resets(env: Any, seed: int) -> Any:
    return env.reset(jax.random.key(seed))


def with_agent(env: Any, state: Any, cells: list[tuple[int, int]], headings: list[int]) -> Any:
    """Returns the state with the agents on these cells of the map."""
    pad, cols = env.env.module.PAD, env.env.module.FRAME[1]
    places = jnp.asarray([(r + pad) * cols + c + pad for r, c in cells], state.game.position.dtype)
    return state.replace(
        game=state.game.replace(
            position=places, heading=jnp.asarray(headings, state.game.heading.dtype)
        )
    )


@pytest.mark.parametrize(("name", "depth"), DEPTHS.items())
def test_every_id_has_the_suites_shapes(name: str, depth: int) -> None:
    """Of what is traced; `test_socialjax_scripts.py` runs them."""
    env = socialjax.make(name, num_inner_steps=20)
    box, shape = env.observation_space()
    assert box.shape == shape == (11, 11, depth)
    observation, state = jax.eval_shape(env.reset, jax.random.key(0))
    assert (observation.shape, observation.dtype) == ((env.num_agents, 11, 11, depth), jnp.float32)
    assert env.agents == list(range(env.num_agents))
    actions = [jnp.array([STAY])] * env.num_agents
    _, _, reward, done, info = jax.eval_shape(env.step, jax.random.key(1), state, actions)
    assert reward.shape == (env.num_agents,)
    assert list(done) == [*map(str, env.agents), "__all__"]
    assert {leaf.shape for leaf in jax.tree.leaves(info)} == {(env.num_agents,)}
    assert env.action_space().n == env.action_space(0).n == env.env.num_actions


@pytest.mark.parametrize(
    ("name", "compass"),
    [("clean_up", COMPASS), ("mushrooms", COMPASS), ("coop_mining", COMPASS_OF_MINING)],
)
def test_moves_follow_the_suites_compass(name: str, compass: dict[int, tuple[int, int]]) -> None:
    """Whatever the heading; clean_up's cell (8, 8) and its neighbours, and those of the others, are free ground."""
    env = socialjax.make(name)
    _, state = resets(env, 2)
    far = [(1, 1 + 2 * agent) for agent in range(1, env.num_agents)]
    centre = (8, 12) if name == "coop_mining" else (8, 8)
    for heading in range(4):
        placed = with_agent(env, state, [centre, *far], [heading] * env.num_agents)
        for action, (down, right) in compass.items():
            _, after, *_ = env.step(
                jax.random.key(3),
                placed,
                [jnp.int32(action)] + [jnp.int32(STAY)] * (env.num_agents - 1),
            )
            row, col = (np.asarray(x) for x in env.env.cells(after.game))
            assert (row[0] - centre[0], col[0] - centre[1]) == (down, right), (heading, action)


def expected_harvest(env: Any, state: Any, agent: int) -> np.ndarray:
    """The 15 channels of one agent by a loop over its window; agents hide what is beneath."""
    rows = env.env.game.rows
    soil = [(r, c) for r, row in enumerate(rows) for c, letter in enumerate(row) if letter == "A"]
    ripe = {
        cell
        for cell, fruit in zip(soil, np.asarray(state.game.soil_fruit), strict=True)
        if fruit == 1
    }
    walls = {(r, c) for r, row in enumerate(rows) for c, letter in enumerate(row) if letter == "#"}
    row, col = (np.asarray(x) for x in env.env.cells(state.game))
    headings = np.asarray(state.game.heading)  # ours: clockwise from north
    steps = [(-1, 0), (0, 1), (1, 0), (0, -1)]
    ahead, right = steps[headings[agent]], steps[(headings[agent] + 1) % 4]
    seen = np.zeros((11, 11, 15))
    for r in range(11):
        for c in range(11):
            cell = tuple(
                int((row[agent], col[agent])[i] + (9 - r) * ahead[i] + (c - 5) * right[i])
                for i in (0, 1)
            )
            here = [other for other in range(env.num_agents) if (row[other], col[other]) == cell]
            if here:
                (other,) = here
                if other == agent:
                    seen[r, c, 5] = 1
                else:
                    seen[r, c, 6] = 1
                    turned_left = (
                        headings[agent] - headings[other]
                    ) % 4  # the suite counts headings the other way round
                    seen[r, c, 7 + turned_left] = 1
            elif not (0 <= cell[0] < len(rows) and 0 <= cell[1] < len(rows[0])) or cell in walls:
                seen[r, c, 0] = 1
            elif cell in ripe:
                seen[r, c, 2] = 1
    return seen


@pytest.mark.parametrize("name", ["harvest_common_open", "harvest_common_closed"])
def test_channels_cell_by_cell(name: str) -> None:
    """Without beams: actions are turns and moves only."""
    env = socialjax.make(name)
    observation, state = resets(env, 6)
    facing = set()
    for number, key in enumerate(jax.random.split(jax.random.key(7), 12)):
        for agent in range(env.num_agents):
            wanted = expected_harvest(env, state, agent)
            np.testing.assert_array_equal(np.asarray(observation[agent]), wanted)
            facing |= set(np.nonzero(wanted[..., 7:11].any(axis=(0, 1)))[0].tolist())
        observation, state, *_ = env.step(
            key, state, [(number * 5 + agent) % 7 for agent in env.agents]
        )
    assert facing == {0, 1, 2, 3}


def test_the_arena_shows_all_bags() -> None:
    env = socialjax.make("pd_arena")
    _, state = resets(env, 8)
    bags = jnp.asarray([[3, 0], [0, 4], [1, 2], [5, 6]], state.game.agent_bag.dtype)
    seen = env.get_obs(state.replace(game=state.game.replace(agent_bag=bags)))
    assert seen[2, 4, 4, 11:15].tolist() == [3, 0, 1, 5]
    assert seen[0, 9, 0, 15:19].tolist() == [0, 4, 2, 6]


def paid(raw: list[float], **mode: Any) -> np.ndarray:
    """Returns what the agents of a mode are paid for these raw rewards, at time step 0 of the training."""
    from sjdsl.interop.socialjax_rewards import Mode, make_rewards

    given = {"shared_rewards": False, **mode}
    return np.asarray(
        make_rewards(Mode(**given), len(raw))(jnp.asarray(raw, jnp.float32), jnp.int32(0))[0]
    )


def test_the_suites_scales() -> None:
    """Figures of the released code: one eater among seven, and a step without any reward."""
    eater = [1.0] + [0.0] * 6
    np.testing.assert_allclose(paid(eater), [7, 0, 0, 0, 0, 0, 0])
    np.testing.assert_allclose(
        paid(eater, shared_rewards=True, svo=True), [1] * 7
    )  # shared comes first
    np.testing.assert_allclose(
        paid([0.0] * 7, svo=True, svo_w=0.5, svo_ideal_angle_degrees=90), [-5.4978] * 7, atol=1e-4
    )
    np.testing.assert_allclose(
        paid([0.0] * 2, svo=True, svo_ideal_angle_degrees=90), [-1.5708] * 2, atol=1e-4
    )
    np.testing.assert_allclose(
        paid([0.0] * 2, svo=True, svo_ideal_angle_degrees=90, svo_target_agents=[1]),
        [0, -1.5708],
        atol=1e-4,
    )
    np.testing.assert_allclose(
        paid([1.0, 1.0], svo=True, svo_ideal_angle_degrees=45), [2, 2], atol=1e-5
    )
    away = math.atan2(0.5, 1)
    np.testing.assert_allclose(
        paid([2.0, 1.0], svo=True, svo_ideal_angle_degrees=0)[0], 4 - 2 * 0.5 * away, atol=1e-5
    )
    np.testing.assert_allclose(paid([1.0, 0.0], interest=True, s_interest=0.75), [1.5, 0.5])
    np.testing.assert_allclose(
        paid([1.0, 0.0, 0.0], interest=True, s_interest_schedule=[1.0, 0.5]), [3, 0, 0]
    )
    averse = paid([1.0, 0.0, 0.0], inequity_aversion=True)
    np.testing.assert_allclose(averse, [3 - 0.05 * 3, -5 * 3 / 2, -5 * 3 / 2], atol=1e-5)
    np.testing.assert_allclose(
        paid([1.0, 0.0, 0.0], inequity_aversion=True, inequity_aversion_target_agents=[0])[1:],
        [0, 0],
    )


def test_episodes_within_episodes() -> None:
    """Two inner episodes make an outer one; its last step's reward is paid."""
    env = socialjax.make("coin_game", num_inner_steps=3, num_outer_steps=2)
    _, state = resets(env, 9)
    seen = []
    for key in jax.random.split(jax.random.key(10), 8):
        _, state, _, done, _ = env.step(key, state, [STAY, STAY])
        seen.append((int(state.inner_t), int(state.outer_t), bool(done["__all__"])))
    assert seen == [
        (1, 0, False),
        (2, 0, False),
        (0, 1, False),
        (1, 1, False),
        (2, 1, False),
        (0, 0, True),
        (1, 0, False),
        (2, 0, False),
    ]


def test_step_env_and_chosen_states() -> None:
    env = socialjax.make("coin_game", num_inner_steps=2)
    _, state = resets(env, 11)
    _, chosen = resets(env, 12)
    key = jax.random.key(13)
    _, middle, *_ = env.step(key, state, [STAY, STAY])
    observation, after, _, done, _ = env.step(key, middle, [STAY, STAY], reset_state=chosen)
    assert done["0"] and jax.tree.all(jax.tree.map(jnp.array_equal, after, chosen))
    np.testing.assert_array_equal(observation, env.get_obs(chosen))
    _, last, _, done, _ = env.step_env(key, middle, [STAY, STAY])
    assert done["0"] and int(last.game.step) == 2


def test_figures_that_scripts_log() -> None:
    """Apples on the map, clean actions and coins, at the suite's scales."""
    harvest = socialjax.make("harvest_common_open")
    _, state = resets(harvest, 14)
    *_, info = harvest.step(jax.random.key(15), state, [STAY] * 7)
    assert info["AppleCount_info"].tolist() == [64.0] * 7
    river = socialjax.make("clean_up")
    _, state = resets(river, 16)
    *_, info = river.step(jax.random.key(17), state, [8, 7, 6, 8, 0, 0, 0])
    assert info["clean_action_info"].tolist() == [1, 0, 0, 1, 0, 0, 0]
    assert 68 <= info["cleaned_water"][0] <= 68 + 8
    coins = socialjax.make("coin_game", regrow_rate=0.5, shared_rewards=False)
    _, state = resets(coins, 18)
    own = 0
    for number, key in enumerate(jax.random.split(jax.random.key(19), 12)):
        _, state, reward, _, info = coins.step(key, state, [2 + number % 4, 2 + (number + 1) % 4])
        own += info["eat_own_coins"].sum()
        assert reward.tolist() == info["original_rewards"].tolist()
    assert own > 0 and own % 2 == 0


@pytest.mark.parametrize(
    ("name", "theirs", "ours"),
    [
        ("coin_game", ["CCPC", "PCCC"], ("CCPC", "PCCC")),
        ("clean_up", ["HF=+~f", "QP <S>", "^T;s,B"], ("HF..S.", "PP..S.", ".B...B")),
        ("mushrooms", ["   R", "G BO"], ("...R", "G.BO")),
        ("gift", ["TPW", "TPT"], ("TP#", "TPT")),
        ("pd_arena", ["PP12", "PPW"], ("PPDC", "PP#.")),
        ("territory_open", ["PPR,", "WTRF"], ("PPR.", "##R#")),
    ],
)
def test_maps_of_other_games(name: str, theirs: list[str], ours: tuple[str, ...]) -> None:
    env = socialjax.make(name, map_ASCII=theirs, num_agents=2)
    assert env.env.game.rows == ours


@pytest.mark.parametrize(
    ("name", "kwargs", "error", "message"),
    [
        (
            "harvest",
            {},
            ValueError,
            "there is no id `harvest`; the ids are coin_game, harvest_common_open",
        ),
        (
            "coin_game",
            {"svo_weight": 1},
            TypeError,
            "`coin_game` has no keyword `svo_weight`; it has cnn, inequity_aversion",
        ),
        ("coop_mining", {"map_ASCII": []}, TypeError, "has no keyword `map_ASCII`"),
        (
            "coin_game",
            {"enable_smooth_rewards": True},
            TypeError,
            "has no keyword `enable_smooth_rewards`",
        ),
        ("coin_game", {"obs_size": 5}, ValueError, "obs_size must be 11"),
    ],
)
def test_what_there_is_not(
    name: str, kwargs: dict[str, Any], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=re.escape(message)):
        socialjax.make(name, **kwargs)


# Level-Based Foraging: figures of the released code, in loops over its cells

FORAGER_STAY, NORTH, SOUTH, WEST, EAST, LOAD = range(6)


def foragers(
    cells: list[tuple[int, int]],
    levels: list[int],
    foods: dict[tuple[int, int], int],
    **kwargs: Any,
) -> tuple[Any, Any]:
    """Returns a game and a state of it with agents and foods of these levels on these cells, and nothing else."""
    env = socialjax.make("lb_foraging", num_agents=len(cells), **kwargs)
    _, state = resets(env, 0)
    ground = [
        (r, c)
        for r, line in enumerate(env.env.game.rows)
        for c, glyph in enumerate(line)
        if glyph == "."
    ]
    food = jnp.asarray([foods.get(cell, 0) for cell in ground], state.game.floor_food.dtype)
    state = with_agent(env, state, cells, [0] * len(cells))
    return env, state.replace(
        game=state.game.replace(
            floor_food=food, agent_level=jnp.asarray(levels, state.game.agent_level.dtype)
        )
    )


def released_view(
    env: Any,
    cells: list[tuple[int, int]],
    levels: list[int],
    foods: dict[tuple[int, int], int],
    agent: int,
) -> np.ndarray:
    """Released code: 8 x 8 cells from four rows above and four columns to the left; levels of agents, of food, and what is no wall."""
    rows = env.env.game.rows
    seen = np.zeros((8, 8, 3))
    for r in range(8):
        for c in range(8):
            cell = (cells[agent][0] - 4 + r, cells[agent][1] - 4 + c)
            if not (0 <= cell[0] < len(rows) and 0 <= cell[1] < len(rows[0])):
                continue
            seen[r, c, 0] = levels[cells.index(cell)] if cell in cells else 0
            seen[r, c, 1] = foods.get(cell, 0)
            seen[r, c, 2] = rows[cell[0]][cell[1]] != "#"
    return seen


def released_rewards(
    cells: list[tuple[int, int]],
    levels: list[int],
    foods: dict[tuple[int, int], int],
    actions: list[int],
) -> np.ndarray:
    """Released code: the level of the food in proportion to one's own; 0.1 less for each food where levels do not suffice."""
    earned = np.zeros(len(cells))
    for (row, col), food in foods.items():
        who = [
            n
            for n, (r, c) in enumerate(cells)
            if abs(r - row) + abs(c - col) == 1 and actions[n] == LOAD
        ]
        together = sum(levels[n] for n in who)
        for n in who:
            earned[n] += levels[n] * food / together if together >= food else -0.1
    return earned


CELLS = [(2, 3), (3, 2), (4, 4), (5, 6)]
FOODS = {(3, 3): 3, (1, 3): 2, (5, 5): 1, (4, 6): 3}


@pytest.mark.parametrize("levels", [[1, 2, 1, 2], [2, 2, 2, 2], [1, 1, 1, 1], [2, 1, 2, 1]])
@pytest.mark.parametrize("loading", [(0,), (0, 1), (0, 1, 2, 3), (3,), ()])
def test_foragers_see_and_earn_what_they_do_in_the_released_code(
    levels: list[int], loading: tuple[int, ...]
) -> None:
    env, state = foragers(CELLS, levels, FOODS)
    seen = env.get_obs(state)
    assert seen.shape == (4, 8, 8, 3)
    for agent in range(4):
        np.testing.assert_array_equal(seen[agent], released_view(env, CELLS, levels, FOODS, agent))
    actions = [LOAD if agent in loading else FORAGER_STAY for agent in range(4)]
    _, _, reward, _, info = env.step_env(jax.random.key(1), state, actions)
    wanted = released_rewards(CELLS, levels, FOODS, actions)
    np.testing.assert_allclose(reward, wanted, atol=1e-6)
    np.testing.assert_allclose(info["original_rewards"], wanted, atol=1e-6)
    shared, same = foragers(CELLS, levels, FOODS, shared_rewards=True)
    np.testing.assert_allclose(
        shared.step_env(jax.random.key(1), same, actions)[2], [wanted.sum()] * 4, atol=1e-5
    )
    scaled, same = foragers(CELLS, levels, FOODS, svo=True)
    np.testing.assert_allclose(
        scaled.step_env(jax.random.key(1), same, actions)[4]["original_rewards"],
        4 * wanted,
        atol=1e-5,
    )


def test_the_last_food_ends_an_episode_of_foraging() -> None:
    env, state = foragers([(2, 3), (4, 4)], [1, 2], {(1, 3): 1})
    _, _, reward, done, _ = env.step_env(jax.random.key(1), state, [LOAD, FORAGER_STAY])
    assert (reward.tolist(), bool(done["__all__"])) == ([1.0, 0.0], True)
    assert env.num_inner_steps == 100
    with pytest.raises(ValueError, match="sight must be 8; for another window, change"):
        socialjax.make("lb_foraging", sight=5)
    fewer = socialjax.make(
        "lb_foraging", num_food=2, max_food_level=5, max_player_level=3, load_penalty=0.5
    )
    _, state = resets(fewer, 1)
    assert int((state.game.floor_food > 0).sum()) <= 2, "a try is lost where there is no floor"


# Territory


def test_territory_pays_and_shows_what_it_does_in_the_released_code() -> None:
    """A hundredth for each brick owned that neither paint nor a zap has changed for 100 steps; shared: the mean, else as it is.

    What is owned or struck looks bare, and what is free is the seventh channel.
    """
    for shared, scale in ((False, 1.0), (True, 1 / 9)):
        env = socialjax.make("territory_open", shared_rewards=shared)
        assert (env.num_agents, env.num_inner_steps) == (9, 1000)
        _, state = resets(env, 0)
        bricks = [
            (r, c)
            for r, row in enumerate(env.env.game.rows)
            for c, glyph in enumerate(row)
            if glyph == "R"
        ]
        assert len(bricks) == 88
        owner = (
            jnp.full(88, -1, state.game.brick_owner.dtype)
            .at[jnp.asarray([0, 1, 2])]
            .set(jnp.asarray([4, 4, 7], state.game.brick_owner.dtype))
        )
        paint = jnp.zeros(88, state.game.brick_paint.dtype).at[:3].set(1)
        for quiet, owned in ((98, 0), (99, 1)):
            calm = jnp.full(88, quiet, state.game.brick_quiet.dtype)
            held = state.replace(
                game=state.game.replace(brick_owner=owner, brick_paint=paint, brick_quiet=calm)
            )
            _, _, reward, *_ = env.step_env(jax.random.key(1), held, [STAY] * 9)
            wanted = owned * 0.01 * np.array([0, 0, 0, 0, 2, 0, 0, 1, 0])
            np.testing.assert_allclose(
                reward, [wanted.sum() * scale] * 9 if shared else wanted, atol=1e-6
            )
        held = with_agent(env, held, [(2, 3), *((20, 2 + agent) for agent in range(8))], [0] * 9)
        seen = env.get_obs(held)[0]
        (row, _) = bricks[0]
        assert seen[9 - (2 - row), 5, 6] == 0, "owned"
        free = held.replace(game=held.game.replace(brick_owner=jnp.full_like(owner, -1)))
        assert env.get_obs(free)[0, 9 - (2 - row), 5, 6] == 1


# Spaces

SPACES = """
class Box:
    def __init__(self, low, high, shape, dtype=None):
        self.low, self.high, self.shape, self.dtype = low, high, shape, dtype

class Discrete:
    def __init__(self, num_categories, dtype="int64"):
        self.n, self.shape, self.dtype = num_categories, (), dtype
"""


@pytest.fixture
def suite(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Returns the folder of a package laid out like the suite's, which is forgotten afterwards."""
    folder = tmp_path / "socialjax/environments"
    folder.mkdir(parents=True)
    (tmp_path / "socialjax/__init__.py").touch()
    (folder / "__init__.py").touch()
    (folder / "spaces.py").write_text(SPACES)
    monkeypatch.syspath_prepend(str(tmp_path))
    spaces.space_classes.cache_clear()
    yield folder
    spaces.space_classes.cache_clear()
    for name in [name for name in sys.modules if name.split(".")[0] == "socialjax"]:
        del sys.modules[name]
    importlib.invalidate_caches()


def test_spaces_are_those_that_the_suites_wrappers_test_for(suite: Path) -> None:
    del suite
    theirs = importlib.import_module("socialjax.environments.spaces")
    env = socialjax.make("coin_game")
    assert isinstance(env.observation_space()[0], theirs.Box) and isinstance(
        env.action_space(), theirs.Discrete
    )
    assert (env.observation_space()[0].shape, env.action_space().n, env.action_space().dtype) == (
        (11, 11, 14),
        7,
        jnp.int32,
    )
    assert (
        env.observation_spaces == env.action_spaces == {}
    )  # its manager fills them itself where they are empty
