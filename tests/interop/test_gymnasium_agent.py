"""One agent's environment: Gymnasium's own checks, and the game's own step as the oracle."""

import subprocess
import sys
import warnings
from pathlib import Path

import gymnasium
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import sjdsl
from sjdsl.interop.gymnasium import AgentGame, environment_id
from sjdsl.trainers import PPOConfig, load_policy
from sjdsl.trainers.policies.loading import parameter_shapes
from sjdsl.trainers.policies.policy_file import write_policy
from sjdsl.trainers.runs.run_folder import describe_game

LENGTH = 12
SHORT = {"params": {"length": LENGTH}}


@pytest.mark.parametrize("observation", ["onehot", "tokens"])
def test_gymnasiums_own_checks_pass(observation: str) -> None:
    """Without a warning; every way of drawing included."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(
            gymnasium.make(
                "sjdsl/Coins-v0", observation=observation, render_mode="ansi", **SHORT
            ).unwrapped
        )


def test_bundled_games_are_registered() -> None:
    assert environment_id("clean_up") == "sjdsl/CleanUp-v0"
    assert {
        environment_id(game) for game in ("coins", "pd_arena", "harvest_open", "predator_prey")
    } <= set(gymnasium.registry)
    env = gymnasium.make("sjdsl/Coins-v0", agent=1, others="stay", **SHORT)
    assert env.unwrapped.agent == 1
    _, info = env.reset(seed=0)
    assert info["action_mask"].tolist() == [1] * 7
    assert env.action_space.sample(info["action_mask"]) in env.action_space
    for step in range(LENGTH):
        observation, reward, terminated, truncated, info = env.step(step % 7)
        assert observation in env.observation_space
        assert (terminated, truncated) == (False, step == LENGTH - 1)
        assert reward == info["rewards"][1]


def test_a_step_is_the_games_own() -> None:
    """The others are a function that says what it does; the same actions in the game itself come to the same pictures and rewards."""
    played: list[list[int]] = []

    def others(key: jax.Array, observation: jax.Array) -> jax.Array:
        assert observation.shape == game.observation_shape  # tokens of everybody
        chosen = jax.random.randint(key, (2,), 0, 7) + 0 * observation[0, 0, 0, 0]
        jax.debug.callback(lambda actions: played.append(actions.tolist()), chosen)
        return chosen

    game, shown = (
        sjdsl.make("coins", params={"spawn": 0.3, "length": 40}),
        sjdsl.make("coins", observation="onehot"),
    )
    env = AgentGame("coins", agent=1, others=others, params={"spawn": 0.3, "length": 40})
    observation, _ = env.reset(seed=7)
    state = env._state
    collected = 0
    for step in range(40):
        before = env._key
        observation, reward, _, truncated, info = env.step((3 * step) % 7)
        jax.effects_barrier()
        actions = [played[-1][0], (3 * step) % 7]
        *_, state, paid, done, facts = game.step_env(
            jax.random.split(before, 3)[2], state, jnp.asarray(actions)
        )
        np.testing.assert_array_equal(
            observation, np.moveaxis(np.asarray(shown.observe(state)[1]), 0, -1)
        )
        assert info["rewards"].tolist() == paid.tolist() and reward == float(paid[1])
        assert info["own_coins"] == int(facts["events"]["own_coins"][1])
        assert truncated == bool(done)
        collected += info["own_coins"]
    assert collected > 0
    assert len({tuple(actions) for actions in played}) > 10


def test_others_may_be_a_stored_policy(tmp_path: Path) -> None:
    """It acts as it does elsewhere: the same key and tokens, the same actions."""
    game, config = sjdsl.make("coins", params={"length": LENGTH}), PPOConfig()
    shapes = parameter_shapes(game, config)
    drawn = jax.tree.map(
        lambda leaf: np.random.default_rng(leaf.size).normal(0, 0.1, leaf.shape).astype(leaf.dtype),
        shapes,
    )
    stored = tmp_path / "run/policies/last.safetensors"
    write_policy(
        stored,
        drawn,
        {
            "game": describe_game(game),
            "config": config.model_dump(mode="json"),
            "update": 0,
            "env_steps": 0,
            "seed": 0,
        },
    )
    env = AgentGame("coins", others=tmp_path / "run", **SHORT)
    env.reset(seed=1)
    for number in range(4):
        key, state = env._key, env._state
        env.step(6)
        _, others_key, step_key = jax.random.split(key, 3)
        actions = load_policy(stored, game)(others_key, game.observe(state)).at[0].set(6)
        _, after, *_ = game.step_env(step_key, state, actions)
        assert jax.tree.all(jax.tree.map(jnp.array_equal, after, env._state)), number
    assert (
        AgentGame("coins", others=str(stored), **SHORT).reset(seed=1)[0].shape
        == env.observation_space.shape
    )


PROCESSES = """
import gymnasium, sys
import sjdsl.interop.gymnasium

if __name__ == "__main__":
    context = {"context": sys.argv[1]}
    env = gymnasium.make_vec("sjdsl/Coins-v0", num_envs=2, vectorization_mode="async", vector_kwargs=context, params={"length": 3})
    env.reset(seed=1)
    print([env.step([0, 1])[3].tolist() for _ in range(3)])
    env.close()
"""


@pytest.mark.parametrize("context", ["fork", "spawn"])
def test_processes_are_spawned(tmp_path: Path, context: str) -> None:
    """Forked ones, in which JAX would wait for ever, end with what to write instead."""
    script = tmp_path / "processes.py"
    script.write_text(PROCESSES)
    done = subprocess.run(
        [sys.executable, str(script), context],
        capture_output=True,
        text=True,
        check=False,
        timeout=500,
    )
    if context == "fork":
        assert done.returncode != 0
        assert """vectorization_mode="async", vector_kwargs={"context": "spawn"})""" in done.stderr
    else:
        assert done.returncode == 0, done.stderr
        assert done.stdout.splitlines()[-1] == "[[False, False], [False, False], [True, True]]"
