"""Replays an episode one step at a time: the same seed and actions give the same episode."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import jax
import numpy as np

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


class EpisodePlayer:
    """One episode of an environment.

    Attributes:
      keys: of the episode; observation, state: the current ones; actions: of each step so far.
      returns: `[N]`; done: whether the episode is over; info: of the last step.
    """

    def __init__(self, env: Environment, seed: int) -> None:
        """Starts the episode of a seed."""
        self.env = env
        self.seed = seed
        self.keys = EpisodeKeys(jax.random.key(seed), jax.random.fold_in)
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


def replayed(recording: Recording, env: Environment) -> Iterator[Moment]:
    """Yields the moments of a recorded episode, the first one included.

    Raises:
      RecordingError: the environment has other rules or plays other tasks, its episode is shorter,
        an action is invalid, or the returns differ.
    """
    check_rules(recording, env.hash, env.name)
    check_tasks(recording, env.game, env.name)
    check_actions(recording, env.num_agents, env.num_actions)
    player = EpisodePlayer(env, recording.seed)
    yield player.now()
    for actions in recording.actions:
        if player.done:
            raise RecordingError(
                f"the episode ends after {len(player.actions)} steps, but "
                f"{len(recording.actions)} were recorded"
            )
        yield player.step(actions)
    check_returns(recording, player.returns.tolist())
