"""What callers hand to `make` and to an environment, refused with what to write instead; copies of environments and states."""

import copy
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl import make
from sjdsl.runtime.arguments import checked_actions
from sjdsl.runtime.env import Environment
from tests.runtime.test_environment import YARD, assert_same, keys


@pytest.fixture(scope="module")
def env() -> Environment:
    return make(YARD)


@pytest.mark.parametrize("actions", [None, {"agent_0": 1}])
def test_what_is_no_actions(env: Environment, actions: Any) -> None:
    _, state = env.reset(jax.random.key(0))
    for step in (env.step, env.step_env):
        with pytest.raises(
            TypeError, match=f"one for each agent in their order, not {type(actions).__name__}"
        ):
            step(jax.random.key(1), state, actions)


@pytest.mark.parametrize("number", [2**31, 2**32 + 1, -(2**31) - 1, 2**63])
def test_actions_beyond_int32(env: Environment, number: int) -> None:
    """Cut off to 32 bits, 2^32 + 1 would be action 1."""
    _, state = env.reset(jax.random.key(0))
    dtype = np.uint64 if number == 2**63 else np.int64
    for actions in (
        np.array([0, number, 0], dtype),
        [0, number, 0],
        (np.int64(0), dtype(number), np.int64(0)),
    ):
        for step in (env.step, env.step_env):
            with pytest.raises(ValueError, match=f"an action is {number}, which is beyond int32"):
                step(jax.random.key(1), state, actions)
    with jax.enable_x64(True):
        wide = jnp.array([0, number, 0], dtype)
        with pytest.raises(ValueError, match="beyond int32"):
            env.step(jax.random.key(1), state, wide)
        assert checked_actions(wide, 3).tolist() == [0, -1, 0]


def test_states_and_parameters_of_another_game(env: Environment, tmp_path: Path) -> None:
    """Also of the same game on a larger map, and of a batch; those of the game itself in other clothes are taken."""
    other, larger = make("coins"), make(YARD, map=("T..TT", "TT#..", ".T..."))
    actions = jnp.zeros(3, jnp.int32)
    _, mine = env.reset(jax.random.key(0))
    _, theirs = other.reset(jax.random.key(0))
    for state in (theirs, None, 3, (mine,), mine.position):
        for call in (
            lambda s: env.step(jax.random.key(1), s, actions),
            env.observe,
            env.allowed_actions,
        ):
            with pytest.raises(TypeError, match="this is not a state of yard but a"):
                call(state)
    with pytest.raises(ValueError, match=r"`tree_fruit` of the state has shape \(5,\), not"):
        larger.observe(mine)
    with pytest.raises(
        ValueError,
        match=r"`step` of the state has shape \(2,\), not \(\); for a batch of environments, jax.vmap the call",
    ):
        env.step(
            jax.random.key(1), jax.tree.map(lambda leaf: jnp.stack([leaf, leaf]), mine), actions
        )
    for params in (other.params, {"length": 3}, 3):
        for call in (
            lambda p: env.reset(jax.random.key(1), p),
            lambda p: env.observe(mine, p),
            env.with_params,
        ):
            with pytest.raises(TypeError, match="these are not parameters of yard but a"):
                call(params)
    copied = tmp_path / "yard.sj"
    copied.write_text(f"# a remark\n{YARD.read_text()}")
    assert_same(
        make(copied).step(jax.random.key(1), mine, actions)[0],
        env.step(jax.random.key(1), mine, actions)[0],
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"variant": 3}, "a variant is a name, and several are `first\\+second`; it is not 3"),
        (
            {"params": {1: 1}},
            "params has names of numbers of the game, not 1; it has players, respawn_delay, length",
        ),
        (
            {"params": [1]},
            "params is a mapping from names of numbers of the game to values, not \\[1\\]",
        ),
        ({"map": 3}, "a map is a text file or a tuple of its rows, not 3"),
        ({"map": (1,)}, "a row of a map is a text, not 1"),
        ({"game": None}, "a game is a name or the path of a .sj file, not None"),
    ],
)
def test_arguments_that_cannot_be_meant(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(TypeError, match=message):
        make(**{"game": "harvest_open", **arguments})


@pytest.mark.parametrize("three", [np.int64(3), np.uint8(3), np.array(3), jnp.int32(3)])
def test_numbers_of_numpy_and_jax(three: Any) -> None:
    wanted = make("harvest_open", num_agents=3).hash
    assert (
        make("harvest_open", num_agents=three).hash
        == make("harvest_open", params={"players": three}).hash
        == wanted
    )


def test_what_is_no_key(env: Environment) -> None:
    _, state = env.reset(jax.random.key(0))
    calls = (env.reset, lambda key: env.step(key, state, jnp.zeros(3, jnp.int32)))
    for call in calls:
        for key in (None, state):
            with pytest.raises(TypeError, match="a key is a typed key"):
                call(key)
        for key in (5, jnp.zeros(3, jnp.uint32), jnp.zeros(2)):
            with pytest.raises(ValueError, match="a key is a typed key"):
                call(key)
        for key in (keys(0, 3), keys(0, 2), keys(0, 1), jax.random.split(jax.random.PRNGKey(0), 2)):
            with pytest.raises(
                ValueError,
                match=r"a key is a typed key .*, not .*; for a batch of environments, jax.vmap the call",
            ):
                call(key)


@pytest.mark.thorough
def test_copies(env: Environment, tmp_path: Path) -> None:
    """By `copy`, and by `pickle` in another process: the same state and step."""
    _, state = env.reset(jax.random.key(0))
    actions = jnp.array([0, 2, 4], jnp.int32)
    played = env.step(jax.random.key(1), state, actions)
    for copied, there in (
        copy.copy((env, state)),
        copy.deepcopy((env, state)),
        pickle.loads(pickle.dumps((env, state))),
    ):
        assert (copied.hash, copied.observation) == (env.hash, env.observation)
        assert_same(copied.step(jax.random.key(1), there, actions), played)
    cheap = env.with_params(env.params.replace(apple=jnp.float32(0.5)))
    (tmp_path / "before").write_bytes(pickle.dumps((cheap, state, actions)))
    read = "import pickle, jax, sys; env, state, actions = pickle.load(open('before', 'rb'))"
    play = "pickle.dump(env.step(jax.random.key(1), state, actions)[1:3], open('after', 'wb'))"
    subprocess.run([sys.executable, "-c", f"{read}; {play}"], cwd=tmp_path, check=True)
    after, reward = pickle.loads((tmp_path / "after").read_bytes())
    assert_same(after, played[1])
    np.testing.assert_array_equal(reward, played[2] * 0.5)
