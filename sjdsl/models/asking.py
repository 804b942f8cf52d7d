"""Questions to agents, asked side by side."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from multiprocessing.pool import ThreadPool
from typing import Literal
from weakref import finalize

from sjdsl.models.errors import ModelError
from sjdsl.models.policy import HostPolicy, Message, Reply

Kind = Literal["move", "notes"]
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


class Asker:
    """Asks many agents at once, each question in a thread, until it is closed."""

    def __init__(self, ask: Ask, parallel: int) -> None:
        """ask: answers a question; parallel: the most questions at once."""
        self._ask = ask
        self._pool = ThreadPool(parallel)
        # An episode may be left before its end, and then nobody closes what asks in it.
        self._end = finalize(self, self._pool.terminate)
        self._invalid_in_a_row: dict[int, int] = {}  # of who has answered, by `id`

    def close(self) -> None:
        """Ends the threads; calls in flight aren't waited for."""
        self._end()

    def replies(self, questions: Sequence[Question]) -> Iterator[tuple[Question, Reply]]:
        """Yields questions with their replies.

        The first question to a policy is asked alone, so that a wrong key costs one call.

        Raises:
          ModelError: many replies of a policy in a row can't be used.
        """
        first = {}
        for number, question in enumerate(questions):
            if id(question.policy) not in self._invalid_in_a_row:
                first[number] = self._ask(question)
                self._invalid_in_a_row[id(question.policy)] = 0

        def answered(number: int) -> Reply:
            return first.get(number) or self._ask(questions[number])

        replies = list(self._pool.imap(answered, range(len(questions))))
        for question, reply in zip(questions, replies, strict=True):
            policy = id(question.policy)
            invalid = 0 if reply.is_valid else self._invalid_in_a_row[policy] + 1
            self._invalid_in_a_row[policy] = invalid
            if invalid == MOST_INVALID:
                raise ModelError(
                    f"{MOST_INVALID} replies in a row could not be used, the last one because "
                    f"{reply.problem}; look at the replies, and at `schema` and `max_tokens` of "
                    "the model"
                )
            yield question, reply
