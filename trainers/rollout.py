"""Rollouts: B environments played for T steps by the policy as it stands."""

from collections.abc import Callable
from typing import Any

import flax
import jax
import jax.numpy as jnp
from jax import Array

from .environment import Environment
from .episodes import EpisodeSums, FinishedEpisodes, add_step, hand_over, zero_sums
from .shaping import RewardMode, shape_reward

ActAndValue = Callable[[Array], tuple[Array, Array]]


@flax.struct.dataclass
class Worlds:
    """The B environments between two rollouts."""

    state: Any  # [B, ...] the environments' states
    observation: Array  # [B, N, P, V, V] uint8
    sums: EpisodeSums  # [B, ...] of the episodes under way


@flax.struct.dataclass
class Rollout:
    """What T steps leave behind to learn from."""

    observation: Array  # [T, B, N, P, V, V] uint8, acted on
    action: Array  # [T, B, N] int32
    log_probability: Array  # [T, B, N] float32, of the action when it was drawn
    value: Array  # [T, B, N] float32, of the observation
    reward: Array  # [T, B, N] float32, raw
    shaped_reward: Array  # [T, B, N] float32, learnt from
    done: Array  # [T, B] bool, the episode ended with this step
    truncated: Array  # [T, B] bool, by the time limit
    terminal_value: Array  # [T, B, N] float32, of the terminal observation; read only where truncated


def start_worlds(env: Environment, num_envs: int, key: Array) -> Worlds:
    """Returns `num_envs` fresh environments."""
    observation, state = jax.vmap(env.reset)(jax.random.split(key, num_envs))
    return Worlds(state, observation, zero_sums(env, num_envs))


def chosen_log_probability(logits: Array, action: Array) -> Array:
    """Returns the log probability `[...]` of each action under logits `[..., A]`."""
    return jnp.take_along_axis(jax.nn.log_softmax(logits), action[..., None], axis=-1)[..., 0]


def collect_rollout(
    env: Environment, network: ActAndValue, worlds: Worlds, key: Array, num_steps: int, reward_mode: RewardMode
) -> tuple[Worlds, Rollout, FinishedEpisodes, dict[str, Array]]:
    """Plays `num_steps` steps in every environment.

    Args:
      env: one environment; its `step` resets an ended episode by itself.
      network: observations `[B, N, P, V, V]` to logits `[B, N, A]` and values `[B, N]`.
      worlds: where the last rollout left off.
      key: consumed.
      num_steps: T.
      reward_mode: how raw rewards become shaped ones.
    Returns:
      the worlds afterwards, the rollout, the total over the episodes that finished in it, and the game's metrics
      averaged over all its steps.
    """

    def advance(worlds: Worlds, key: Array) -> tuple[Worlds, tuple[Rollout, FinishedEpisodes, dict[str, Array]]]:
        action_key, env_key = jax.random.split(key)
        logits, value = network(worlds.observation)
        action = jax.random.categorical(action_key, logits).astype(jnp.int32)  # independent over [B, N]
        env_keys = jax.random.split(env_key, action.shape[0])
        observation, state, reward, done, info = jax.vmap(env.step)(env_keys, worlds.state, action)
        shaped_reward = shape_reward(reward, reward_mode)
        truncated = info["truncated"]
        terminal_value = jax.lax.cond(  # most steps end no episode: then the second forward pass is skipped
            truncated.any(),
            lambda seen: network(seen)[1],
            lambda _: jnp.zeros_like(value),
            info["terminal_observation"],
        )
        running, finished = hand_over(add_step(worlds.sums, reward, shaped_reward, info), done)
        step = Rollout(
            observation=worlds.observation,
            action=action,
            log_probability=chosen_log_probability(logits, action),
            value=value,
            reward=reward,
            shaped_reward=shaped_reward,
            done=done,
            truncated=truncated,
            terminal_value=terminal_value,
        )
        return Worlds(state, observation, running), (step, finished, info["metrics"])

    worlds, (rollout, finished, metrics) = jax.lax.scan(advance, worlds, jax.random.split(key, num_steps))
    total = jax.tree.map(lambda leaf: leaf.sum(axis=0), finished)
    return worlds, rollout, total, jax.tree.map(jnp.mean, metrics)
