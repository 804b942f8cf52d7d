"""Plays episodes to be drawn."""

from collections.abc import Iterator
from typing import Any

import jax
import numpy as np

from sjdsl.render.moment import Moment, Snapshot, take_snapshot
from sjdsl.runtime.env import Environment
from sjdsl.runtime.episode_keys import EpisodeKeys
from sjdsl.runtime.policy import (
    Policy,
    compiled_actions,
    random_policy,
    stay_policy,
    with_memory,
)

__all__ = ["play", "play_moments", "random_policy", "stay_policy"]


def play(env: Environment, policy: Policy, num_steps: int, seed: int = 0) -> Iterator[Snapshot]:
    """Yields the states of episodes, the first of each included.

    Args:
      policy: `(key, observation) -> actions [N]`, or one with memory.
      num_steps: steps to play, over as many episodes as they take.
      seed: of the first episode; the next episodes have the seeds that follow.
    """
    return (moment.snapshot for moment in play_moments(env, policy, num_steps, seed))


def play_moments(
    env: Environment, policy: Policy, num_steps: int, seed: int = 0
) -> Iterator[Moment]:
    """Yields the states of `play`, of the same arguments, with the actions and rewards before."""
    policy_with_memory = with_memory(policy)
    act, after_step = compiled_actions(env, policy_with_memory)
    played = 0
    while True:
        keys = EpisodeKeys(jax.random.key(seed), jax.random.fold_in)
        memory = policy_with_memory.start
        observation, state = env.reset(keys.start())
        moment = first_moment(env, state)
        yield moment
        while played < num_steps and not moment.done:
            number = int(moment.snapshot.step)
            memory, actions = act(memory, keys.of_choices(number), observation, state)
            observation, state, reward, done, info = env.step_env(
                keys.of_step(number), state, actions
            )
            memory = after_step(memory, actions, reward, info)
            moment = next_moment(
                env, state, moment.snapshot.returns, actions, reward, bool(done), info["events"]
            )
            yield moment
            played += 1
        if played == num_steps:
            return
        seed += 1


def first_moment(env: Environment, state: Any) -> Moment:
    """Returns the start of an episode, without actions and rewards."""
    reward = np.zeros(env.num_agents)
    return Moment(take_snapshot(env, state, reward), (), reward, {}, False)


def next_moment(
    env: Environment,
    state: Any,
    returns: np.ndarray,
    actions: Any,
    reward: Any,
    done: bool,
    events: dict[str, Any],
) -> Moment:
    """Returns the moment after a step. `returns`: `[N]`, rewards before the step."""
    reward = np.asarray(reward)
    return Moment(
        take_snapshot(env, state, returns + reward),
        tuple(np.asarray(actions).tolist()),
        reward,
        {name: np.asarray(count) for name, count in events.items() if np.any(count)},
        done,
    )
