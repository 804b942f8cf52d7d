"""The calls of an experiment: recorded before they are acted on, replayed by the same command, and
kept within limits.
"""

import json
import threading
import time
from collections.abc import Callable
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path

from filelock import FileLock, Timeout

from sjdsl.files import write_whole
from sjdsl.models import recorded
from sjdsl.models.account import Account, Limits, dollars_of
from sjdsl.models.asking import Ask, Question, ask_policy
from sjdsl.models.errors import ModelError
from sjdsl.models.policy import Reply


class Talks:
    """The calls of an experiment. Use it in a `with` block.

    account: what they took.
    """

    def __init__(
        self,
        folder: Path | None = None,
        limits: Limits | None = None,
        tell: Callable[[str], None] = lambda _: None,
    ) -> None:
        """Records in `FOLDER/talks`, or nowhere. tell: gets a line after every hundred calls."""
        self.limits = limits or Limits()
        self.account = Account(self.limits, tell)
        self.folder = None if folder is None else folder / recorded.FOLDER
        self._free = threading.Semaphore(self.limits.parallel)
        self._file_lock: FileLock | None = None
        self._recorded: dict[Path, recorded.Talks] = {}

    def __enter__(self) -> "Talks":
        """Locks the folder and reads its calls.

        Raises:
          ModelError: another process asks models for it, or a file is damaged.
        """
        if self.folder is not None:
            self.folder.mkdir(parents=True, exist_ok=True)
            self._file_lock = FileLock(self.folder / "lock")
            try:
                self._file_lock.acquire(timeout=0)
            except Timeout:
                raise ModelError(
                    f"another process is asking models for {self.folder.parent}; wait for its end"
                ) from None
            for path in sorted(self.folder.rglob("agent_*.jsonl")):
                recorded.cut_torn_line(path)
                self._recorded[path] = recorded.read_talks(path)
                for talk in self._recorded[path].values():
                    self.account.reserve(talk.dollars)
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
        for (model, role, trial), usage in sorted(self.account.usage.items()):
            rows.append({"model": model, "role": role, "trial": trial, **asdict(usage)})
        assert self.folder is not None
        write_whole(self.folder / "usage.json", json.dumps(rows, indent=1) + "\n")

    def _answered(self, part: str, question: Question) -> Reply:
        """Returns the recorded reply to a question, or asks, and records the call in a folder."""
        path = None
        if self.folder is not None:
            path = recorded.file_of(self.folder / part, question.episode, question.agent)
            talk = self._recorded.get(path, {}).get((question.step, question.kind))
            if talk is not None:
                recorded.check_request(talk, question, path)
                self.account.count(part, question, talk.reply, talk.dollars)
                return talk.reply
        start = time.monotonic()
        dollars = self.account.admit(question)
        reply = self._asked(question, dollars)
        if path is not None:
            talk = recorded.Talk(
                question.step,
                question.trial,
                question.kind,
                recorded.request_hash(question.message),
                recorded.line_hashes(question.message),
                reply,
                round(time.monotonic() - start, 3),
                datetime.now(UTC).isoformat(timespec="seconds"),
                dollars_of(question.policy, reply),
            )
            recorded.append_talk(talk, path)
        self.account.count(part, question, reply, dollars)
        return reply

    def _asked(self, question: Question, dollars: float) -> Reply:
        """Asks; a call that fails is no longer counted as one in flight."""
        try:
            with self._free:
                return ask_policy(question)
        except BaseException:
            self.account.release(dollars)
            raise
