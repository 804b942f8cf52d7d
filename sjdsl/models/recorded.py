"""Calls on disk: a line for each, the file of one agent in one episode; checked when replayed."""

import hashlib
import os
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from pydantic import TypeAdapter, ValidationError

from sjdsl.files import MEGABYTE, naming, open_in_place, read_bytes, read_lines, write_whole
from sjdsl.models.asking import Kind, Question
from sjdsl.models.errors import ModelError
from sjdsl.models.policy import Message, Reply

FOLDER = "talks"
UNANSWERED = "unanswered.json"


@dataclass(frozen=True)
class Talk:
    """One call, a line of a file.

    request: the first half of the SHA-256 of all that the model was told; lines: four hexadecimal
    digits for each line of the message, to name the first one that differs.
    seconds: how long it took; time: when it was answered, UTC; dollars: by the price then.
    model, role: the names by which it is counted.
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
    model: str
    role: str
    format: Literal["sjdsl-talk-1"] = "sjdsl-talk-1"


@dataclass
class Pending:
    """Calls without an answer, and the most dollars that they may cost."""

    calls: int = 0
    dollars: float = 0.0

    def add(self, calls: int, dollars: float) -> None:
        """Adds calls, or takes them away."""
        self.calls += calls
        self.dollars += dollars

    def text(self) -> str:
        """Returns both in words, as the continuation of a sentence; empty without calls."""
        if not self.calls:
            return ""
        return f", and up to ${self.dollars:.4f} for {self.calls:,} calls that were never answered"


TALK = TypeAdapter(Talk)
PENDING = TypeAdapter(Pending)
Talks = dict[tuple[int, Kind], Talk]  # of one agent in one episode, by step and kind


def file_of(folder: Path, episode: int, agent: int) -> Path:
    """Returns the file of an agent in an episode. folder: of a part of the experiment."""
    return folder / f"episode_{episode:05d}" / f"agent_{agent}.jsonl"


def append_talk(talk: Talk, path: Path) -> None:
    """Adds a call to a file; when this returns, it is on disk."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with naming(path), open_in_place(path, "a") as file:
        file.write(TALK.dump_json(talk).decode() + "\n")
        file.flush()
        os.fsync(file.fileno())


def read_talks(path: Path) -> Talks:
    """Returns the calls in a file, without a last line that was torn; none if there is no file.

    Raises:
      ModelError: another line is damaged.
    """
    if not path.exists():
        return {}
    talks: Talks = {}
    for number, line in enumerate(read_lines(path), 1):
        try:
            talk = TALK.validate_json(line)
        except ValidationError:
            raise ModelError(
                f"line {number} of {path} is damaged; remove it and all after it"
            ) from None
        talks[talk.step, talk.kind] = talk
    return talks


def read_unanswered(folder: Path) -> Pending:
    """Returns the calls of earlier commands in a folder that were never answered."""
    path = folder / UNANSWERED
    if not path.exists():
        return Pending()
    try:
        return PENDING.validate_json(read_bytes(path, MEGABYTE))
    except ValidationError:
        raise ModelError(f"{path} is damaged; remove it, and its calls aren't counted") from None


def write_unanswered(calls: Pending, folder: Path) -> None:
    """Writes what `read_unanswered` reads."""
    write_whole(folder / UNANSWERED, PENDING.dump_json(calls) + b"\n")


def cut_torn_line(path: Path) -> None:
    """Cuts off a last line that was torn, so that a call can be added."""
    size = sum(map(len, read_lines(path)))
    if size < path.stat().st_size:
        with naming(path), open_in_place(path, "r+") as file:
            file.truncate(size)


def request_hash(message: Message) -> str:
    """Returns `request` of a `Talk`."""
    parts = (message.system, message.text, *message.actions, *message.allowed)
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:32]


def line_hashes(message: Message) -> str:
    """Returns `lines` of a `Talk`."""
    lines = message.text.splitlines()
    return "".join(f"{zlib.crc32(line.encode()) & 0xFFFF:04x}" for line in lines)


def check_request(recorded: Talk, question: Question, path: Path) -> None:
    """Raises ModelError if another request was recorded than is made now."""
    if recorded.request == request_hash(question.message):
        return
    lines: list[Any] = question.message.text.splitlines()
    now = line_hashes(question.message)
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


def reasons(folder: Path, episode: int, steps: int, agents: int) -> list[list[str]]:
    """Returns why each agent did what it did, in its own words, `[T][N]`; empty if it gave none.

    Args:
      folder: of a part of the experiment.
    """
    whys = [[""] * agents for _ in range(steps)]
    for agent in range(agents):
        for (step, kind), talk in read_talks(file_of(folder, episode, agent)).items():
            if kind == "move" and step < steps:
                whys[step][agent] = talk.reply.why
    return whys
