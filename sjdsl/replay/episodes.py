"""Plays whole episodes with a policy, many in parallel.

Each is the episode that `sjdsl play --watch` shows for its seed.
"""

from collections.abc import Callable, Iterator
from functools import partial
from multiprocessing.pool import ThreadPool
from operator import itemgetter
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from sjdsl.replay.episode import Episode, Observation
from sjdsl.runtime.env import Environment
from sjdsl.runtime.episode_keys import EpisodeKeys
from sjdsl.runtime.policy import MemoryPolicy, Policy, take_actions, with_memory
from sjdsl.runtime.tokens import to_channels

MAX_BYTES = 256 * 2**20  # of observations in memory, unless one episode has more
MAX_EPISODES = 32  # that are played at once


def play_episodes(
    env: Environment, policy: Policy, seed: int, episodes: int, observation: Observation = "tokens"
) -> Iterator[Episode]:
    """Yields the episodes of the seeds `seed`, `seed + 1`, … played with a policy.

    As many are played at once as have at most 256 MB of observations, but at least one.

    Args:
      env: an environment with token observations, which the policy sees.
      policy: `(key, observation) -> actions [N]`, or one with memory.
      observation: how observations are stored.
    """
    play = jax.jit(jax.vmap(_make_play(env, policy, observation)))
    at_once = min(episodes, episodes_at_once(env, observation))
    for first in range(seed, seed + episodes, at_once):
        # The last batch may have too many, so that all batches have one program.
        seeds = range(first, first + at_once)
        steps = jax.device_get(play(jnp.stack([jax.random.key(s) for s in seeds])))
        for index, episode_seed in enumerate(seeds):
            if episode_seed < seed + episodes:
                yield _without_rest(episode_seed, jax.tree.map(itemgetter(index), steps))


def play_asked_episodes(
    env: Environment,
    policy_of: Callable[[int], MemoryPolicy],
    seed: int,
    episodes: int,
    observation: Observation = "tokens",
) -> Iterator[Episode]:
    """Yields the episodes of `play_episodes` under policies that can't be traced, side by side.

    Args:
      policy_of: returns the policy for the episode of a seed.
    """
    encode = jax.jit(partial(_encoded, env, observation))
    step = jax.jit(env.step_env)
    reset = jax.jit(env.reset)

    def play(seed: int) -> Episode:
        policy = policy_of(seed)
        keys = EpisodeKeys(jax.random.key(seed), jax.random.fold_in)
        memory = policy.start
        tokens, state = reset(keys.start())
        observations = [encode(tokens)]
        steps = []
        for number in range(env.episode_length):
            key = keys.of_choices(number)
            memory, actions = take_actions(env, policy, memory, key, tokens, state)
            tokens, state, reward, done, info = step(keys.of_step(number), state, actions)
            memory = policy.after_step(memory, actions, reward, info)
            observations.append(encode(tokens))
            steps.append(_outcome(actions, reward, info))
            if done:
                break
        of_steps = jax.tree.map(lambda *leaves: np.stack(leaves), *steps)
        first = observations[0]
        after = () if observation == "none" else np.stack(observations[1:])
        return _without_rest(seed, {**of_steps, "first": first, "after": after})

    with ThreadPool(min(episodes, MAX_EPISODES)) as pool:
        yield from pool.imap(play, range(seed, seed + episodes))


def episodes_at_once(env: Environment, observation: Observation = "tokens") -> int:
    """Returns the most episodes that `play_episodes` plays at once."""
    agents, planes, rows, cols = env.observation_shape
    depth = {"none": 0, "tokens": planes, "onehot": len(env.channel_names)}[observation]
    size = (env.episode_length + 1) * agents * depth * rows * cols
    return max(1, min(MAX_EPISODES, MAX_BYTES // max(size, 1)))


def _make_play(
    env: Environment, policy: Policy, observation: Observation
) -> Callable[[Array], dict[str, Any]]:
    """Returns a function from an episode's key to its steps; those after its end mean nothing."""
    policy_with_memory = with_memory(policy)

    encoded = partial(_encoded, env, observation)

    def play(key: Array) -> dict[str, Any]:
        """Plays an episode to its longest end; returns arrays `[T, ...]` of all its steps, by
        name.
        """
        keys = EpisodeKeys(key, jax.random.fold_in)

        def step(carry: Any, number: Array) -> tuple[Any, dict[str, Any]]:
            """Plays one step; what was played after the end of the episode is cut off later."""
            state, tokens, memory = carry
            memory, actions = take_actions(
                env, policy_with_memory, memory, keys.of_choices(number), tokens, state
            )
            tokens, state, reward, _, info = env.step_env(keys.of_step(number), state, actions)
            memory = policy_with_memory.after_step(memory, actions, reward, info)
            outcome = _outcome(actions, reward, info)
            return (state, tokens, memory), {**outcome, "after": encoded(tokens)}

        tokens, state = env.reset(keys.start())
        start = (state, tokens, policy_with_memory.start)
        _, steps = jax.lax.scan(step, start, jnp.arange(env.episode_length, dtype=jnp.uint32))
        return {**steps, "first": encoded(tokens)}

    return play


def _encoded(env: Environment, observation: Observation, tokens: Array) -> Any:
    """Returns tokens in the form in which observations are recorded."""
    match observation:
        case "none":
            return ()
        case "tokens":
            return tokens
        case "onehot":
            return to_channels(tokens, env.token_planes, jnp.dtype(jnp.uint8))


def _outcome(actions: Array, reward: Array, info: dict[str, Any]) -> dict[str, Any]:
    """Returns what is recorded of a step, but for the observation after it."""
    return {
        "terminated": info["terminated"],
        "truncated": info["truncated"],
        "events": info["events"],
        "actions": actions.astype(jnp.int32),
        "rewards": reward,
    }


def _without_rest(seed: int, steps: dict[str, Any]) -> Episode:
    """Returns an episode without the steps after its end."""
    is_over = steps["terminated"] | steps["truncated"]
    length = int(is_over.argmax()) + 1
    observations = None
    if not isinstance(steps["first"], tuple):
        observations = np.concatenate([steps["first"][None], steps["after"][:length]])
    return Episode(
        seed=seed,
        observations=observations,
        actions=steps["actions"][:length],
        rewards=steps["rewards"][:length],
        events={name: count[:length] for name, count in steps["events"].items()},
        terminated=bool(steps["terminated"][length - 1]),
        truncated=bool(steps["truncated"][length - 1]),
    )
