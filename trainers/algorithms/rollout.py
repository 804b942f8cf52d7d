"""Rollouts: T steps of B environments with the current policies, `[T, B, N, …]`."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import flax
import jax
import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.policy import unchanged

from ..devices.data_parallel import mean_of_all, own_keys, sum_of_all
from ..environment import Environment
from .episodes import (
    EpisodeSums,
    FinishedEpisodes,
    add_step,
    mean_episode,
    split_finished,
    zero_sums,
)
from .partners import NOBODY, Partners
from .shaping import Shaping
from .step_record import Step


@flax.struct.dataclass
class Worlds:
    """The B environments between two rollouts."""

    state: Any  # [B, ...] the environments' states
    observation: Array  # [B, N, P, V, V] uint8
    fresh: Array  # [B] bool, an episode begins with the next step
    trace: Array  # [B, N] float32, smoothed raw rewards of the episode under way
    recent: Array  # [B, N, K] float32, averages of recent shaped rewards, one for each horizon
    memory: Any  # of the agents; depends on the algorithm
    sums: EpisodeSums  # [B, ...] of the episodes under way
    partners: Any = ()  # [B, ...] memory of the agents that are held fixed


@flax.struct.dataclass
class Rollout:
    """T steps to learn from."""

    observation: Array  # [T, B, N, bytes] uint8, acted on, packed
    for_critic: Any  # [T, B, ...] what critics read besides windows; None if nothing
    fresh: Array  # [T, B] bool, the episode began with this step
    action: Array  # [T, B, N] int32
    reward: Array  # [T, B, N] float32, raw
    shaped_reward: Array  # [T, B, N] float32, learnt from
    done: Array  # [T, B] bool, the episode ended with this step
    truncated: Array  # [T, B] bool, by the time limit
    acting: Any  # [T, B, ...] what `Actor.act` keeps of a step
    ending: Any  # [T, B, ...] what `Actor.follow` keeps of where the step led


@dataclass(frozen=True)
class Actor:
    """How agents act in B environments, and what they keep for learning.

    act: `(worlds, key) -> memory, action [B, N], kept`.
    pack: packs an observation for the rollout.
    follow: `(memory, info, recent) -> kept` after the step; `info` as the step gave it, `recent` as
      `Worlds.recent`, of the episode that the step was in.
    after_step: `(memory, action [B, N], reward [B, N], info) -> memory` after the step, before
      `follow`.
    for_critic: `(state, recent) -> what critics read besides windows`, which the rollout keeps.
    horizons: of the averages of recent rewards, in steps.
    """

    act: Callable[[Worlds, Array], tuple[Any, Array, Any]]
    pack: Callable[[Array], Array]
    follow: Callable[[Any, dict[str, Any], Array], Any]
    after_step: Callable[[Any, Array, Array, Mapping[str, Any]], Any] = unchanged
    for_critic: Callable[[Any, Array], Any] = lambda *_: None
    horizons: Sequence[float] = ()


def start_worlds(
    env: Environment,
    num_envs: int,
    memory: Any,
    key: Array,
    partners: Partners = NOBODY,
    horizons: Sequence[float] = (),
) -> Worlds:
    """Returns `num_envs` fresh environments.

    memory: the agents' before their first step. horizons: as those of the actor.
    """
    observation, state = jax.vmap(env.reset)(jax.random.split(key, num_envs))
    return Worlds(
        state=state,
        observation=observation,
        fresh=jnp.ones(num_envs, bool),
        trace=jnp.zeros((num_envs, env.num_agents), jnp.float32),
        recent=jnp.zeros((num_envs, env.num_agents, len(horizons)), jnp.float32),
        memory=memory,
        sums=zero_sums(env, num_envs),
        partners=partners.policy.starts(num_envs),
    )


def if_any_truncated(info: Mapping[str, Any], terminal_values: Callable[[], Array]) -> Array:
    """Returns the values of terminal observations, or zeros if no episode was cut.

    Most steps cut none, and then the second forward pass of the networks is skipped.
    """
    form = jax.eval_shape(terminal_values)
    values: Array = jax.lax.cond(
        info["truncated"].any(), terminal_values, lambda: jnp.zeros(form.shape, form.dtype)
    )
    return values


def rollout_metrics(
    rollout: Rollout, finished: FinishedEpisodes, measured: dict[str, Array]
) -> dict[str, Any]:
    """Returns the metrics of what was played, as `collect_rollout` returns it."""
    return {
        **mean_episode(finished),
        "reward_per_step": rollout.reward.sum(axis=-1).mean(),
        # the share of steps in which some agent's reward isn't 0
        "rewarded_steps": (rollout.reward != 0).any(axis=-1).mean(),
        "metric": measured,
    }


def collect_rollout(
    env: Environment,
    actor: Actor,
    worlds: Worlds,
    key: Array,
    num_steps: int,
    shaping: Shaping,
    partners: Partners = NOBODY,
) -> tuple[Worlds, Rollout, FinishedEpisodes, dict[str, Array]]:
    """Plays `num_steps` steps in every environment.

    Args:
      env: one environment; its `step` starts a new episode when one ends.
      actor: how agents act.
      worlds: where the last rollout left off.
      key: consumed.
      num_steps: T.
      shaping: how raw rewards become shaped ones.
      partners: agents that act by a given policy, instead of the actor's actions.
    Returns:
      the worlds afterwards, the rollout, the total over the episodes that finished in it, and the
      game's metrics averaged over all its steps.
    """
    weights = 1.0 / jnp.asarray(actor.horizons, jnp.float32)

    def advance(
        worlds: Worlds, key: Array
    ) -> tuple[Worlds, tuple[Rollout, FinishedEpisodes, dict[str, Array]]]:
        """Plays one step of all environments, and begins new episodes where one ended."""
        action_key, env_key, *others = jax.random.split(key, 3 if partners.agents else 2)
        memory, action, acting = actor.act(worlds, action_key)
        partners_memory = worlds.partners
        if partners.agents:
            (partners_key,) = others
            partners_memory, action = partners.act(
                env,
                partners_memory,
                partners_key,
                worlds.observation,
                worlds.state,
                worlds.fresh,
                action,
            )
        env_keys = own_keys(env_key, action.shape[0])
        observation, state, reward, done, info = jax.vmap(env.step)(env_keys, worlds.state, action)
        memory = actor.after_step(memory, action, reward, info)
        if partners.agents:
            after_step = jax.vmap(partners.policy.after_step)
            partners_memory = after_step(partners_memory, action, reward, info)
        trace = shaping.smoothing * worlds.trace + reward
        step = Step(
            reward=reward,
            trace=trace,
            action=action,
            observation=worlds.observation,
            state=worlds.state,
            next_state=info.get("terminal_state"),
            events=info["events"],
            metrics=info["metrics"],
            done=done,
            truncated=info["truncated"],
        )
        shaped_reward = shaping.shape(step)
        recent = worlds.recent + weights * (shaped_reward[..., None] - worlds.recent)
        sums, finished = split_finished(add_step(worlds.sums, reward, shaped_reward, info), done)
        played = Rollout(
            observation=actor.pack(worlds.observation),
            for_critic=actor.for_critic(worlds.state, worlds.recent),
            fresh=worlds.fresh,
            action=action,
            reward=reward,
            shaped_reward=shaped_reward,
            done=done,
            truncated=info["truncated"],
            acting=acting,
            ending=actor.follow(memory, info, recent),
        )
        after = Worlds(
            state=state,
            observation=observation,
            fresh=done,
            trace=jnp.where(done[:, None], 0.0, trace),
            recent=jnp.where(done[:, None, None], 0.0, recent),
            memory=memory,
            sums=sums,
            partners=partners_memory,
        )
        return after, (played, finished, info["metrics"])

    keys = jax.random.split(key, num_steps)
    worlds, (rollout, finished, metrics) = jax.lax.scan(advance, worlds, keys)
    total = jax.tree.map(lambda leaf: leaf.sum(axis=0, dtype=leaf.dtype), finished)
    return worlds, rollout, sum_of_all(total), mean_of_all(jax.tree.map(jnp.mean, metrics))
