"""Who is asked in words: what each of these agents has done, earned and noted, in all episodes that
are played side by side, and the questions of a step."""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from multiprocessing.pool import ThreadPool
from typing import Any, Literal

import numpy as np

from sjdsl.models.errors import ModelError
from sjdsl.models.ledger import Ledger
from sjdsl.models.notebook import REVISE, edited
from sjdsl.models.policy import STAY, HostPolicy, Message, Reply
from sjdsl.models.roles import wordings
from sjdsl.told import Past, Window, message, told
from sjdsl.told.legal import end_of_step
from sjdsl.told.message import own_past

Kind = Literal["move", "notes"]
UNASKED = -1  # the action of an agent that isn't asked
PARALLEL = 16  # calls at once
MOST_INVALID = 20  # replies in a row that can't be used, of one policy


@dataclass(frozen=True)
class Question:
    """A message to one agent. kind: whether it is asked for an action or for its notes."""

    episode: int
    agent: int
    step: int
    trial: int
    kind: Kind
    policy: HostPolicy
    message: Message


Ask = Callable[[Question], Reply]


def ask_policy(question: Question) -> Reply:
    """Returns the reply of the policy that is asked."""
    ask = question.policy.revise if question.kind == "notes" else question.policy.decide
    return ask(question.agent, question.message)


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
        self._ask = ask
        self._pool = ThreadPool(parallel)
        self._window = Window(env.game, env.token_planes)
        self._actions = tuple(env.action_names)
        self._num_agents = env.num_agents
        self._step = 0
        self._trials = [0] * len(hosts)
        self._invalid_in_a_row: Counter[int] = Counter()
        self._known: set[int] = set()  # who has answered, by `id`
        text = cache(partial(told, env))
        self._seats: dict[tuple[int, int], _Seat] = {}
        for episode, of_episode in enumerate(hosts):
            for agent, policy in sorted(of_episode.items()):
                words = wordings(policy.role, env.game)
                role = words[episode % len(words)]
                system = text(agent, role, policy.notebook)
                self._seats[episode, agent] = _Seat(policy, system)
        self._num_episodes = len(hosts)

    def __enter__(self) -> "Seats":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Ends the threads; calls in flight aren't waited for."""
        self._pool.terminate()

    def choose(self, observation: np.ndarray, allowed: np.ndarray, over: np.ndarray) -> np.ndarray:
        """Asks all agents of the episodes that aren't over.

        Args:
          observation: `[E, N, P, rows, cols]` uint8 tokens; allowed: `[E, N, A]` bool;
          over: `[E]` bool.
        Returns:
          `[E, N]` int32 actions, -1 for who isn't asked.
        """
        questions = {}
        for place, seat in self._running(over):
            seen = observation[place]
            names = self._legal(allowed[place])
            seat.deeds = {name: end_of_step(name, self._window, seen) or name for name in names}
            if len(names) == 1:
                seat.reply = Reply(names[0])
                continue
            trial = self._trials[place[0]]
            text = message(self._window, seen, allowed[place], *seat.own(), trial)
            questions[place] = self._question(place, "move", text, names)
        for place, reply in self._replies(questions):
            if reply.action not in questions[place].message.allowed:
                problem = reply.problem or f"{reply.action} was not allowed"
                reply = replace(reply, action=STAY, problem=problem, is_valid=False)
            self._seats[place].take(reply)
        actions = np.full((self._num_episodes, self._num_agents), UNASKED, np.int32)
        for place, seat in self._running(over):
            actions[place] = self._actions.index(seat.reply.action)
        return actions

    def learn(self, reward: np.ndarray, trial_ended: np.ndarray, over: np.ndarray) -> None:
        """Tells all agents what the step paid; after a trial each revises its notes.

        Args:
          reward: `[E, N]` float; trial_ended: `[E]` bool; over: `[E]` bool, after the step.
        """
        questions = {}
        for place, seat in self._seats.items():
            action = seat.reply.action
            amount = float(reward[place])
            seat.ledger.add(seat.deeds.get(action, action), amount)
            seat.past.append(Past(action, amount, seat.reply.problem))
        for place, seat in self._running(over):
            if trial_ended[place[0]] and seat.policy.notebook:
                text = "\n\n".join([*own_past(*seat.own()), REVISE]) + "\n"
                questions[place] = self._question(place, "notes", text, ())
        for place, reply in self._replies(questions):
            self._seats[place].take(reply)
        self._step += 1
        for episode in np.flatnonzero(trial_ended):
            self._trials[episode] += 1

    def _running(self, over: np.ndarray) -> Iterator[tuple[tuple[int, int], _Seat]]:
        return ((place, seat) for place, seat in self._seats.items() if not over[place[0]])

    def _legal(self, allowed: np.ndarray) -> tuple[str, ...]:
        return tuple(name for name, may in zip(self._actions, allowed, strict=True) if may)

    def _question(
        self, place: tuple[int, int], kind: Kind, text: str, allowed: tuple[str, ...]
    ) -> Question:
        seat = self._seats[place]
        asked = Message(seat.system, text, self._actions, allowed)
        trial = self._trials[place[0]]
        return Question(*place, self._step, trial, kind, seat.policy, asked)

    def _replies(
        self, questions: Mapping[tuple[int, int], Question]
    ) -> Iterator[tuple[tuple[int, int], Reply]]:
        """Yields the replies to questions, which are asked side by side.

        The first question to a policy is asked alone, so that a wrong key costs one call.
        """
        ready = {}
        for place, question in questions.items():
            if id(question.policy) not in self._known:
                ready[place] = self._ask(question)
                self._known.add(id(question.policy))
        waiting = [place for place in questions if place not in ready]
        answers = self._pool.imap(self._ask, [questions[place] for place in waiting])
        ready |= zip(waiting, answers, strict=True)
        for place in questions:
            policy = id(questions[place].policy)
            is_valid = ready[place].is_valid
            self._invalid_in_a_row[policy] = 0 if is_valid else self._invalid_in_a_row[policy] + 1
            if self._invalid_in_a_row[policy] == MOST_INVALID:
                raise ModelError(
                    f"{MOST_INVALID} replies in a row could not be used, the last one because "
                    f"{ready[place].problem}; look at the replies, and at `schema` and "
                    "`max_tokens` of the model"
                )
            yield place, ready[place]
