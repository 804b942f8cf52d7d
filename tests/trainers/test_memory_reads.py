"""Agents with memory that read their last action, their last reward and where trials begin."""

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from probes import FAST_TO_COMPILE, Probe, learn, quick, uneven
from run_outcomes import assert_same_end, copy_run

from sjdsl.runtime.policy import MemoryPolicy
from sjdsl.trainers import evaluate, load_policy, make_config, make_train, resume, train
from sjdsl.trainers.algorithms.ppo import make_batch
from sjdsl.trainers.networks.actor_critics import ActorCritics, make_actor_critics
from sjdsl.trainers.networks.last_step import last_step_features
from sjdsl.trainers.policies.loading import parameter_shapes, trained_policy
from sjdsl.trainers.policies.policy_file import write_policy
from sjdsl.trainers.runs.recorder import Recorder
from sjdsl.trainers.runs.run_folder import describe_game

ALL = ("action", "reward", "trial")
READING: dict[str, Any] = {"memory": "gru", "memory_reads": ALL}
ENVS, STEPS = 4, 7
CENTRAL = {"algorithm": "mappo"}


@dataclass(frozen=True)
class Tried(Probe):
    """A probe whose episodes have trials of two steps."""

    def step_env(self, *arguments: Any) -> tuple[Any, ...]:
        observation, after, reward, done, info = super().step_env(*arguments)
        return observation, after, reward, done, info | {"trial_ended": after.step % 2 == 0}


@cache
def tried() -> Probe:
    """Five steps or two, in trials of two, which pay agent 0 one or two for its action, and agent 1 nothing."""
    return Tried(
        "tried",
        reward=lambda _, actions: (1.0 + actions) * jnp.array([1.0, 0.0]),
        length=lambda state: 2 + 3 * state.cue,
        truncates=True,
    )


@cache
def bandit() -> Probe:
    """Two arms, one of which pays 1 in each of five steps; nothing shows which."""
    return Probe(
        "bandit",
        reward=lambda state, actions: actions == state.cue,
        length=lambda _: jnp.int32(5),
    )


def drawn(env: Probe, config: Any) -> Any:
    """Returns parameters with which actions depend on what is read."""
    generator = np.random.default_rng(2)
    return jax.tree.map(
        lambda leaf: jnp.asarray(generator.normal(0, 0.4, leaf.shape), leaf.dtype),
        parameter_shapes(env, config),
    )


@cache
def two_rollouts(env: Probe, config: Any) -> tuple[Any, Any, Any]:
    """Returns what was played in a run's first two rollouts, and the parameters."""
    program = make_train(env, config)
    assert program.adopt is not None
    parameters = drawn(env, config)

    def play(key: jax.Array) -> tuple[Any, Any]:
        state = program.adopt(program.init(key), parameters)
        state, first = program.collect(state)
        return first, program.collect(state)[1]

    played = jax.jit(play, compiler_options=FAST_TO_COMPILE)(jax.random.key(0))
    return *played, parameters


def read(networks: ActorCritics, parameters: Any, memory: Any, seen: Any, fresh: Any) -> Any:
    """Returns the memory, logits and values of L steps of one environment, seen in one go."""
    program = jax.jit(
        lambda parameters: networks.apply(
            parameters, memory, seen, networks.joint(seen, None), fresh
        ),
        compiler_options=FAST_TO_COMPILE,
    )
    return program(parameters)


def inputs_by_hand(rollouts: list[Any], trials: bool) -> np.ndarray:
    """Returns what each of two agents should read in each step, `[T, B, N, 4]`: two for the action, reward, trial."""
    action, reward, fresh = (
        np.concatenate([np.asarray(getattr(rollout, name)) for rollout in rollouts])
        for name in ("action", "reward", "fresh")
    )
    inputs = np.zeros((*action.shape, 4))
    for env in range(action.shape[1]):
        of_episode = 0
        for step in range(len(action)):
            of_episode = 0 if fresh[step, env] else of_episode + 1
            starts = of_episode == 0 or (trials and of_episode % 2 == 0)
            inputs[step, env, :, 3] = starts
            for agent in range(2):
                if of_episode > 0:
                    inputs[step, env, agent, action[step - 1, env, agent]] = 1
                    inputs[step, env, agent, 2] = reward[step - 1, env, agent]
    return inputs


@pytest.mark.parametrize(
    ("changes", "trials"),
    [
        pytest.param({}, False, marks=pytest.mark.thorough),
        ({"reward": "common"}, True),
        pytest.param({"sharing": "per_agent"}, True, marks=pytest.mark.slow),
        pytest.param({"partners": {0: "random"}}, True, marks=pytest.mark.slow),
        pytest.param(CENTRAL, True, marks=pytest.mark.slow),
    ],
    ids=["no trials", "common", "per agent", "partner", "mappo"],
)
def test_what_is_read_is_the_last_action_and_the_games_reward(
    changes: dict[str, Any], trials: bool
) -> None:
    """In the minibatches of learning; that acting reads the same is tested below, and in `test_ppo_update.py`."""
    env = tried() if trials else uneven()
    config = quick(**READING, **changes, num_envs=ENVS, num_steps=STEPS)
    first, second, _ = two_rollouts(env, config)
    inputs = []
    for played in (first, second):
        batch = make_batch(played.rollout, played.memory, jnp.zeros((ENVS, 2)), config)
        assert batch.memory["last"].keys() == set(ALL)
        teams = []
        for team in range(batch.memory["last"]["action"].shape[1]):
            of_team = {name: leaf[:, team] for name, leaf in batch.memory["last"].items()}
            teams.append(last_step_features(of_team, batch.fresh, env.num_actions, jnp.float32))
        inputs.append(np.concatenate(teams, axis=2))
    expected = inputs_by_hand([first.rollout, second.rollout], trials)
    if "partners" in changes:
        expected = expected[:, :, 1:]
    np.testing.assert_array_equal(np.concatenate(inputs), expected)
    assert len(np.unique(first.rollout.action)) == 2
    assert 0 < np.asarray(second.rollout.fresh).mean() < 1


@pytest.mark.parametrize("changes", [{}, pytest.param(CENTRAL, marks=pytest.mark.slow)])
def test_the_value_of_a_last_observation_reads_the_last_step(changes: dict[str, Any]) -> None:
    """Where a time limit cuts an episode off: beside values that a network gives the episode with its last observation in one go."""
    env = tried()
    config = quick(**READING, **changes, reward="common", num_envs=ENVS, num_steps=STEPS)
    networks = make_actor_critics(env, config)
    played, _, parameters = two_rollouts(env, config)
    rollout = played.rollout
    ends = np.asarray(rollout.truncated).argmax(axis=0)  # of each environment's first episode
    inputs = inputs_by_hand([rollout], trials=True)
    for end, index in zip(*np.unique(ends, return_index=True), strict=True):
        last_action = np.asarray(rollout.action)[end, index]
        last_reward = np.asarray(rollout.reward)[end, index]
        starts = (end + 1) % 2 == 0
        one_hot = inputs[1 : end + 1, index, :, :2]
        last = {
            "action": np.concatenate([[[-1, -1]], one_hot.argmax(-1), [last_action]]),
            "reward": np.concatenate([inputs[: end + 1, index, :, 2], [last_reward]]),
            "trial": np.concatenate([inputs[: end + 1, index, :, 3], [[starts] * 2]]) == 1,
        }
        in_memory = {name: jnp.asarray(leaf)[None, None] for name, leaf in last.items()}
        memory = networks.start_memory(1) | {"last": in_memory}
        seen = jnp.zeros((end + 2, 1, 2, 1, 1, 1), jnp.uint8)
        never = jnp.zeros((end + 2, 1), bool)
        _, _, values = read(networks, parameters, memory, seen, never)
        np.testing.assert_allclose(
            values[:-1, 0], rollout.acting.value[: end + 1, index], rtol=1e-4, atol=1e-4
        )
        np.testing.assert_allclose(values[-1, 0], rollout.ending[end, index], rtol=1e-4, atol=1e-4)


def test_a_central_critic_reads_the_last_steps_of_all_agents() -> None:
    env = tried()
    config = quick(**READING, **CENTRAL)
    networks = make_actor_critics(env, config)
    parameters = drawn(env, config)
    seen = jnp.zeros((1, 1, 2, 1, 1, 1), jnp.uint8)

    def values(reward: list[float]) -> np.ndarray:
        memory = networks.start_memory(1)
        memory["last"]["reward"] = jnp.asarray(reward, jnp.float32).reshape(1, 1, 1, 2)
        _, _, values = read(networks, parameters, memory, seen, jnp.zeros((1, 1), bool))
        return np.asarray(values[0, 0])

    assert (values([0, 0]) != values([0, 1])).all()


@pytest.mark.parametrize("sharing", ["shared", pytest.param("per_agent", marks=pytest.mark.slow)])
def test_a_policy_reads_what_it_read_in_training(sharing: str) -> None:
    """A greedy policy played step by step takes the actions that its network gives the whole episode in one go."""
    env = tried()
    config = quick(**READING, sharing=sharing, reward="common")
    networks = make_actor_critics(env, config)
    parameters = drawn(env, config)
    policy = trained_policy(env, config, parameters, greedy=True)
    assert isinstance(policy, MemoryPolicy)
    state = env.reset(jax.random.key(2))[1].replace(cue=jnp.int32(1))
    memory = policy.start
    act = jax.jit(policy.act, compiler_options=FAST_TO_COMPILE)
    actions, rewards = [], []
    for step in range(5):
        memory, action = act(memory, jax.random.key(step), env.observe(state))
        _, state, reward, _, info = env.step_env(jax.random.key(0), state, action)
        memory = policy.after_step(memory, action, reward, info)
        actions.append(np.asarray(action))
        rewards.append(np.asarray(reward))
    teams = 1 if sharing == "shared" else 2
    last = {
        "action": np.array([[-1, -1], *actions[:-1]]),
        "reward": np.array([[0, 0], *rewards[:-1]], np.float32),
        "trial": np.array([[True] * 2, [False] * 2, [True] * 2, [False] * 2, [True] * 2]),
    }
    of_teams = {  # [1, G, T, S]
        name: jnp.asarray(np.moveaxis(leaf.reshape(5, teams, -1), 1, 0))[None]
        for name, leaf in last.items()
    }
    seen = jnp.zeros((5, 1, 2, 1, 1, 1), jnp.uint8)
    whole = networks.start_memory(1) | {"last": of_teams}
    at_end, logits, _ = read(networks, parameters, whole, seen, jnp.zeros((5, 1), bool))
    np.testing.assert_allclose(memory["memory"], at_end["memory"], rtol=1e-4, atol=1e-5)
    np.testing.assert_array_equal(np.array(actions), logits[:, 0].argmax(-1))
    assert len(np.unique(actions)) == 2
    assert evaluate(env, policy, jax.random.key(1), 8).returns[:, 0].min() >= 2


@pytest.mark.thorough
def test_an_arm_that_paid_is_pulled_again() -> None:
    """The first pull is a guess, so the best return is 4.5; of agents that can't read what paid it is 2.5."""
    reads = {"memory": "gru", "memory_reads": ("action", "reward")}
    _, metrics = learn(bandit(), **reads)
    assert metrics["agent_return"][-10:].mean() > 4.2
    _, blind = learn(bandit(), memory="gru")
    assert blind["agent_return"][-10:].mean() == pytest.approx(2.5, abs=0.15)


@pytest.mark.thorough
def test_a_stopped_run_and_a_stored_policy_go_on_as_they_were(tmp_path: Path) -> None:
    config = quick(
        **READING,
        num_envs=ENVS,
        num_steps=STEPS,
        total_timesteps=ENVS * STEPS * 6,
        checkpoint_updates=2,
        evaluate_every=3,
        evaluation_episodes=8,
    )
    append = Recorder.append

    def append_and_copy(self: Recorder, row: dict[str, Any]) -> None:
        append(self, row)
        if row["update"] == 5:
            copy_run(tmp_path / "whole", tmp_path / "stopped")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Recorder, "append", append_and_copy)
        result = train(tried(), config, tmp_path / "whole", "none")
    resume(tried(), tmp_path / "stopped", "none")
    assert_same_end(tmp_path / "stopped", tmp_path / "whole")

    stored = load_policy(tmp_path / "whole", tried())
    kept = trained_policy(tried(), config, result.parameters)
    returns = [evaluate(tried(), policy, jax.random.key(1), 8).returns for policy in (stored, kept)]
    np.testing.assert_array_equal(*returns)


def test_policies_stored_without_the_setting_still_load(tmp_path: Path) -> None:
    config = quick(memory="gru")
    settings = config.record()
    assert settings.pop("memory_reads") == []
    described = {
        "game": describe_game(tried()),
        "config": settings,
        "update": 1,
        "env_steps": 8,
        "seed": 0,
    }
    path = tmp_path / "old.safetensors"
    write_policy(path, drawn(tried(), config), described)
    assert "memory_reads" not in json.loads(path.with_suffix(".json").read_text())["config"]
    policy = load_policy(path, tried())
    assert evaluate(tried(), policy, jax.random.key(1), 2).returns.shape == (2, 2)


def test_the_order_of_what_is_read_does_not_matter() -> None:
    settings = {"memory": "gru", "memory_reads": "trial, action"}
    assert make_config(settings).memory_reads == ("action", "trial")
