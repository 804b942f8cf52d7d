"""Plays whole episodes with a policy, many in parallel, each the same as in `sjdsl play --watch` with its seed."""

from collections.abc import Callable, Iterator
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from sjdsl.replay.episode import Episode, Observation
from sjdsl.runtime.env import Environment
from sjdsl.runtime.episode_keys import EpisodeKeys
from sjdsl.runtime.policy import Policy, take_actions, with_memory
from sjdsl.runtime.tokens import to_channels

MAX_BYTES = 256 * 2**20  # of observations held at once, unless one episode has more
MAX_TOGETHER = 32


def play_episodes(
    env: Environment, policy: Policy, seed: int, episodes: int, observation: Observation = "tokens"
) -> Iterator[Episode]:
    """Yields the episodes of the seeds `seed`, `seed + 1`, … played with a policy.

    As many are played at once as have at most 256 MB of observations (one episode, if it alone has more).

    Args:
      env: an environment with token observations, which the policy sees.
      policy: `(key, observation) -> actions [N]`, or one with memory.
      observation: how observations are stored.
    """
    play = jax.jit(jax.vmap(_make_play(env, policy, observation)))
    together = min(episodes, episodes_at_once(env, observation))
    for first in range(0, episodes, together):
        seeds = [
            seed + first + number for number in range(together)
        ]  # the last batch may have too many, so that all have one program
        keys = jnp.stack([jax.random.key(number) for number in seeds])
        played = jax.device_get(play(keys))
        for number in range(min(together, episodes - first)):
            yield _cut(
                seeds[number], jax.tree.map(lambda leaf, number=number: leaf[number], played)
            )


def episodes_at_once(env: Environment, observation: Observation = "tokens") -> int:
    """Returns the most episodes that `play_episodes` plays side by side."""
    agents, planes, rows, cols = env.observation_shape
    depth = {"none": 0, "tokens": planes, "onehot": len(env.channel_names)}[observation]
    size = (env.episode_length + 1) * agents * depth * rows * cols
    return max(1, min(MAX_TOGETHER, MAX_BYTES // max(size, 1)))


def _make_play(
    env: Environment, policy: Policy, observation: Observation
) -> Callable[[Array], dict[str, Any]]:
    """Returns a function from an episode's key to its steps; those after its end are meaningless."""
    remembering = with_memory(policy)

    def shown(tokens: Array) -> Any:
        if observation == "none":
            return ()
        return (
            tokens
            if observation == "tokens"
            else to_channels(tokens, env.token_planes, jnp.dtype(jnp.uint8))
        )

    def play(key: Array) -> dict[str, Any]:
        keys = EpisodeKeys(key, jax.random.fold_in)

        def step(carry: Any, number: Array) -> tuple[Any, dict[str, Any]]:
            state, seen, memory = carry
            memory, actions = take_actions(
                env, remembering, memory, keys.of_choices(number), seen, state
            )
            seen, state, reward, _, info = env.step_env(keys.of_step(number), state, actions)
            kept = {
                "terminated": info["terminated"],
                "truncated": info["truncated"],
                "events": info["events"],
            }
            return (state, seen, memory), {
                **kept,
                "after": shown(seen),
                "actions": actions.astype(jnp.int32),
                "rewards": reward,
            }

        seen, state = env.reset(keys.start())
        start = (state, seen, remembering.start)
        _, steps = jax.lax.scan(step, start, jnp.arange(env.episode_length, dtype=jnp.uint32))
        return {**steps, "first": shown(seen)}

    return play


def _cut(seed: int, played: dict[str, Any]) -> Episode:
    """Returns an episode without the steps after its end."""
    over = played["terminated"] | played["truncated"]
    steps = int(over.argmax()) + 1
    seen = None
    if not isinstance(played["first"], tuple):
        seen = np.concatenate([played["first"][None], played["after"][:steps]])
    return Episode(
        seed=seed,
        observations=seen,
        actions=played["actions"][:steps],
        rewards=played["rewards"][:steps],
        events={name: count[:steps] for name, count in played["events"].items()},
        terminated=bool(played["terminated"][steps - 1]),
        truncated=bool(played["truncated"][steps - 1]),
    )
