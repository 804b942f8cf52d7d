"""What each agent that is asked in words knows, in all episodes that are played side by side, and
the questions of a step."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from itertools import compress
from typing import Any

import numpy as np

from sjdsl.models.asking import PARALLEL, Ask, Asker, Question, ask_policy
from sjdsl.models.errors import ModelError
from sjdsl.models.ledger import Ledger
from sjdsl.models.notebook import REVISE, edited
from sjdsl.models.policy import STAY, HostPolicy, Message, Reply
from sjdsl.models.roles import wordings
from sjdsl.told import Past, Window, message, told
from sjdsl.told.legal import end_of_step
from sjdsl.told.message import own_past


def check_playable(env: Any) -> None:
    """Raises ModelError if agents of an environment can't be asked in words."""
    if getattr(env, "game", None) is None or STAY not in env.action_names:
        raise ModelError(
            f"models can't play {env.name}: its rules must be known, and have the action `{STAY}`, "
            "which a reply that can't be used counts as"
        )


@dataclass
class _Seat:
    """One agent of one episode: all that it knows. deeds: what each of its actions counts as."""

    policy: HostPolicy
    system: str
    past: list[Past] = field(default_factory=list)
    notes: tuple[str, ...] = ()
    ledger: Ledger = field(default_factory=Ledger)
    reply: Reply = field(default_factory=lambda: Reply(STAY))
    deeds: dict[str, str] = field(default_factory=dict)
    trial: int = 0

    def own(self) -> tuple[Sequence[Past], Sequence[str], Sequence[str]]:
        """Returns what its messages say of its past, its notes and its ledger."""
        ledger = self.ledger.lines() if self.policy.ledger else []
        return self.past[-self.policy.history :], self.notes, ledger

    def take(self, reply: Reply) -> None:
        """Changes its notes as a reply says, and keeps the reply until its reward is known."""
        if reply.notes is not None:
            self.notes = reply.notes
        if reply.note is not None and self.policy.notebook:
            self.notes, problem = edited(self.notes, reply.note)
            reply = replace(reply, problem=reply.problem or problem)
        self.reply = reply

    def learn(self, reward: float) -> None:
        """Adds what its action has paid to its past and its ledger."""
        action = self.reply.action
        self.ledger.add(self.deeds.get(action, action), reward)
        self.past.append(Past(action, reward, self.reply.problem))


class Seats:
    """The agents of E episodes that are asked in words. Use it in a `with` block, or close it."""

    def __init__(
        self,
        env: Any,
        hosts: Sequence[Mapping[int, HostPolicy]],
        ask: Ask = ask_policy,
        parallel: int = PARALLEL,
    ) -> None:
        """Begins E episodes.

        Args:
          env: one environment of a game.
          hosts: for each episode, the policies of the agents that are asked.
          ask: answers a question, in a thread of its own.
          parallel: the most questions at once.

        Raises:
          ModelError: the game doesn't say what agents are told, or has no action `stay`.
        """
        check_playable(env)
        self._asker = Asker(ask, parallel)
        self._window = Window(env.game, env.token_planes)
        self._actions = tuple(env.action_names)
        self._step = 0
        text = cache(partial(told, env))
        self._seats: dict[tuple[int, int], _Seat] = {}
        for episode, of_episode in enumerate(hosts):
            for agent, policy in sorted(of_episode.items()):
                words = wordings(policy.role, env.game)
                role = words[episode % len(words)]
                self._seats[episode, agent] = _Seat(policy, text(agent, role, policy.notebook))

    def __enter__(self) -> "Seats":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Ends the threads; calls in flight aren't waited for."""
        self._asker.close()

    def choose(self, observation: np.ndarray, allowed: np.ndarray, over: np.ndarray) -> np.ndarray:
        """Asks all agents of the episodes that aren't over.

        Args:
          observation: `[E, N, P, rows, cols]` uint8 tokens; allowed: `[E, N, A]` bool;
          over: `[E]` bool.
        Returns:
          `[E, N]` int32 actions, -1 for who isn't asked.
        """
        questions = []
        for place, seat in self._running(over):
            seen = observation[place]
            names = tuple(compress(self._actions, allowed[place]))
            seat.deeds = {name: end_of_step(name, self._window, seen) or name for name in names}
            if len(names) == 1:
                seat.reply = Reply(names[0])
                continue
            text = message(self._window, seen, allowed[place], *seat.own(), seat.trial)
            asked = Message(seat.system, text, self._actions, names)
            questions.append(Question(*place, self._step, seat.trial, "move", seat.policy, asked))
        for question, reply in self._asker.replies(questions):
            if reply.action not in question.message.allowed:
                problem = reply.problem or f"{reply.action} was not allowed"
                reply = replace(reply, action=STAY, problem=problem, is_valid=False)
            self._seats[question.episode, question.agent].take(reply)
        actions = np.full(observation.shape[:2], -1, np.int32)
        for place, seat in self._running(over):
            actions[place] = self._actions.index(seat.reply.action)
        return actions

    def learn(self, reward: np.ndarray, trial_ended: np.ndarray, over: np.ndarray) -> None:
        """Tells all agents what the step paid; after a trial each revises its notes.

        Args:
          reward: `[E, N]` float; trial_ended: `[E]` bool; over: `[E]` bool, after the step.
        """
        for place, seat in self._seats.items():
            seat.learn(float(reward[place]))
        questions = []
        for place, seat in self._running(over):
            if trial_ended[place[0]] and seat.policy.notebook:
                text = "\n\n".join([*own_past(*seat.own()), REVISE]) + "\n"
                asked = Message(seat.system, text, self._actions, ())
                questions.append(
                    Question(*place, self._step, seat.trial, "notes", seat.policy, asked)
                )
        for question, reply in self._asker.replies(questions):
            self._seats[question.episode, question.agent].take(reply)
        self._step += 1
        for (episode, _), seat in self._seats.items():
            seat.trial += int(trial_ended[episode])

    def _running(self, over: np.ndarray) -> Iterator[tuple[tuple[int, int], _Seat]]:
        return ((place, seat) for place, seat in self._seats.items() if not over[place[0]])
