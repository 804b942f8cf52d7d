"""What every game keeps to: shapes and dtypes, one agent a cell, nobody in a wall, a thousand steps, one key one result."""

from functools import cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from .environments import HARVESTS, NINE, environment, places

STEPS = 1010  # an episode and the beginning of the next
LENGTH = 1000
# number of actions and of agents. Source: the released code; the agents of Coop Mining, Gift, Mushrooms and PD as decided for this project
ACTIONS = {"coins": 7, **dict.fromkeys(HARVESTS, 8), "clean_up": 9, "coop_mining": 8, "gift_refinement": 9, "mushrooms": 8, "pd_arena": 8}
AGENTS = {"coins": 2, **dict.fromkeys(HARVESTS, 7), "clean_up": 7, "coop_mining": 6, "gift_refinement": 5, "mushrooms": 5, "pd_arena": 4}


@cache
def runner(game: str) -> Any:
    """Returns a function from a seed to a run with random actions: what is small for every step, the last step whole."""
    env = environment(game)

    def run(key: jax.Array) -> tuple[Any, Any]:
        def advance(state: Any, key: jax.Array) -> tuple[Any, Any]:
            k_actions, k_step = jax.random.split(key)
            actions = jax.random.randint(k_actions, (env.num_agents,), -1, env.num_actions + 1)
            _, after, reward, done, info = env.step(k_step, state, actions)
            outcome = {key: info[key] for key in ("truncated", "terminated", "events", "metrics")}
            return after, {"position": after.position, "step": after.step, "reward": reward, "done": done, **outcome}

        k_reset, k_steps, k_last = jax.random.split(key, 3)
        first, state = env.reset(k_reset)
        state, history = jax.lax.scan(advance, state, jax.random.split(k_steps, STEPS))
        last = env.step(k_last, state, jnp.full(env.num_agents, env.action_names.index("forward")))
        return history, (first, last)

    return jax.jit(run)


@cache
def played(game: str) -> tuple[Any, Any]:
    return jax.tree.map(np.asarray, runner(game)(jax.random.key(0)))


each_game = pytest.mark.parametrize("game", NINE)


@each_game
def test_description(game: str) -> None:
    env = environment(game)
    assert (env.name, env.num_agents, env.num_actions, env.episode_length) == (game, AGENTS[game], ACTIONS[game], LENGTH)
    assert len(set(env.action_names)) == env.num_actions
    assert env.action_names[:7] == ("turn_left", "turn_right", "step_left", "step_right", "forward", "backward", "stay")
    assert env.observation_shape == (env.num_agents, 11, 11, len(env.token_planes))
    assert len(set(env.channel_names)) == len(env.channel_names) == sum(len(p.channels) for p in env.token_planes)


@each_game
def test_shapes_and_dtypes(game: str) -> None:
    env, agents = environment(game), AGENTS[game]
    history, (first, (observation, state, reward, done, info)) = played(game)
    for seen in (first, observation, info["terminal_observation"]):
        assert (seen.shape, seen.dtype) == (env.observation_shape, np.uint8)
    assert (reward.shape, reward.dtype) == ((agents,), np.float32)
    assert (done.shape, done.dtype) == ((), np.bool_)
    for flag in ("truncated", "terminated"):
        assert (info[flag].shape, info[flag].dtype) == ((), np.bool_)
    per_agent = {e.name for e in env.game.events if e.per_agent}
    for name, value in info["events"].items():
        assert (value.shape, value.dtype) == ((agents,) if name.split("[")[0] in per_agent else (), np.int32)
    for value in info["metrics"].values():
        assert (value.shape, value.dtype) == ((), np.float32)
    assert (state.position.shape, state.heading.shape, state.step.shape) == ((agents,), (agents,), ())
    assert np.isfinite(history["reward"]).all()


@each_game
def test_an_episode_has_a_thousand_steps(game: str) -> None:
    """Truncated after exactly that many, never terminated; then the next begins."""
    history, _ = played(game)
    assert np.flatnonzero(history["done"]).tolist() == [LENGTH - 1]
    np.testing.assert_array_equal(history["done"], history["truncated"])
    assert not history["terminated"].any()
    assert history["step"].tolist() == [*range(1, LENGTH), *range(STEPS - LENGTH + 1)]


@each_game
def test_one_agent_a_cell_and_none_in_a_wall(game: str) -> None:
    env = environment(game)
    history, _ = played(game)
    where = places(env, history["position"])
    rows, cols = len(env.game.rows), len(env.game.rows[0])
    assert (where >= 0).all()
    assert (where < (rows, cols)).all()
    flat = np.sort(where[..., 0] * cols + where[..., 1], axis=1)
    assert (np.diff(flat, axis=1) > 0).all()
    glyphs = np.array([list(row) for row in env.game.rows])
    assert not (glyphs[where[..., 0], where[..., 1]] == "#").any()


@each_game
def test_an_agent_goes_one_cell_or_home(game: str) -> None:
    """Between two steps of an episode: no farther than a neighbour cell, but to where this game sends agents."""
    env = environment(game)
    history, _ = played(game)
    where = places(env, history["position"])[: LENGTH - 1]
    far = np.abs(np.diff(where, axis=0)).sum(axis=2) > 1
    landed = where[1:][far]
    homes = {"coins": "", **dict.fromkeys(HARVESTS, "P"), "clean_up": "P", "coop_mining": "", "gift_refinement": "", "pd_arena": "P"}
    glyphs = {env.game.rows[r][c] for r, c in landed}
    assert game == "mushrooms" or glyphs <= set(homes[game])


@each_game
def test_something_happens(game: str) -> None:
    """Random play is not without events or reward: the tests above saw the rules at work."""
    history, _ = played(game)
    assert sum(int(count.sum()) for count in history["events"].values()) > 0
    assert np.abs(np.diff(history["position"], axis=0)).sum() > 0


@each_game
def test_one_sees_oneself_in_the_window(game: str) -> None:
    """In row 9, column 5, and nowhere else; every plane holds values it has a meaning for."""
    env = environment(game)
    _, (first, (observation, *_)) = played(game)
    planes = [p.name for p in env.token_planes]
    for seen in (first, observation):
        own = seen[..., planes.index("agent")] == 1
        assert own[:, 9, 5].all()
        assert own.sum() == env.num_agents
        for index, plane in enumerate(env.token_planes):
            most = {"word": len(plane.labels) - 1, "bits": 2 ** len(plane.labels) - 1, "number": plane.high}[plane.encoding]
            assert seen[..., index].max() <= most


@each_game
def test_the_same_key_gives_the_same_run(game: str) -> None:
    again = jax.tree.map(np.asarray, runner(game)(jax.random.key(0)))
    for a, b in zip(jax.tree.leaves(played(game)), jax.tree.leaves(again), strict=True):
        np.testing.assert_array_equal(a, b)
    other, _ = jax.tree.map(np.asarray, runner(game)(jax.random.key(1)))
    assert (other["position"] != played(game)[0]["position"]).any()
