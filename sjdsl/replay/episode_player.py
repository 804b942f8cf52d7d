"""Replays an episode one step at a time: the same seed and actions give the same episode."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from sjdsl.render.moment import Moment
from sjdsl.render.playing import first_moment, next_moment
from sjdsl.replay.recording import (
    Recording,
    RecordingError,
    check_actions,
    check_returns,
    check_rules,
    check_tasks,
    with_tasks_played,
)
from sjdsl.runtime.env import Environment
from sjdsl.runtime.episode_keys import EpisodeKeys


@dataclass(frozen=True)
class RecordedKeys:
    """The keys of one episode as they were recorded: two words for the start and each step."""

    words: Sequence[tuple[int, int]]

    def start(self) -> Array:
        """Returns the key of the environment's `reset`."""
        return self._key(0)

    def of_step(self, number: int) -> Array:
        """Returns the key of a step, by its number from 0."""
        return self._key(number + 1)

    def _key(self, number: int) -> Array:
        key: Array = jax.random.wrap_key_data(jnp.array(self.words[number], jnp.uint32))
        return key


class EpisodePlayer:
    """One episode of an environment.

    Attributes:
      keys: of the episode; observation, state: the current ones; actions: of each step so far.
      returns: `[N]`; done: whether the episode is over; info: of the last step.
    """

    def __init__(self, env: Environment, seed: int, keys: "RecordedKeys | None" = None) -> None:
        """Starts the episode of a seed, or of other keys."""
        self.env = env
        self.seed = seed
        self.keys = keys or EpisodeKeys(jax.random.key(seed), jax.random.fold_in)
        self.observation, self.state = env.reset(self.keys.start())
        self.actions: list[list[int]] = []
        self.returns = np.zeros(env.num_agents)
        self.done = False
        self.info: dict[str, Any] = {}

    def now(self) -> Moment:
        """Returns the current moment, as after a step without rewards."""
        moment = first_moment(self.env, self.state)
        snapshot = replace(moment.snapshot, returns=self.returns)
        return replace(moment, snapshot=snapshot, done=self.done)

    def step(self, actions: Sequence[int]) -> Moment:
        """Takes one step.

        Raises:
          ValueError: the episode is over, or the actions aren't one valid number for each agent.
        """
        env = self.env
        numbers = [int(action) for action in actions]
        if self.done:
            raise ValueError("the episode is over")
        are_actions = all(0 <= number < env.num_actions for number in numbers)
        if len(numbers) != env.num_agents or not are_actions:
            raise ValueError(
                f"actions must be {env.num_agents} numbers from 0 to {env.num_actions - 1}, "
                f"not {numbers}"
            )
        self.observation, self.state, reward, done, info = env.step_env(
            self.keys.of_step(len(self.actions)), self.state, np.array(numbers, np.int32)
        )
        moment = next_moment(
            env, self.state, self.returns, numbers, reward, bool(done), info["events"]
        )
        self.actions.append(numbers)
        self.returns = moment.snapshot.returns
        self.done = moment.done
        self.info = info
        return moment

    def recording(self, environment: Mapping[str, Any]) -> Recording:
        """Returns the episode so far.

        environment: the arguments of `sjdsl.make`; the tasks played are added.
        """
        task = None if self.env.game is None else self.env.game.task
        return Recording(
            environment=with_tasks_played(environment, task),
            hash=self.env.hash,
            seed=self.seed,
            actions=self.actions,
            returns=self.returns.tolist(),
        )


def player_of(recording: Recording, env: Environment) -> EpisodePlayer:
    """Returns a recorded episode at its start.

    Raises:
      RecordingError: the environment has other rules or plays other tasks, or an action is invalid.
    """
    check_rules(recording, env.hash, env.name)
    check_tasks(recording, env.game, env.name)
    check_actions(recording, env.num_agents, env.num_actions)
    keys = None if recording.keys is None else RecordedKeys(recording.keys)
    return EpisodePlayer(env, recording.seed, keys)


def replayed(recording: Recording, env: Environment) -> Iterator[Moment]:
    """Yields the moments of a recorded episode, the first one included.

    Raises:
      RecordingError: the environment has other rules or plays other tasks, its episode is shorter,
        an action is invalid, or the returns differ.
    """
    player = player_of(recording, env)
    yield player.now()
    for number, actions in enumerate(recording.actions):
        if player.done:
            raise RecordingError(
                f"the episode ends after {len(player.actions)} steps, but "
                f"{len(recording.actions)} were recorded"
            )
        why = () if recording.why is None else tuple(recording.why[number])
        yield replace(player.step(actions), why=why)
    check_returns(recording, player.returns.tolist())
