"""A worker process seen from the server: one request at a time, each with a time limit, started again when it is over."""

import asyncio
import json
import sys
from asyncio.subprocess import PIPE, Process
from pathlib import Path

LONGEST_LINE = 64 * 2**20  # bytes of one answer
SECONDS = {"panel": 120.0}  # that a request may take; checks are played for a long time
ANY = 20.0
START = 90.0  # that Python and the compiler may take to load


class Child:
    """A worker process. `folder`: in which games are opened."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._process: Process | None = None
        self._turn = asyncio.Lock()

    async def ask(self, request: str) -> str:
        """Returns the answer to a request, both as JSON. One that takes too long, or breaks the process, is refused with the reason."""
        async with self._turn:
            limit = SECONDS.get(_part(request, "do"), ANY)
            try:
                process = self._process or await self._start()
                assert process.stdin is not None
                assert process.stdout is not None
                process.stdin.write(request.replace("\n", " ").encode() + b"\n")
                await process.stdin.drain()
                line = await asyncio.wait_for(process.stdout.readline(), limit)
            except TimeoutError:
                await self.stop()
                return _lost(request, f"this took more than {limit:.0f} seconds and was stopped")
            except (ConnectionError, ValueError):
                line = b""
            if not line:
                await self.stop()
                return _lost(request, "the process that plays the game ended; it starts again with the next change")
            return line.decode()

    async def stop(self) -> None:
        """Ends the process; the next request starts another."""
        process, self._process = self._process, None
        if process is not None and process.returncode is None:
            process.kill()
            await process.wait()

    async def _start(self) -> Process:
        module = "sjdsl.studio.worker"
        self._process = await asyncio.create_subprocess_exec(
            sys.executable, "-m", module, str(self._folder), stdin=PIPE, stdout=PIPE, limit=LONGEST_LINE
        )
        assert self._process.stdout is not None
        await asyncio.wait_for(self._process.stdout.readline(), START)  # it has loaded
        return self._process


def _part(request: str, name: str) -> str:
    try:
        return str(json.loads(request)[name])
    except (ValueError, KeyError, TypeError):
        return ""


def _lost(request: str, reason: str) -> str:
    """Returns the answer for a request that has none; `lost`: the page has to open its text again."""
    number = _part(request, "id")
    return json.dumps({"id": int(number) if number.isdecimal() else 0, "do": _part(request, "do"), "refused": reason, "lost": True})
