"""The Mava adapter: Jumanji's own checks and wrappers, the game's own step as the oracle, Mava's scripts where MAVA=CHECKOUT names a copy."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import jumanji
import numpy as np
import pytest
from jumanji import specs
from jumanji.testing.env_not_smoke import check_env_does_not_smoke, check_env_specs_does_not_smoke
from jumanji.types import StepType
from jumanji.wrappers import VmapAutoResetWrapper

import sjdsl
from sjdsl.interop.mava import MavaGame

CHECKOUT = os.environ.get("MAVA")
LENGTH = 12
SHORT = {"params": {"length": LENGTH}}
KINDS = [
    {},
    {"flat": False, "global_state": "observations"},
    {"observation": "tokens", "global_state": "state"},
    {"common_reward": True, "global_state": "observations"},
]


@pytest.mark.parametrize("arguments", KINDS)
@pytest.mark.parametrize("game", ["coins", "pd_arena"])
def test_jumanjis_own_checks(game: str, arguments: dict[str, Any]) -> None:
    """They play an episode and look at each observation and action by the specs."""
    env = MavaGame(game, **arguments, **SHORT)
    assert isinstance(env, jumanji.Environment) and env.unwrapped is env
    check_env_does_not_smoke(env)
    check_env_specs_does_not_smoke(env)


def test_what_mava_asks_of_a_marl_env() -> None:
    """Attributes that are plain numbers, an action spec from which it tells discrete actions, rewards and discounts by agent."""
    env = MavaGame("clean_up", **SHORT)
    assert (env.num_agents, env.action_dim, env.time_limit) == (7, 9, LENGTH)
    assert {type(number) for number in (env.num_agents, env.action_dim, env.time_limit)} == {int}
    assert isinstance(env.action_spec, specs.MultiDiscreteArray)
    assert env.action_spec.num_values.tolist() == [9] * 7
    state, timestep = env.reset(jax.random.PRNGKey(0))
    _, after = env.step(state, env.action_spec.generate_value())
    for made in (timestep, after):
        env.reward_spec.validate(made.reward)
        env.discount_spec.validate(made.discount)
        env.observation_spec.validate(made.observation)
    assert timestep.observation._fields == ("agents_view", "action_mask", "step_count")
    carried = jax.tree.map(lambda leaf: (leaf.shape, leaf.dtype), (timestep, after))
    assert carried[0] == carried[1]  # a scan carries them
    assert jax.random.split(state.key).shape == (2, 2)  # its wrappers take keys from here


def test_a_step_is_the_games_own() -> None:
    """Over an episode: observations, rewards, masks, ends, events."""
    mine, game = MavaGame("coins", **SHORT), sjdsl.make("coins", observation="onehot", **SHORT)
    state, timestep = mine.reset(jax.random.key(3))
    theirs = state.game
    assert timestep.first() and timestep.reward.tolist() == [0, 0] and timestep.discount.tolist() == [1, 1]
    step, paid = jax.jit(mine.step), 0.0
    for number in range(LENGTH):
        actions = (3 * number + jnp.arange(2)) % 7
        seen, theirs, reward, done, info = game.step_env(jax.random.split(state.key)[1], theirs, actions)
        state, timestep = step(state, actions)
        np.testing.assert_array_equal(timestep.observation.agents_view, np.moveaxis(np.asarray(seen), 1, -1).reshape(2, -1))
        np.testing.assert_array_equal(timestep.observation.action_mask, game.allowed_actions(theirs))
        assert timestep.observation.step_count.tolist() == [number + 1] * 2
        assert timestep.reward.tolist() == reward.tolist()
        assert timestep.extras["events"]["own_coins"].tolist() == info["events"]["own_coins"].tolist()
        assert bool(timestep.last()) == bool(done) == (number == LENGTH - 1)
        assert timestep.discount.tolist() == [1, 1]  # it is cut off
        paid += float(jnp.abs(reward).sum())
    assert state.game.step == LENGTH


def test_an_end_by_the_rules_has_discount_0(tmp_path: Path) -> None:
    path = tmp_path / "endings.sj"
    path.write_text((Path(__file__).parents[1] / "cases/endings.sj").read_text())
    env = MavaGame(str(path))
    step = jax.jit(env.step)
    state, timestep = env.reset(jax.random.key(0))
    while not timestep.last():
        state, timestep = step(state, jnp.full(env.num_agents, env.env.action_names.index("forward")))
    assert int(timestep.observation.step_count[0]) < env.time_limit
    assert not timestep.discount.any()


def test_common_rewards_and_global_states() -> None:
    own, common = MavaGame("coins"), MavaGame("coins", common_reward=True, global_state="observations", flat=False)
    state, timestep = common.reset(jax.random.key(5))
    differed = 0
    for number in range(150):
        actions = (3 * number + jnp.arange(2)) % 7
        raw = own.step(state, actions)[1].reward
        state, timestep = common.step(state, actions)
        assert timestep.reward.tolist() == [float(raw.sum())] * 2
        differed += bool(raw[0] != raw[1])
    assert differed > 0
    views, whole = timestep.observation.agents_view, timestep.observation.global_state
    np.testing.assert_array_equal(whole[1], jnp.concatenate([views[0], views[1]], axis=-1))
    vector = MavaGame("coins", global_state="state")
    np.testing.assert_array_equal(
        vector.reset(jax.random.key(5))[1].observation.global_state[0].shape, (vector.env.state_vector(state.game).size,)
    )
    with pytest.raises(ValueError, match="global_state must be None, `observations` or `state`, not 'all'"):
        MavaGame("coins", global_state="all")


def test_jumanjis_wrapper_begins_episodes_anew() -> None:
    env = VmapAutoResetWrapper(MavaGame("coins", **SHORT))
    state, timestep = env.reset(jax.random.split(jax.random.PRNGKey(0), 3))
    starts = [timestep.observation.agents_view]
    step = jax.jit(env.step)
    for number in range(2 * LENGTH):
        state, timestep = step(state, jnp.full((3, 2), number % 7))
        assert (timestep.step_type == (StepType.LAST if number % LENGTH == LENGTH - 1 else StepType.MID)).all()
        if timestep.last().all():
            assert not timestep.observation.step_count.any()
            starts.append(timestep.observation.agents_view)
    assert len({np.asarray(start).tobytes() for start in starts}) == 3


TINY = {
    "+env.kwargs.params.length": 8,
    "arch.num_envs": 2,
    "arch.num_evaluation": 1,
    "arch.num_eval_episodes": 2,
    "arch.num_absolute_metric_eval_episodes": 2,
    "system.num_updates": 2,
    "system.rollout_length": 8,
    "system.update_batch_size": 1,
    "system.ppo_epochs": 1,
    "logger.checkpointing.save_model": True,
}
IMAGES = {"network": "cnn", "+env.kwargs.flat": False, "env.implicit_agent_id": True}


@pytest.mark.skipif(CHECKOUT is None, reason="MAVA names no checkout of Mava")
@pytest.mark.parametrize(("script", "more"), [("ff_ippo", {}), ("ff_mappo", IMAGES), ("rec_ippo", {})])
def test_mavas_own_scripts(tmp_path: Path, script: str, more: dict[str, Any]) -> None:
    """They train, evaluate, end with 0 and leave a policy. Their configurations are found from the checkout: it is linked into a folder."""
    (tmp_path / "mava").symlink_to(Path(str(CHECKOUT)).resolve() / "mava")
    stand_ins = Path(__file__).parent / "stand_ins/mava"
    call = [sys.executable, "-m", "sjdsl.interop", f"mava/systems/ppo/anakin/{script}.py", "env=sjdsl", "env.game=coins"]
    call += [f"{name}={value}" for name, value in {**TINY, **more}.items()]
    path = os.pathsep.join([str(stand_ins), str(Path(__file__).parents[2]), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(call, cwd=tmp_path, env=os.environ | {"PYTHONPATH": path}, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-6000:]
    assert "experiment completed" in done.stdout
    assert list((tmp_path / "checkpoints" / script).rglob("_CHECKPOINT_METADATA"))
