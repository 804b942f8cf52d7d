"""What the calls of an experiment have taken, and what they may still take."""

import threading
from collections import defaultdict
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass

from sjdsl.models.asking import PARALLEL, Question
from sjdsl.models.errors import LimitReached, ModelError
from sjdsl.models.files import Model
from sjdsl.models.policy import Answer, HostPolicy, Message, Reply

CHARACTERS_OF_A_TOKEN = 3  # about; less than in English prose, as windows are signs
LEAST_LETTERS_OF_A_TOKEN = 2  # of ASCII, for the most that a call may cost
Seat = tuple[str, int, int]  # the part of an experiment, the episode in it, the agent
REPORTED = 100  # calls between two lines of progress


@dataclass(frozen=True)
class Limits:
    """How models are asked.

    parallel: the most calls at once.
    budget: dollars, calls: their number; both count all calls in a folder, also of earlier runs.
    """

    parallel: int = PARALLEL
    budget: float | None = None
    calls: int | None = None


@dataclass
class Usage:
    """What calls took. invalid: replies that couldn't be used."""

    calls: int = 0
    invalid: int = 0
    input: int = 0
    cached: int = 0
    output: int = 0
    dollars: float = 0.0

    @property
    def invalid_share(self) -> float:
        """The share of replies that couldn't be used."""
        return self.invalid / self.calls if self.calls else 0.0

    def add(self, policy: HostPolicy, reply: Reply) -> None:
        """Counts a call."""
        answer = reply.answer or Answer("")
        self.calls += 1
        self.invalid += not reply.is_valid
        self.input += answer.input
        self.cached += answer.cached
        self.output += answer.output
        if isinstance(policy, Model):  # the same in any order of calls
            self.dollars = policy.dollars(self.input, self.cached, self.output)


class Account:
    """Counts the calls of an experiment, in several threads.

    usage: by model, role and trial; by_seat: by part, episode and agent; server_names: by model,
    the name that its server gives it.
    """

    def __init__(self, limits: Limits, tell: Callable[[str], None] = lambda _: None) -> None:
        """tell: gets a line after every hundred calls."""
        self.usage: defaultdict[tuple[str, str, int], Usage] = defaultdict(Usage)
        self.by_seat: defaultdict[Seat, Usage] = defaultdict(Usage)
        self.server_names: dict[str, str] = {}
        self._limits = limits
        self._tell = tell
        self._lock = threading.Lock()
        # of calls in flight, and of those recorded earlier that nobody has asked for again yet
        self._calls_pending = 0
        self._dollars_pending = 0.0

    def total(self) -> Usage:
        """Returns the usage of all models together."""
        return _sum(self.usage.values())

    def by_policy(self) -> dict[str, Usage]:
        """Returns the usage by model and role, `luna+cooperator`."""
        parts: defaultdict[str, list[Usage]] = defaultdict(list)
        for (model, role, _), usage in sorted(self.usage.items()):
            parts[f"{model}+{role}" if role else model].append(usage)
        return {name: _sum(usages) for name, usages in parts.items()}

    def reserve(self, dollars: float) -> None:
        """Notes a recorded call that nobody has asked for again yet."""
        with self._lock:
            self._pend(1, dollars)

    def admit(self, question: Question) -> float:
        """Notes a call in flight; returns the most dollars that it may cost.

        Raises:
          LimitReached: it might pass a limit.
        """
        dollars = _most_dollars(question, self._limits)
        with self._lock:
            self._check_limits(dollars)
            self._pend(1, dollars)
        return dollars

    def release(self, dollars: float) -> None:
        """Notes that a call which was admitted has failed."""
        with self._lock:
            self._pend(-1, -dollars)

    def count(self, part: str, question: Question, reply: Reply, pending: float) -> None:
        """Counts a call; until now so many dollars were noted for it.

        Raises:
          ModelError: the server has another model than before.
        """
        with self._lock:
            self._pend(-1, -pending)
            self.add(
                (part, question.episode, question.agent), question.trial, question.policy, reply
            )
            total = self.total()
            if total.calls % REPORTED == 0:
                self._tell(
                    f"{total.calls:,} calls, {total.invalid:,} unusable, ${total.dollars:.2f}"
                )

    def add(self, seat: Seat, trial: int, policy: HostPolicy, reply: Reply) -> None:
        """Counts a call of which nothing was noted, in one thread. Raises as `count`."""
        self.usage[name_of(policy), policy.role, trial].add(policy, reply)
        self.by_seat[seat].add(policy, reply)
        self._check_server_name(name_of(policy), reply.answer or Answer(""))

    def _pend(self, calls: int, dollars: float) -> None:
        self._calls_pending += calls
        self._dollars_pending += dollars

    def _check_server_name(self, name: str, answer: Answer) -> None:
        known = self.server_names.setdefault(name, answer.model)
        if known != answer.model:
            raise ModelError(
                f"the server of {name} says now that its model is `{answer.model}`, and earlier "
                f"replies are of `{known}`; start in another folder"
            )

    def _check_limits(self, dollars: float) -> None:
        """Raises LimitReached if one more call of so many dollars might pass a limit."""
        used = self.total()
        limits = self._limits
        if limits.calls is not None and used.calls + self._calls_pending >= limits.calls:
            raise LimitReached(
                f"{used.calls} calls were made, and at most {limits.calls} may be; all replies are "
                "kept: the same command with a larger --calls goes on"
            )
        most = used.dollars + self._dollars_pending + dollars
        if limits.budget is not None and most > limits.budget:
            raise LimitReached(
                f"{used.dollars:.4f} dollars are spent, and the next call might pass the budget of "
                f"{limits.budget:g}; all replies are kept: the same command with a larger "
                "--budget goes on"
            )


def tokens(message: Message) -> int:
    """Returns about how many tokens a message has."""
    return (len(message.system) + len(message.text)) // CHARACTERS_OF_A_TOKEN


def most_tokens(message: Message) -> int:
    """Returns how many tokens a message may have: other characters than ASCII may be one a byte."""
    text = message.system + message.text
    others = [character for character in text if not character.isascii()]
    letters = len(text) - len(others)
    return letters // LEAST_LETTERS_OF_A_TOKEN + len("".join(others).encode())


def name_of(policy: HostPolicy) -> str:
    """Returns the name by which the calls of a policy are counted."""
    return getattr(policy, "name", "") or type(policy).__name__


def dollars_of(policy: HostPolicy, reply: Reply) -> float:
    """Returns what a reply cost."""
    usage = Usage()
    usage.add(policy, reply)
    return usage.dollars


def _sum(usages: Iterable[Usage]) -> Usage:
    total = Usage()
    for usage in usages:
        for name, amount in asdict(usage).items():
            setattr(total, name, getattr(total, name) + amount)
    return total


def _most_dollars(question: Question, limits: Limits) -> float:
    """Returns the most that a call may cost. Raises ModelError if a budget can't be kept."""
    policy = question.policy
    if limits.budget is None or not isinstance(policy, Model):
        return 0.0
    if policy.price is None and policy.kind != "fake":
        raise ModelError(
            f"--budget needs the `price` of {policy.name} in its table; or limit the --calls"
        )
    return policy.dollars(most_tokens(question.message), 0, policy.max_tokens)
