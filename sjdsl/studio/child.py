"""A worker process, as the server uses it: one request at a time, each with a time limit."""

import asyncio
import contextlib
import json
import sys
from asyncio.subprocess import PIPE, Process
from collections.abc import AsyncIterator
from dataclasses import asdict
from pathlib import Path

from sjdsl.studio.seats import Seats

LONGEST_LINE = 64 * 2**20  # bytes of one answer
# Seconds that a request may take. Tests of checks take long, and so does a long counterexample.
SECONDS = {"panel": 120.0, "replay": 120.0, "step": 60.0}
SEATED = 3600.0  # seconds that a step may take with seats: policies load, and models think
ANY = 20.0  # seconds that any other request may take
START = 90.0  # seconds that Python and the compiler may take to load
LATER = 10.0  # seconds after which a process that a page has taken is replaced


class Child:
    """A worker process; it is started again when it has ended.

    folder: of the games; seats: who plays one of them.
    """

    def __init__(self, folder: Path, seats: Seats | None = None) -> None:
        self._folder = folder
        self._seats = seats
        self._process: Process | None = None
        self._turn = asyncio.Lock()

    async def ask(self, request: str) -> str:
        """Returns the answer to a request, both as JSON.

        A request that takes too long, or ends the process, is refused with the reason.
        """
        async with self._turn:
            asked = part_of(request, "do")
            limit = SECONDS.get(asked, ANY)
            if self._seats is not None and asked == "step":
                limit = SEATED
            try:
                process = self._process or await self._start()
                assert process.stdin is not None
                assert process.stdout is not None
                process.stdin.write(request.replace("\n", " ").encode() + b"\n")
                await process.stdin.drain()
                line = await asyncio.wait_for(process.stdout.readline(), limit)
            except TimeoutError:
                await self.stop()
                reason = f"this took more than {limit:.0f} seconds and was stopped"
                return _lost_answer(request, reason)
            except (ConnectionError, ValueError):
                line = b""
            if not line:
                await self.stop()
                reason = (
                    "the process that plays the game ended; it starts again with the next change"
                )
                return _lost_answer(request, reason)
            return line.decode()

    async def begin(self) -> None:
        """Starts the process ahead of the first request, which tries again if this fails."""
        async with self._turn:
            if self._process is None:
                with contextlib.suppress(TimeoutError, OSError):
                    await self._start()

    async def stop(self) -> None:
        """Ends the process; the next request starts another."""
        process = self._process
        self._process = None
        if process is not None and process.returncode is None:
            process.kill()
            await process.wait()

    async def _start(self) -> Process:
        """Starts the process and waits until it has loaded. Raises TimeoutError."""
        command = [sys.executable, "-m", "sjdsl.studio.worker", str(self._folder)]
        if self._seats is not None:
            command.append(json.dumps(asdict(self._seats)))
        self._process = await asyncio.create_subprocess_exec(
            *command, stdin=PIPE, stdout=PIPE, limit=LONGEST_LINE
        )
        assert self._process.stdout is not None
        await asyncio.wait_for(self._process.stdout.readline(), START)  # until it has loaded
        return self._process


class Spares:
    """Processes that are started before a page needs them, as the compiler takes long to load.

    number: of processes that wait; a page takes two. seats: who plays one of the games.
    """

    def __init__(self, folder: Path, number: int = 2, seats: Seats | None = None) -> None:
        self._folder = folder
        self._seats = seats
        self._number = number
        self._waiting: list[Child] = []
        self._filling: set[asyncio.Task[None]] = set()
        self._is_open = False

    def take(self) -> Child:
        """Returns a process for a page. Another one starts later, when the page has been served."""
        child = self._waiting.pop(0) if self._waiting else Child(self._folder, self._seats)
        self._begin_to_fill(LATER)
        return child

    @contextlib.asynccontextmanager
    async def kept(self) -> AsyncIterator[None]:
        """Keeps processes waiting as long as the server runs."""
        self._is_open = True
        self._begin_to_fill(0.0)
        try:
            yield
        finally:
            self._is_open = False
            for task in self._filling:
                task.cancel()
            for child in self._waiting:
                await child.stop()

    def _begin_to_fill(self, seconds: float) -> None:
        """Starts a task that fills up the waiting processes later, unless there is one already."""
        if self._is_open and not self._filling:
            task = asyncio.create_task(self._fill_after(seconds))
            self._filling.add(task)
            task.add_done_callback(self._filling.discard)

    async def _fill_after(self, seconds: float) -> None:
        await asyncio.sleep(seconds)
        number = self._number - len(self._waiting)
        missing = [Child(self._folder, self._seats) for _ in range(number)]
        self._waiting += missing
        await asyncio.gather(*(child.begin() for child in missing))


def part_of(request: str, name: str) -> str:
    """Returns a field of a request as text, "" if there is none or it isn't a JSON object."""
    try:
        return str(json.loads(request)[name])
    except (ValueError, KeyError, TypeError, RecursionError):
        return ""


def number_of(request: str) -> int:
    """Returns the `id` of a request, 0 without one."""
    number = part_of(request, "id")
    return int(number) if number.isdecimal() else 0


def _lost_answer(request: str, reason: str) -> str:
    """Returns an answer in place of the process. `lost`: the page has to open its text again."""
    return json.dumps(
        {"id": number_of(request), "do": part_of(request, "do"), "refused": reason, "lost": True}
    )
