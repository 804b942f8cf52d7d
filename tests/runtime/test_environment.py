"""The environment interface on a small game: what it reports, under every transformation, at an episode's end."""

import importlib.util
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import sjdsl
from sjdsl import make
from sjdsl.library.factory import load_module
from sjdsl.runtime.env import Environment
from sjdsl.runtime.tokens import to_channels

YARD = Path(__file__).parent / "yard.sj"
ROWS = ("T..T", "TT#.", ".T..")
TURN_LEFT, TURN_RIGHT, FORWARD, STAY, REST = range(5)
TREES = 5
LENGTH = 6


@pytest.fixture(scope="module")
def env() -> Environment:
    return make(YARD)


def keys(seed: int, number: int) -> jax.Array:
    return jax.random.split(jax.random.key(seed), number)


def random_actions(seed: int, *shape: int) -> jax.Array:
    return jnp.asarray(np.random.default_rng(seed).integers(-1, 6, (*shape, 3)), jnp.int32)


def assert_same(found: Any, expected: Any) -> None:
    """Equal in structure, dtype and every bit."""
    assert jax.tree.structure(found) == jax.tree.structure(expected)
    for a, b in zip(jax.tree.leaves(found), jax.tree.leaves(expected), strict=True):
        assert a.dtype == b.dtype
        np.testing.assert_array_equal(np.asarray(a), np.asarray(b))


# What it says about itself


def test_the_length_is_known_inside_jit(env: Environment, tmp_path: Path) -> None:
    """Also where the file writes a number, as most do: a rollout is that long."""
    written = tmp_path / "yard.sj"
    text = YARD.read_text("utf-8").replace("  episode length\n", "  episode 4\n")
    assert "episode 4" in text
    written.write_text(text, "utf-8")
    for length, made in ((LENGTH, env), (4, make(written))):
        assert jax.eval_shape(lambda made=made: jnp.zeros(made.episode_length)).shape == (length,)


def test_what_a_step_tells(env: Environment) -> None:
    _, state = env.reset(jax.random.key(0))
    observation, *_, info = env.step(jax.random.key(1), state, random_actions(0))
    assert set(info) == {
        "truncated",
        "terminated",
        "events",
        "metrics",
        "terminal_observation",
        "terminal_state",
    }
    events = {name: value.shape for name, value in info["events"].items()}
    assert events == {"visits[none]": (3,), "visits[ripe]": (3,), "rests": ()}
    assert {*info["metrics"]} == {"ripe"}
    assert_same(info["terminal_observation"], observation)


def test_observe_gives_the_observation_of_a_state(env: Environment) -> None:
    first, state = env.reset(jax.random.key(0))
    assert_same(env.observe(state), first)
    seen, state, *_ = env.step(jax.random.key(1), state, random_actions(1))
    assert_same(env.observe(state), seen)


def test_cells_are_where_agents_stand(env: Environment) -> None:
    """On grass after a reset, each on its own; and where a step leads on the map leads in `cells`."""
    for key in keys(0, 5):
        _, state = env.reset(key)
        places = list(zip(*(x.tolist() for x in env.cells(state)), strict=True))
        assert len(set(places)) == 3
        assert all(ROWS[r][c] == "." for r, c in places)
    before = env.cells(state)
    state = state.replace(heading=jnp.full(3, 3, jnp.int32))
    _, state, *_ = env.step_env(jax.random.key(9), state, jnp.full(3, FORWARD))
    for r, c, r2, c2 in zip(*before, *env.cells(state), strict=True):
        assert (int(r2), int(c2)) in {(int(r), int(c)), (int(r), int(c) - 1)}


def test_allowed_actions(env: Environment) -> None:
    _, state = env.reset(jax.random.key(0))
    assert env.allowed_actions(state).tolist() == [[True] * 5] * 3
    tired = state.replace(agent_tired=jnp.array([0, 2, 1], state.agent_tired.dtype))
    row = [True, True, False, True, False]
    assert env.allowed_actions(tired).tolist() == [[True] * 5, row, row]


def test_unknown_actions_are_stay(env: Environment) -> None:
    _, state = env.reset(jax.random.key(0))
    key = jax.random.key(1)
    stay = env.step(key, state, jnp.full(3, STAY))
    for number in (-1, -7, 5, 6, 10_000, -(2**31), 2**31 - 1):
        assert_same(env.step(key, state, jnp.full(3, number)), stay)
    mixed = env.step(key, state, jnp.array([FORWARD, 5, REST]))
    assert_same(mixed, env.step(key, state, jnp.array([FORWARD, STAY, REST])))


# Keys


@pytest.mark.parametrize("seed", [0, 7])
def test_old_style_keys_are_typed_keys(env: Environment, seed: int) -> None:
    typed, old = jax.random.key(seed), jax.random.PRNGKey(seed)
    assert_same(env.reset(old), env.reset(typed))
    _, state = env.reset(old)
    assert_same(
        env.step(old, state, random_actions(seed)), env.step(typed, state, random_actions(seed))
    )


# Ends of episodes


def test_an_episode_ends_after_its_length_and_begins_anew(env: Environment) -> None:
    """The state after the last step is that of a reset with the step's key; the last observation is kept beside."""
    _, state = env.reset(jax.random.key(0))
    for episode in range(2):
        for t, key in enumerate(keys(10 + episode, LENGTH)):
            actions = random_actions(100 * episode + t)
            plain = env.step_env(key, state, actions)
            observation, after, reward, done, info = env.step(key, state, actions)
            assert_same((reward, done, info), plain[2:])
            assert_same(info["terminal_observation"], plain[0])
            assert (bool(done), bool(info["truncated"]), bool(info["terminated"])) == (
                t == LENGTH - 1,
            ) * 2 + (False,)
            assert int(plain[1].step) == t + 1
            assert_same((observation, after), env.reset(key) if bool(done) else plain[:2])
            state = after


def test_an_end_terminates(env: Environment) -> None:
    """The last apple is eaten: terminated, not truncated, also when the episode's length is reached in this step."""
    _, state = env.reset(jax.random.key(0))
    bare = state.replace(tree_fruit=jnp.zeros(TREES, jnp.uint8))
    never = env.params.replace(regrow=jnp.float32(0))
    for step in (0, LENGTH - 1):
        key = jax.random.key(1)
        observation, after, _, done, info = env.step(
            key, bare.replace(step=jnp.int32(step)), jnp.full(3, STAY), never
        )
        assert (bool(done), bool(info["truncated"]), bool(info["terminated"])) == (
            True,
            False,
            True,
        )
        assert_same((observation, after), env.reset(key, never))
        assert float(info["metrics"]["ripe"]) == 0
        assert not bool((info["terminal_observation"] == observation).all())


# Parameters


def test_parameters_of_a_call(env: Environment) -> None:
    """They replace the environment's own: in the rewards, the chances and the length."""
    _, state = env.reset(jax.random.key(0))
    on_tree = state.replace(
        position=jnp.array([tree_cell(env, 0, 0), *state.position[1:].tolist()], jnp.int32)
    )
    stay = jnp.full(3, STAY)
    assert env.step_env(jax.random.key(1), on_tree, stay)[2].tolist() == [1, 0, 0]
    assert env.step_env(
        jax.random.key(1), on_tree, stay, env.params.replace(apple=jnp.float32(-2.5))
    )[2].tolist() == [-2.5, 0, 0]
    short = env.params.replace(length=jnp.int32(1))
    assert bool(env.step(jax.random.key(1), state, stay, short)[3])
    assert not bool(env.step(jax.random.key(1), state, stay)[3])
    picked = state.replace(tree_fruit=jnp.array([1, 0, 0, 0, 0], jnp.uint8))
    for chance in (0, 1):
        _, after, *_ = env.step_env(
            jax.random.key(1), picked, stay, env.params.replace(regrow=jnp.float32(chance))
        )
        assert after.tree_fruit.tolist() == [1, *[chance] * 4]


def tree_cell(env: Environment, row: int, col: int) -> int:
    """Returns the number of a cell in the padded frame."""
    return (row + env.module.PAD) * env.module.FRAME[1] + col + env.module.PAD


# One-hot observations


def channels_by_hand(env: Environment, tokens: np.ndarray) -> np.ndarray:
    """Returns the one-hot form of tokens, label by label."""
    columns = []
    for index, plane in enumerate(env.token_planes):
        value = tokens[..., index, :, :]
        match plane.encoding:
            case "word":
                columns += [value == number for number in range(len(plane.labels))]
            case "bits":
                columns += [(value >> number) % 2 for number in range(len(plane.labels))]
            case "number":
                columns.append(value)
    return np.stack(columns, axis=-3).astype(np.uint8)


def test_onehot_holds_what_tokens_hold(env: Environment) -> None:
    onehot = make(YARD, observation="onehot")
    assert onehot.observation_shape == (3, len(onehot.channel_names), 4, 4)
    tokens, state = env.reset(jax.random.key(0))
    channels, same = onehot.reset(jax.random.key(0))
    assert_same(same, state)
    for t, key in enumerate(keys(2, 4)):
        assert (channels.shape, channels.dtype) == (onehot.observation_shape, jnp.uint8)
        np.testing.assert_array_equal(channels, channels_by_hand(env, np.asarray(tokens)))
        np.testing.assert_array_equal(
            channels, to_channels(tokens, env.token_planes, jnp.dtype(jnp.uint8))
        )
        for first in ("content: ", "agent: "):
            shown = [i for i, name in enumerate(onehot.channel_names) if name.startswith(first)]
            assert (np.asarray(channels)[:, shown].sum(axis=1) == 1).all()
        actions = random_actions(200 + t)
        tokens, state, *_ = env.step(key, state, actions)
        channels, *_ = onehot.step(key, same, actions)
        same = state


# Making


def test_a_small_map_for_fewer_agents() -> None:
    assert make("harvest_open", num_agents=2, map=("QQ.PP", "..A..")).num_agents == 2


@pytest.mark.parametrize("name", sjdsl.__all__)
def test_no_module_has_the_name_of_something_public(name: str) -> None:
    """Importing it would put the module in the other's place."""
    assert importlib.util.find_spec(f"sjdsl.{name}") is None


def test_a_game_made_while_another_function_is_traced() -> None:
    """Its tables are constants, not part of the trace: the same game is made again outside."""
    load_module.cache_clear()
    inside = jax.jit(lambda key: make(YARD).reset(key)[0])(jax.random.key(3))
    np.testing.assert_array_equal(inside, make(YARD).reset(jax.random.key(3))[0])
