"""Trained, scripted and other policies of JAX, and language models, play on the interpreter.

They are those of `sjdsl play --slots`, asked with the same keys. The interpreter's observation has
the same numbers as the compiled game's, so nothing of a step is compiled but the policies.
"""

from collections.abc import Mapping
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.interpreter.observe import observe
from sjdsl.interpreter.state import Outcome
from sjdsl.library.factory import environment_of
from sjdsl.models import Limits, ModelError, Talks
from sjdsl.models.reasons import Reasons
from sjdsl.runtime.episode_keys import EpisodeKeys
from sjdsl.runtime.policy import compiled_actions, with_memory
from sjdsl.studio.episode import Episode
from sjdsl.studio.opened import Opened
from sjdsl.studio.seats import CannotPlay, Seats
from sjdsl.testing.differences import named_counts
from sjdsl.testing.states import compiled_state
from sjdsl.trace.episode import Moment
from sjdsl.trainers.policies.policy_file import PolicyError
from sjdsl.trainers.policies.seating import seated_policy
from sjdsl.trainers.settings.config_errors import ConfigError
from sjdsl.trainers.settings.extensions import allow_code
from sjdsl.trainers.settings.policy_names import seat_of_person


class Players:
    """The policies of all seats, and what they remember of an episode."""

    def __init__(self, seats: Seats) -> None:
        allow_code(*seats.code)
        self._names = seats.names
        self._opened: Opened | None = None  # the game that the policies are loaded for
        self._moments: list[Moment] = []  # of the episode that they remember
        self._memories: list[Any] = []  # at each of its moments
        self._reasons = Reasons(Talks(limits=Limits(**seats.limits)).part("studio"))  # in it

    def step(self, episode: Episode, opened: Opened, driven: Mapping[int, int]) -> None:
        """Takes a step of an episode from the moment that is shown.

        driven: the actions of the agents that a person controls.

        Raises:
          CannotPlay: the seats don't fit the game, it isn't the person who is driven, a policy
            can't be loaded, or a model can't be asked.
          TooLong, LeavesFloat32: as `Episode.step`.
        """
        self._check_driven(opened.game, driven)
        try:
            if opened is not self._opened:
                self._load(opened)
            if episode.moments is not self._moments:
                self._moments = episode.moments
                self._memories = [self._policy.start]
                self._reasons.clear()
            is_last = episode.at == len(episode.moments) - 1
            if not self._policy.traced and not is_last:
                raise CannotPlay(
                    "who is asked in words can't forget what came after this moment: go to the "
                    "last one, or begin again"
                )
            world = episode.now.world
            key = EpisodeKeys(jax.random.key(episode.seed), jax.random.fold_in).of_choices(
                episode.steps_taken
            )
            state = compiled_state(self._env, self._blank, world)
            memory, chosen = self._act(
                self._memories[episode.at], key, jnp.asarray(observe(opened.game, world)), state
            )
            actions = [driven.get(agent, int(action)) for agent, action in enumerate(chosen)]
            episode.step(actions, opened.values)
            outcome = episode.now.outcome
            assert outcome is not None
            reward = jnp.asarray(outcome.reward, jnp.float32)
            played = jnp.asarray(actions, jnp.int32)
            self._memories[episode.at :] = [memory]  # also if a model can't be asked for its notes
            self._memories[-1] = self._after_step(memory, played, reward, self._info(outcome))
        except (ConfigError, ModelError, PolicyError) as error:
            raise CannotPlay(str(error)) from None
        except CompileError as error:
            raise CannotPlay(error.diagnostics[0].message) from None

    def reasons(self, episode: Episode) -> list[list[str]] | None:
        """Returns why agents did what they did in an episode, `[T][N]`; None if nobody was asked."""
        if episode.moments is not self._moments:
            return None
        return self._reasons.table(len(episode.moments) - 1, episode.game.agents.number)

    def _check_driven(self, game: ir.Game, driven: Mapping[int, int]) -> None:
        """Raises CannotPlay unless the person's agent is driven, and no other."""
        try:
            person = seat_of_person(self._names, game.agents.number, game.name)
        except ValueError as error:
            raise CannotPlay(str(error)) from None
        for agent in driven:
            if agent != person:
                raise CannotPlay(f"agent {agent} is played by {self._names[agent]}, not by you")
        if person is not None and person not in driven:
            raise CannotPlay(
                f"you play agent {person}: click on the board, and press the key of an action"
            )

    def _load(self, opened: Opened) -> None:
        """Loads the policies for a game.

        Raises CompileError, PolicyError, ModelError or ConfigError.
        """
        self._opened = None
        self._env = environment_of(opened.build, opened.values)
        self._blank = jax.device_get(self._env.module.initial_state())
        self._policy = with_memory(seated_policy(self._names, self._env, ask=self._reasons.ask))
        self._act, self._after_step = compiled_actions(self._env, self._policy)
        self._opened = opened

    def _info(self, outcome: Outcome) -> dict[str, Any]:
        """Returns what policies may read of a step's info, as `Environment.step` describes it."""
        game = self._env.game
        counts: dict[str, np.ndarray] = {}
        for event in game.events:
            counts |= named_counts(event, outcome)
        info = {
            "events": counts,
            "metrics": {name: np.float32(value) for name, value in outcome.measures.items()},
            "terminated": np.bool_(outcome.terminated),
            "truncated": np.bool_(outcome.truncated),
        }
        if game.trials is not None:
            info["trial_ended"] = np.bool_(outcome.trial_ended)
        return info
