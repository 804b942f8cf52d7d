"""Claims: which process runs a cell, as files that each one process alone can create, with a heartbeat.

The first claim of a cell is the file `NAME@0.json`, the next `NAME@1.json`, and so on; the last one counts. A claim ends when its
process releases it, or has died, or its heartbeat has stopped. Then a process takes over by creating the next file: of several that
try, the system lets one succeed, also on a shared file system. No file is ever removed, so that no claim can be mistaken for another.
"""

import json
import os
import socket
import sys
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

import psutil

from sjdsl.files import naming, read_json, write_whole

CLAIMS = "claims"
BEAT = 15.0  # seconds between two beats
LINUX = sys.platform == "linux"
STARTED = 19  # field of /proc/PID/stat behind the name, from 0. Source: proc(5), starttime
STALE = 180.0  # seconds without a beat, after which another machine's claim is taken over: more than file systems cache for


class Claim:
    """A cell that this process runs, until it is released."""

    def __init__(self, path: Path, content: Mapping[str, Any]) -> None:
        self.path = path
        self._content = content
        self._stop = threading.Event()
        self._beats = threading.Thread(target=self._beat, daemon=True, name=f"heartbeat of {path.stem}")
        self._beats.start()

    @property
    def is_lost(self) -> bool:
        """Whether another process has taken over, for this one was suspended for long."""
        return _next(self.path).exists()

    def release(self) -> None:
        """Lets other processes have the cell."""
        self._stop.set()
        self._beats.join()
        with suppress(OSError):  # on a full disk the claim ends with the process, or with its heartbeat
            write_whole(self.path, json.dumps({**self._content, "released": True}).encode())

    def _beat(self) -> None:
        while not self._stop.wait(BEAT):
            with suppress(OSError):  # the next beat may reach a file system that this one did not
                os.utime(self.path)


@dataclass(frozen=True)
class Holder:
    """Who runs a cell."""

    host: str
    pid: int


def take(folder: Path, name: str) -> Claim | None:
    """Returns the claim of a cell; None where another process has it.

    Args:
      folder: of the sweep.
    """
    claims = folder / CLAIMS
    claims.mkdir(exist_ok=True)
    last = _last(claims, name)
    if last is not None and _is_held(last):
        return None
    path = claims / f"{name}@0.json" if last is None else _next(last)
    content = {**_this_process(), "since": time.time()}
    with naming(path):
        try:
            file = open(path, "x", encoding="utf-8")  # noqa: SIM115 (it may be there)
        except FileExistsError:
            return None
        with file:
            file.write(json.dumps(content))
    return Claim(path, content)


def holder_of(folder: Path, name: str) -> Holder | None:
    """Returns who runs a cell now; None where nobody does."""
    last = _last(folder / CLAIMS, name)
    if last is None or not _is_held(last):
        return None
    return _holder(_read(last))


def left_by(folder: Path, name: str) -> Holder | None:
    """Returns who ran a cell and died without releasing it; None where the last one released it, or runs it still."""
    last = _last(folder / CLAIMS, name)
    content = {} if last is None else _read(last)
    if last is None or content.get("released") or _is_held(last):
        return None
    return _holder(content)


def _holder(content: Mapping[str, Any]) -> Holder:
    pid = content.get("pid")
    return Holder(str(content.get("host", "?")), pid if isinstance(pid, int) else 0)


def _last(claims: Path, name: str) -> Path | None:
    found = [path for path in claims.glob(f"{name}@*.json") if _number(path) is not None]
    return max(found, key=lambda path: _number(path) or 0, default=None)


def _number(path: Path) -> int | None:
    number = path.stem.rpartition("@")[2]
    return int(number) if number.isdecimal() else None


def _next(path: Path) -> Path:
    name, _, number = path.stem.rpartition("@")
    return path.with_name(f"{name}@{int(number) + 1}.json")


def _is_held(path: Path) -> bool:
    """Whether the process of a claim still runs its cell.

    Of a process of this machine the system knows; of others, and where a claim does not say of which process it is, the heartbeat tells,
    by the clock of the file system.
    """
    content = _read(path)
    if content.get("released"):
        return False
    pid, started = content.get("pid"), content.get("started")
    if content.get("machine") == _machine() and isinstance(pid, int) and isinstance(started, int | float):
        return _started(pid) == started
    try:
        return _clock(path.parent) - path.stat().st_mtime < STALE
    except OSError:
        return True


def _started(pid: int) -> float | None:
    """Returns when a process was started, by a clock that nobody sets; None where there is none of that number, or it has ended."""
    try:
        process = psutil.Process(pid)
        if process.status() == psutil.STATUS_ZOMBIE:
            return None
        if LINUX:  # in ticks since the machine was started: the time of day would move with the clock
            return int(Path(f"/proc/{pid}/stat").read_text("utf-8", errors="replace").rpartition(")")[2].split()[STARTED])
        return float(process.create_time())
    except (psutil.Error, OSError):
        return None


def _clock(folder: Path) -> float:
    """Returns the time as the file system has it, for machines' clocks differ."""
    with TemporaryFile(dir=folder) as probe:
        return os.fstat(probe.fileno()).st_mtime


def _read(path: Path) -> dict[str, Any]:
    try:
        found = read_json(path)
    except (OSError, ValueError):  # it is being written
        return {}
    return found if isinstance(found, dict) else {}


def _this_process() -> dict[str, Any]:
    pid = os.getpid()
    return {"machine": _machine(), "host": socket.gethostname(), "pid": pid, "started": _started(pid)}


@cache
def _machine() -> str:
    """Returns what tells whether a number of a process is one of this machine: since it was started, and in which container."""
    known = [socket.gethostname()]
    try:
        known += [Path("/proc/sys/kernel/random/boot_id").read_text("ascii").strip(), os.readlink("/proc/self/ns/pid")]
    except OSError:  # not Linux
        known.append(str(int(psutil.boot_time())))
    return " ".join(known)
