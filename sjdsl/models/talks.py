"""The calls of an experiment: recorded before they are acted on, replayed by the same command, and
kept within limits.
"""

import json
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path

from filelock import FileLock, Timeout

from sjdsl.extras import MissingExtra
from sjdsl.files import write_whole
from sjdsl.models import recorded
from sjdsl.models.account import Account, Limits, dollars_of, name_of
from sjdsl.models.asking import Ask, Question, ask_policy
from sjdsl.models.errors import ModelError, Unanswered
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
        self.account = Account(self.limits, tell, is_recorded=folder is not None)
        self.folder = None if folder is None else folder / recorded.FOLDER
        self._free = threading.Semaphore(self.limits.parallel)
        self._file_lock: FileLock | None = None
        self._recorded: dict[Path, recorded.Talks] = {}
        self._changed = threading.Condition()  # of what follows
        self._running = 0  # calls
        self._stopped_by: BaseException | None = None  # after which no call begins
        self._keeps_replies = True

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
            self.account.unanswered = recorded.read_unanswered(self.folder)
            for path in sorted(self.folder.rglob("agent_*.jsonl")):
                recorded.cut_torn_line(path)
                self._recorded[path] = recorded.read_talks(path)
                for talk in self._recorded[path].values():
                    self.account.recall(talk)
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        """Begins no other call, and waits for those that are under way, but not after Ctrl-C."""
        try:
            with self._changed:
                self._stopped_by = self._stopped_by or ModelError("the experiment has ended")
                if kind is None or issubclass(kind, Exception):
                    self._changed.wait_for(lambda: not self._running)
        finally:
            self._keeps_replies = False  # as another process may have the folder from now on
            if self._file_lock is not None:
                try:
                    self._write_account()
                except OSError:
                    if kind is None:
                        raise
                    # The first error counts, such as that of a full disk.
                finally:
                    self._file_lock.release()

    def part(self, name: str) -> Ask:
        """Returns a function that answers the questions of a part of the experiment."""
        return lambda question: self._answered(name, question)

    def _write_account(self) -> None:
        """Writes `usage.json`, and what calls without an answer may have cost."""
        rows = []
        for (model, role, trial), usage in sorted(self.account.usage.items()):
            rows.append({"model": model, "role": role, "trial": trial, **asdict(usage)})
        assert self.folder is not None
        write_whole(self.folder / "usage.json", json.dumps(rows, indent=1) + "\n")
        lost = self.account.in_flight
        if lost.calls:
            self.account.unanswered.add(lost.calls, lost.dollars)
            recorded.write_unanswered(self.account.unanswered, self.folder)

    def _answered(self, part: str, question: Question) -> Reply:
        """Returns the recorded reply to a question, or asks, and records the call in a folder."""
        path = None
        if self.folder is not None:
            path = recorded.file_of(self.folder / part, question.episode, question.agent)
            talk = self._recorded.get(path, {}).get((question.step, question.kind))
            if talk is not None:
                recorded.check_request(talk, question, path)
                self.account.count_seat(part, question, talk)
                return talk.reply
        with self._call():
            noted = self.account.admit(question)
            talk = self._asked(question, noted)
            if path is not None:
                self._keep(talk, path)
            self.account.count(part, question, talk, noted)
        return talk.reply

    @contextmanager
    def _call(self) -> Iterator[None]:
        """A call, when there are fewer than `parallel`. After one that failed, none begins."""
        with self._free:
            with self._changed:
                if self._stopped_by is not None:
                    raise self._stopped_by
                self._running += 1
            try:
                yield
            except BaseException as error:
                self._stopped_by = self._stopped_by or error
                raise
            finally:
                with self._changed:
                    self._running -= 1
                    self._changed.notify_all()

    def _asked(self, question: Question, noted: float) -> recorded.Talk:
        """Asks. A call that fails stays among those in flight, unless it costs nothing."""
        policy = question.policy
        start = time.monotonic()
        try:
            reply = ask_policy(question)
        except Unanswered:
            raise
        except (ModelError, MissingExtra):
            self.account.release(noted)
            raise
        self.account.check_server_name(name_of(policy), reply)
        return recorded.Talk(
            question.step,
            question.trial,
            question.kind,
            recorded.request_hash(question.message),
            recorded.line_hashes(question.message),
            reply,
            round(time.monotonic() - start, 3),
            datetime.now(UTC).isoformat(timespec="seconds"),
            dollars_of(policy, reply, noted),
            name_of(policy),
            policy.role,
        )

    def _keep(self, talk: recorded.Talk, path: Path) -> None:
        """Records a call.

        Raises:
          ModelError: it can't be written, such as to a full disk, or comes after the end.
        """
        if not self._keeps_replies:
            raise ModelError("the experiment has ended")
        try:
            recorded.append_talk(talk, path)
        except OSError as error:
            raise ModelError(
                f"{path}: {(error.strerror or 'cannot be written').lower()}. A reply is acted on "
                "once it is on disk: make that possible, and the same command goes on from the "
                "replies before"
            ) from error
