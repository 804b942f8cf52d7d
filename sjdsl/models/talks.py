"""The calls of an experiment: recorded before they are acted on, replayed by the same command, and
kept within limits.
"""

import hashlib
import json
import os
import threading
import time
import zlib
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal

from filelock import FileLock, Timeout
from pydantic import TypeAdapter, ValidationError

from sjdsl.files import naming, open_in_place, read_lines, write_whole
from sjdsl.models.errors import LimitReached, ModelError
from sjdsl.models.files import Model
from sjdsl.models.policy import Answer, HostPolicy, Message, Reply
from sjdsl.models.seats import PARALLEL, Ask, Kind, Question, ask_policy

FOLDER = "talks"
CHARACTERS_OF_A_TOKEN = 3  # about; less than in English prose, as windows are signs
REPORTED = 100  # calls between two lines of progress
LEAST_CHARACTERS_OF_A_TOKEN = 2  # for the most that a call may cost


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


@dataclass(frozen=True)
class Talk:
    """One call, a line of a file.

    request: the first half of the SHA-256 of all that the model was told; lines: four hexadecimal
    digits for each line of the message, to name the first one that differs.
    seconds: how long it took; time: when it was answered, UTC; dollars: by the price then.
    """

    step: int
    trial: int
    kind: Kind
    request: str
    lines: str
    reply: Reply
    seconds: float
    time: str
    dollars: float
    format: Literal["sjdsl-talk-1"] = "sjdsl-talk-1"


TALK = TypeAdapter(Talk)


def tokens(message: Message, characters: int = CHARACTERS_OF_A_TOKEN) -> int:
    """Returns about how many tokens a message has."""
    return (len(message.system) + len(message.text)) // characters


def name_of(policy: HostPolicy) -> str:
    """Returns the name by which the calls of a policy are counted."""
    return getattr(policy, "name", "") or type(policy).__name__


class Talks:
    """The calls of an experiment. Use it in a `with` block.

    usage: by model, role and trial.
    """

    def __init__(
        self,
        folder: Path | None = None,
        limits: Limits | None = None,
        tell: Callable[[str], None] = lambda _: None,
    ) -> None:
        """Records in `FOLDER/talks`, or nowhere. tell: gets a line after every hundred calls."""
        self.limits = limits or Limits()
        self.usage: defaultdict[tuple[str, str, int], Usage] = defaultdict(Usage)
        self._tell = tell
        self._folder = None if folder is None else folder / FOLDER
        self._lock = threading.Lock()
        self._free = threading.Semaphore(self.limits.parallel)
        self._file_lock: FileLock | None = None
        self._recorded: dict[Path, dict[tuple[int, Kind], Talk]] = {}
        self._server_names: dict[str, str] = {}
        # of calls in flight, and of those recorded earlier that nobody has asked for again yet
        self._calls_pending = 0
        self._dollars_pending = 0.0

    def __enter__(self) -> "Talks":
        """Locks the folder and reads its calls.

        Raises:
          ModelError: another process asks models for it, or a file is damaged.
        """
        if self._folder is not None:
            self._folder.mkdir(parents=True, exist_ok=True)
            self._file_lock = FileLock(self._folder / "lock")
            try:
                self._file_lock.acquire(timeout=0)
            except Timeout:
                raise ModelError(
                    f"another process is asking models for {self._folder.parent}; wait for its end"
                ) from None
            for path in sorted(self._folder.rglob("agent_*.jsonl")):
                self._recorded[path] = _read(path)
                for talk in self._recorded[path].values():
                    self._reserve(1, talk.dollars)
        return self

    def __exit__(self, *_: object) -> None:
        if self._file_lock is not None:
            self.write_usage()
            self._file_lock.release()

    def part(self, name: str) -> Ask:
        """Returns a function that answers the questions of a part of the experiment."""
        return lambda question: self._answered(name, question)

    def write_usage(self) -> None:
        """Writes `usage.json`."""
        rows = []
        for (model, role, trial), usage in sorted(self.usage.items()):
            rows.append({"model": model, "role": role, "trial": trial, **asdict(usage)})
        assert self._folder is not None
        write_whole(self._folder / "usage.json", json.dumps(rows, indent=1) + "\n")

    def total(self) -> Usage:
        """Returns the usage of all models together."""
        return _sum(list(self.usage.values()))

    def by_policy(self) -> dict[str, Usage]:
        """Returns the usage by model and role, `luna+cooperator`."""
        parts: defaultdict[str, list[Usage]] = defaultdict(list)
        for (model, role, _), usage in sorted(self.usage.items()):
            parts[f"{model}+{role}" if role else model].append(usage)
        return {name: _sum(usages) for name, usages in parts.items()}

    def _answered(self, part: str, question: Question) -> Reply:
        """Returns the recorded reply to a question, or asks and records it."""
        if self._folder is None:
            return self._asked(question)
        folder = self._folder / part / f"episode_{question.episode:05d}"
        path = folder / f"agent_{question.agent}.jsonl"
        recorded = self._recorded.get(path, {}).get((question.step, question.kind))
        if recorded is not None:
            _check(recorded, question, path)
            self._count(question, recorded.reply, recorded.dollars)
            return recorded.reply
        start = time.monotonic()
        reply = self._asked(question)
        talk = Talk(
            question.step,
            question.trial,
            question.kind,
            _hash(question.message),
            _line_hashes(question.message),
            reply,
            round(time.monotonic() - start, 3),
            datetime.now(UTC).isoformat(timespec="seconds"),
            _dollars(question.policy, reply),
        )
        folder.mkdir(parents=True, exist_ok=True)
        with naming(path), open_in_place(path, "a") as file:
            file.write(TALK.dump_json(talk).decode() + "\n")
            file.flush()
            os.fsync(file.fileno())
        return reply

    def _asked(self, question: Question) -> Reply:
        """Asks and counts the call, unless that might pass a limit."""
        dollars = _most_dollars(question, self.limits)
        with self._lock:
            self._check_limits(dollars)
            self._reserve(1, dollars)
        try:
            with self._free:
                reply = ask_policy(question)
        except BaseException:
            with self._lock:
                self._reserve(-1, -dollars)
            raise
        self._count(question, reply, dollars)
        return reply

    def _reserve(self, calls: int, dollars: float) -> None:
        self._calls_pending += calls
        self._dollars_pending += dollars

    def _check_limits(self, dollars: float) -> None:
        """Raises LimitReached if one more call of so many dollars might pass a limit."""
        used = self.total()
        limits = self.limits
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

    def _count(self, question: Question, reply: Reply, reserved: float) -> None:
        """Counts a call; until now so many dollars were reserved for it."""
        policy = question.policy
        name = name_of(policy)
        answer = reply.answer or Answer("")
        with self._lock:
            self._reserve(-1, -reserved)
            known = self._server_names.setdefault(name, answer.model)
            if known != answer.model:
                raise ModelError(
                    f"the server of {name} says now that its model is `{answer.model}`, and earlier "
                    f"replies are of `{known}`; start in another folder"
                )
            usage = self.usage[name, policy.role, question.trial]
            usage.calls += 1
            usage.invalid += not reply.is_valid
            usage.input += answer.input
            usage.cached += answer.cached
            usage.output += answer.output
            if isinstance(policy, Model):
                tokens_so_far = (usage.input, usage.cached, usage.output)
                usage.dollars = policy.dollars(*tokens_so_far)  # the same in any order of calls
            total = self.total()
            if total.calls % REPORTED == 0:
                self._tell(
                    f"{total.calls:,} calls, {total.invalid:,} unusable, ${total.dollars:.2f}"
                )


def _sum(usages: Sequence[Usage]) -> Usage:
    total = Usage()
    for usage in usages:
        for name, amount in asdict(usage).items():
            setattr(total, name, getattr(total, name) + amount)
    return total


def _dollars(policy: HostPolicy, reply: Reply) -> float:
    """Returns what a reply cost."""
    answer = reply.answer
    if answer is None or not isinstance(policy, Model):
        return 0.0
    return policy.dollars(answer.input, answer.cached, answer.output)


def _most_dollars(question: Question, limits: Limits) -> float:
    """Returns the most that a call may cost. Raises ModelError if a budget can't be kept."""
    policy = question.policy
    if limits.budget is None or not isinstance(policy, Model):
        return 0.0
    if policy.price is None and policy.kind != "fake":
        raise ModelError(
            f"--budget needs the `price` of {policy.name} in its table; or limit the --calls"
        )
    most = tokens(question.message, LEAST_CHARACTERS_OF_A_TOKEN)
    return policy.dollars(most, 0, policy.max_tokens)


def _hash(message: Message) -> str:
    parts = (message.system, message.text, *message.actions, *message.allowed)
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:32]


def _line_hashes(message: Message) -> str:
    lines = message.text.splitlines()
    return "".join(f"{zlib.crc32(line.encode()) & 0xFFFF:04x}" for line in lines)


def _read(path: Path) -> dict[tuple[int, Kind], Talk]:
    """Returns the calls in a file; a last line that was torn is cut off.

    Raises:
      ModelError: another line is damaged.
    """
    if not path.exists():
        return {}
    talks: dict[tuple[int, Kind], Talk] = {}
    size = 0
    for number, line in enumerate(read_lines(path), 1):
        try:
            talk = TALK.validate_json(line)
        except ValidationError:
            raise ModelError(
                f"line {number} of {path} is damaged; remove it and all after it"
            ) from None
        talks[talk.step, talk.kind] = talk
        size += len(line)
    if size < path.stat().st_size:
        with naming(path), open_in_place(path, "r+") as file:
            file.truncate(size)
    return talks


def _check(recorded: Talk, question: Question, path: Path) -> None:
    """Raises ModelError if another request was recorded than is made now."""
    if recorded.request == _hash(question.message):
        return
    lines: list[Any] = question.message.text.splitlines()
    now = _line_hashes(question.message)
    where = "what it is told of the game differs"
    for number, line in enumerate([*lines, "its end"]):
        digits = slice(4 * number, 4 * number + 4)
        if now[digits] != recorded.lines[digits]:
            where = f"line {number + 1} differs, now `{line}`"
            break
    raise ModelError(
        f"step {question.step} of {path} was recorded with another message: {where}; play into "
        "another folder"
    )
