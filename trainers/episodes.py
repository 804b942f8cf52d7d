"""Sums over episodes: kept while an episode runs, handed over when it ends."""

from typing import Any

import flax
import jax
import jax.numpy as jnp
from jax import Array

from .environment import Environment, info_shapes


@flax.struct.dataclass
class EpisodeSums:
    """What an episode has added up to. Leading axes: `[B]` while episodes run, none for a total over finished ones."""

    episodes: Array  # int32, 1 per running episode; the number of episodes in a total
    length: Array  # int32, steps
    returns: Array  # [..., N] float32, raw rewards
    shaped_returns: Array  # [..., N] float32, rewards learnt from
    events: dict[str, Array]  # [..., N] or [...] int32, the game's event counts


def zero_sums(env: Environment, num_envs: int) -> EpisodeSums:
    """Returns the sums of `num_envs` episodes before their first step."""
    return EpisodeSums(
        episodes=jnp.zeros(num_envs, jnp.int32),
        length=jnp.zeros(num_envs, jnp.int32),
        returns=jnp.zeros((num_envs, env.num_agents)),
        shaped_returns=jnp.zeros((num_envs, env.num_agents)),
        events={name: jnp.zeros((num_envs, *count.shape), jnp.int32) for name, count in info_shapes(env)["events"].items()},
    )


def add_step(sums: EpisodeSums, reward: Array, shaped_reward: Array, events: dict[str, Array]) -> EpisodeSums:
    """Returns the sums after one more step of each of the B episodes."""
    return EpisodeSums(
        episodes=jnp.ones_like(sums.episodes),
        length=sums.length + 1,
        returns=sums.returns + reward,
        shaped_returns=sums.shaped_returns + shaped_reward,
        events={name: count + events[name] for name, count in sums.events.items()},
    )


def hand_over(sums: EpisodeSums, done: Array) -> tuple[EpisodeSums, EpisodeSums]:
    """Splits `[B]` sums by `done` `[B]`: those that run on (zero where ended), and the total of those that ended."""

    def where_done(leaf: Array) -> Array:
        return done.reshape(done.shape + (1,) * (leaf.ndim - 1))

    running = jax.tree.map(lambda leaf: jnp.where(where_done(leaf), 0, leaf), sums)
    finished = jax.tree.map(lambda leaf: jnp.where(where_done(leaf), leaf, 0).sum(axis=0), sums)
    return running, finished


def mean_episode(total: EpisodeSums) -> dict[str, Any]:
    """Returns the mean finished episode; all NaN but the count when none has finished."""
    mean = jax.tree.map(lambda leaf: leaf / total.episodes, total)
    return {
        "episodes": total.episodes,
        "episode_length": mean.length,
        "collective_return": mean.returns.sum(),
        "agent_return": mean.returns,
        "shaped_agent_return": mean.shaped_returns,
        "event": mean.events,
    }
