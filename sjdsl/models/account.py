"""What the calls of an experiment have taken, and what they may still take."""

import threading
from collections import defaultdict
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass

from sjdsl.models.asking import PARALLEL, Question
from sjdsl.models.errors import LimitReached, ModelError
from sjdsl.models.files import Model
from sjdsl.models.policy import Answer, HostPolicy, Message, Reply
from sjdsl.models.recorded import Pending, Talk

CHARACTERS_OF_A_TOKEN = 3  # about; less than in English prose, as windows are signs
LEAST_LETTERS_OF_A_TOKEN = 2  # of ASCII, for the most that a call may cost
Seat = tuple[str, int, int]  # the part of an experiment, the episode in it, the agent
REPORTED = 100  # calls between two lines of progress
DIGITS = 12  # of dollars after the point: sums are the same in any order of calls


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

    def add(self, reply: Reply, dollars: float) -> None:
        """Counts a call."""
        answer = reply.answer or Answer("")
        self.calls += 1
        self.invalid += not reply.is_valid
        self.input += answer.input
        self.cached += answer.cached
        self.output += answer.output
        self.dollars = round(self.dollars + dollars, DIGITS)


class Account:
    """Counts the calls of an experiment, in several threads.

    usage: of all commands in its folder, by model, role and trial; by_seat: of this one, by part,
    episode and agent; server_names: by model, the name that its server gives it.
    in_flight: calls that haven't been answered yet; unanswered: those that never were.
    """

    def __init__(
        self,
        limits: Limits,
        tell: Callable[[str], None] = lambda _: None,
        is_recorded: bool = True,
    ) -> None:
        """tell: gets a line after every hundred calls; is_recorded: whether calls are on disk."""
        self.usage: defaultdict[tuple[str, str, int], Usage] = defaultdict(Usage)
        self.by_seat: defaultdict[Seat, Usage] = defaultdict(Usage)
        self.server_names: dict[str, str] = {}
        self._limits = limits
        self._tell = tell
        self._is_recorded = is_recorded
        self._lock = threading.Lock()
        self.in_flight = Pending()
        self.unanswered = Pending()

    def total(self) -> Usage:
        """Returns the usage of all models together."""
        return _sum(self.usage.values())

    def by_policy(self) -> dict[str, Usage]:
        """Returns the usage by model and role, `luna+cooperator`."""
        parts: defaultdict[str, list[Usage]] = defaultdict(list)
        for (model, role, _), usage in sorted(self.usage.items()):
            parts[f"{model}+{role}" if role else model].append(usage)
        return {name: _sum(usages) for name, usages in parts.items()}

    def recall(self, talk: Talk) -> None:
        """Counts a call that an earlier command has recorded. Raises as `check_server_name`."""
        self.usage[talk.model, talk.role, talk.trial].add(talk.reply, talk.dollars)
        self.check_server_name(talk.model, talk.reply)

    def admit(self, question: Question) -> float:
        """Notes a call in flight; returns the most dollars that it may cost.

        Raises:
          LimitReached: it might pass a limit.
        """
        dollars = _most_dollars(question, self._limits)
        with self._lock:
            self._check_limits(dollars)
            self.in_flight.add(1, dollars)
        return dollars

    def release(self, dollars: float) -> None:
        """Notes that a call in flight has failed, and costs nothing."""
        with self._lock:
            self.in_flight.add(-1, -dollars)

    def count(self, part: str, question: Question, talk: Talk, noted: float) -> None:
        """Counts a call in flight, for which so many dollars were noted."""
        with self._lock:
            self.in_flight.add(-1, -noted)
            self.usage[talk.model, talk.role, talk.trial].add(talk.reply, talk.dollars)
            self.count_seat(part, question, talk)
            total = self.total()
            if total.calls % REPORTED == 0:
                self._tell(
                    f"{total.calls:,} calls, {total.invalid:,} unusable, ${total.dollars:.2f}"
                )

    def count_seat(self, part: str, question: Question, talk: Talk) -> None:
        """Counts a call of one agent in one episode, of which no other thread knows."""
        self.by_seat[part, question.episode, question.agent].add(talk.reply, talk.dollars)

    def check_server_name(self, name: str, reply: Reply) -> None:
        """Raises ModelError if the server of a model calls it otherwise than before."""
        answer = reply.answer or Answer("")
        if not answer.model:  # no server was asked, or what it sent names no model
            return
        known = self.server_names.setdefault(name, answer.model)
        if known != answer.model:
            raise ModelError(
                f"the server of {name} says now that its model is `{answer.model}`, and earlier "
                f"replies are of `{known}`; start in another folder"
            )

    def _check_limits(self, dollars: float) -> None:
        """Raises LimitReached if one more call of so many dollars might pass a limit."""
        limits = self._limits
        used = self.total()
        calls = used.calls + self.in_flight.calls + self.unanswered.calls
        if limits.calls is not None and calls >= limits.calls:
            raise LimitReached(
                f"{calls} calls were made, and at most {limits.calls} may be; "
                f"{self._with_more('--calls')}"
            )
        most = used.dollars + self.in_flight.dollars + self.unanswered.dollars
        if limits.budget is not None and most + dollars > limits.budget:
            raise LimitReached(
                f"{used.dollars:.4f} dollars are spent{self.unanswered.text()}, and the next call "
                f"might pass the budget of {limits.budget:g}; {self._with_more('--budget')}"
            )

    def _with_more(self, limit: str) -> str:
        if self._is_recorded:
            return f"all replies are kept: the same command with a larger {limit} goes on"
        return f"choose a larger {limit}; nothing was recorded, so all calls would be made again"


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


def dollars_of(policy: HostPolicy, reply: Reply, most: float) -> float:
    """Returns what a reply cost; the most that it may have cost if the server counts no tokens."""
    answer = reply.answer or Answer("")
    if not isinstance(policy, Model):
        return 0.0
    if answer.input == 0:
        return most
    return policy.dollars(answer.input, answer.cached, answer.output)


def _sum(usages: Iterable[Usage]) -> Usage:
    total = Usage()
    for usage in usages:
        for name, amount in asdict(usage).items():
            setattr(total, name, getattr(total, name) + amount)
    return total


def check_price(policy: HostPolicy, limits: Limits) -> None:
    """Raises ModelError if a budget can't be kept, as a model has no price."""
    is_priced = not isinstance(policy, Model) or policy.kind == "fake" or policy.price is not None
    if limits.budget is not None and not is_priced:
        raise ModelError(
            f"--budget needs the `price` of {name_of(policy)} in its table; or limit the --calls"
        )


def _most_dollars(question: Question, limits: Limits) -> float:
    """Returns the most that a call may cost. Raises ModelError as `check_price`."""
    policy = question.policy
    check_price(policy, limits)
    if not isinstance(policy, Model):
        return 0.0
    return policy.dollars(most_tokens(question.message), 0, policy.max_tokens)
