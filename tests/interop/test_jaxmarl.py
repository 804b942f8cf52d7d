"""The JaxMARL adapter: what JaxMARL's API tests ask for, and the game's own step as the oracle."""

from pathlib import Path

import jax
import jax.numpy as jnp
import jaxmarl
import numpy as np
import pytest
from jaxmarl.environments import MultiAgentEnv
from jaxmarl.environments.spaces import Space

import sjdsl
from sjdsl.interop.jaxmarl import JaxMARLGame, register
from tests.packaging.installed import GAME

LENGTH = 12
SHORT = {"params": {"length": LENGTH}}


def actions_of(env: JaxMARLGame, step: int) -> dict[str, jax.Array]:
    return {
        agent: jnp.int32((3 * step + number) % env.env.num_actions)
        for number, agent in enumerate(env.agents)
    }


@pytest.fixture(scope="module")
def coins() -> JaxMARLGame:
    return JaxMARLGame("coins", **SHORT)


@pytest.mark.parametrize("flat", [True, False])
@pytest.mark.parametrize("game", ["coins", "clean_up"])
def test_the_contract_of_the_base_class(game: str, flat: bool) -> None:
    env = JaxMARLGame(game, flat=flat, **SHORT)
    assert isinstance(env, MultiAgentEnv)
    assert env.name == game
    for agent in env.agents:
        assert (
            env.observation_spaces[agent] == env.observation_space(agent) == env.observation_space()
        )
        assert env.action_spaces[agent] == env.action_space(agent) == env.action_space()
        assert isinstance(env.observation_space(agent), Space) and isinstance(
            env.action_space(agent), Space
        )
    first, state = env.reset(jax.random.PRNGKey(0))
    keys = jax.random.split(jax.random.PRNGKey(1), env.num_agents)
    actions = {
        agent: env.action_space(agent).sample(key)
        for agent, key in zip(env.agents, keys, strict=True)
    }
    after, _, reward, done, info = env.step(jax.random.PRNGKey(2), state, actions)
    for observation in (first, after):
        assert list(observation) == env.agents
        assert all(env.observation_space(a).contains(observation[a]) for a in env.agents)
        assert all(observation[a].shape == env.observation_space(a).shape for a in env.agents)
    assert list(reward) == env.agents
    assert set(done) == {*env.agents, "__all__"}
    assert {leaf.shape for leaf in jax.tree.leaves(info)} == {(env.num_agents,)}
    assert first["agent_0"].ndim == (1 if flat else 3)


def test_a_step_is_the_games_own(coins: JaxMARLGame) -> None:
    """Over two episodes: observations, rewards, ends and events."""
    env = sjdsl.make("coins", observation="onehot", **SHORT)
    reset_key, *keys = jax.random.split(jax.random.key(3), 2 * LENGTH + 4)
    mine, state = coins.reset(reset_key)
    theirs, game = env.reset(reset_key)
    for number, key in enumerate(keys):
        np.testing.assert_array_equal(
            mine["agent_1"], np.moveaxis(np.asarray(theirs[1]), 0, -1).reshape(-1)
        )
        actions = actions_of(coins, number)
        mine, state, reward, done, info = coins.step(key, state, actions)
        theirs, game, raw, ended, facts = env.step(key, game, jnp.stack(list(actions.values())))
        assert [float(r) for r in reward.values()] == raw.tolist()
        assert (
            bool(done["__all__"])
            == bool(done["agent_0"])
            == bool(ended)
            == (number % LENGTH == LENGTH - 1)
        )
        np.testing.assert_array_equal(info["own_coins"], facts["events"]["own_coins"])
        assert info["truncated"].tolist() == [bool(facts["truncated"])] * 2
        assert int(state.step) == int(game.step) == (number + 1) % LENGTH


def test_a_chosen_state_follows_an_episode(coins: JaxMARLGame) -> None:
    first, then, last = jax.random.split(jax.random.key(4), 3)
    _, state = coins.reset(first)
    _, chosen = coins.reset(then)
    _, going, _, done, _ = coins.step(last, state, actions_of(coins, 0), reset_state=chosen)
    assert not done["__all__"] and int(going.step) == 1
    late = state.replace(step=coins.max_steps - 1)
    observation, after, _, done, _ = coins.step(
        last, late, actions_of(coins, 0), reset_state=chosen
    )
    assert done["__all__"]
    assert jax.tree.all(jax.tree.map(jnp.array_equal, after, chosen))
    np.testing.assert_array_equal(observation["agent_0"], coins.get_obs(chosen)["agent_0"])


def test_common_and_shaped_rewards() -> None:
    """Where the first agent takes a coin, both are paid the sum."""
    env, plain = JaxMARLGame("coins", common_reward=True, shaped_reward=True), JaxMARLGame("coins")
    keys = jax.random.split(jax.random.key(12), 400)
    _, state = env.reset(keys[0])
    paid = 0
    for number, key in enumerate(keys[1:]):
        actions = actions_of(env, number)
        _, _, raw, _, _ = plain.step(key, state, actions)
        _, state, reward, _, info = env.step(key, state, actions)
        assert (
            float(reward["agent_0"])
            == float(reward["agent_1"])
            == float(raw["agent_0"] + raw["agent_1"])
        )
        assert info["shaped_reward"] == {"agent_0": 0.0, "agent_1": 0.0}
        paid += float(raw["agent_0"]) != float(raw["agent_1"])
    assert paid > 0


def test_last_observations_are_kept_if_asked_for() -> None:
    env = JaxMARLGame("coins", terminal_observation=True, **SHORT)
    _, state = env.reset(jax.random.key(13))
    late = state.replace(step=env.max_steps - 1)
    key = jax.random.key(14)
    _, _, _, _, info = env.step(key, late, actions_of(env, 0))
    last, *_ = env.step_env(key, late, actions_of(env, 0))
    np.testing.assert_array_equal(info["terminal_observation"], jnp.stack(list(last.values())))


def test_masks_and_roles() -> None:
    """Who rests in the arena may only stay; predators and prey are two classes."""
    arena = JaxMARLGame("pd_arena")
    _, state = arena.reset(jax.random.key(15))
    resting = state.replace(
        game=state.game.replace(agent_resting=state.game.agent_resting.at[2].set(5))
    )
    masks = arena.get_avail_actions(resting)
    assert masks["agent_0"].all()
    assert [
        name
        for name, allowed in zip(arena.env.action_names, masks["agent_2"], strict=True)
        if allowed
    ] == ["stay"]
    assert arena.agent_classes == {"agents": arena.agents}
    hunt = JaxMARLGame("predator_prey").agent_classes
    assert sorted(map(len, hunt.values())) == sorted(
        np.unique(sjdsl.make("predator_prey").roles, return_counts=True)[1].tolist()
    )


def test_its_registry_makes_our_games(tmp_path: Path) -> None:
    """By the names of bundled games and of files; its own names and messages stay; registering again changes nothing."""
    assert {"sjdsl_clean_up", "sjdsl/clean_up", "sjdsl_coins", "MPE_simple_v3"} <= set(
        jaxmarl.registered_envs
    )
    env = jaxmarl.make("sjdsl_coins", flat=False, **SHORT)
    assert isinstance(env, JaxMARLGame) and env.name == "coins" and env.max_steps == LENGTH
    (tmp_path / "my_game.sj").write_text(GAME)
    assert (
        jaxmarl.make(f"sjdsl/{tmp_path}/my_game.sj").name
        == jaxmarl.make(f"sjdsl_{tmp_path}/my_game.sj").name
        == "my_game"
    )
    assert jaxmarl.make("sjdsl/coins", **SHORT).env.hash == env.env.hash
    assert jaxmarl.make("MPE_simple_v3").name == "SimpleMPE"
    with pytest.raises(ValueError, match="is not in registered jaxmarl environments"):
        jaxmarl.make("clean_up")
    with pytest.raises(FileNotFoundError, match="clean_upp"):
        jaxmarl.make("sjdsl/clean_upp")
    before = (jaxmarl.make, list(jaxmarl.registered_envs))
    register()
    assert (jaxmarl.make, list(jaxmarl.registered_envs)) == before
    assert jaxmarl.make is jaxmarl.registration.make
