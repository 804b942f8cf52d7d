"""Calls of models: how many at once, what stops them, and that the same command goes on."""

import errno
import json
import os
import signal
import subprocess
import sys
import threading
import time
from itertools import count
from pathlib import Path
from typing import Any

import pytest
from command_line import INTERRUPTIBLE, Sjdsl
from luna import CALLS, MATRIX, SCHELLING, VISITORS, by_role, write_models

from tests.models.folders import recorded_calls, timeless
from tests.models.server import Server

KEEPS = '{"why": "", "goal": "", "note": {"op": "none"}, "action": "keep"}'


def test_so_many_calls_at_once(folder: Path, sjdsl: Sjdsl, server: Server) -> None:
    """At most as many as asked for, and the results are those of one after the other."""
    lock = threading.Lock()
    running = 0
    most = 0

    def counted(body: dict[str, Any]) -> str:
        nonlocal running, most
        with lock:
            running += 1
            most = max(most, running)
        time.sleep(0.05)
        with lock:
            running -= 1
        return by_role(body)

    server.reply = counted
    slots = ("--slots", "models.toml:luna+defector,models.toml:luna+cooperator")
    at_once = {}
    for parallel in (1, 3):
        most = 0
        limits = ("--parallel", str(parallel), "-o", f"at_{parallel}")
        shown = sjdsl("crossplay", MATRIX, *slots, "--episodes", "4", *limits)
        assert shown.status == 0, shown.text
        at_once[parallel] = most
    assert at_once[1] == 1
    assert 1 < at_once[3] <= 3
    assert timeless(folder / "at_1") == timeless(folder / "at_3")


@pytest.mark.parametrize(
    "number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.thorough)]
)
def test_a_signal_loses_only_calls_under_way(
    number: signal.Signals, folder: Path, sjdsl: Sjdsl, server: Server
) -> None:
    assert sjdsl(*SCHELLING).status == 0
    (folder / "out").rename(folder / "whole")
    server.requests.clear()
    numbers = count(1)
    stopped = threading.Event()

    def reply(body: dict[str, Any]) -> str:
        if next(numbers) > 9:
            stopped.wait(60)
        return by_role(body)

    server.reply = reply
    process = subprocess.Popen(
        [sys.executable, "-c", INTERRUPTIBLE, *SCHELLING, "--parallel", "2"],
        cwd=folder,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        env={**os.environ, "JAX_PLATFORMS": "cpu"},
    )
    while process.poll() is None and len(server.requests) < 11:
        time.sleep(0.01)
    os.killpg(process.pid, number)
    _, said = process.communicate(timeout=60)
    assert (process.returncode, said.splitlines()[-1]) == (128 + number, "interrupted")
    stopped.set()
    assert recorded_calls(folder / "out") == 9
    (used,) = json.loads((folder / "out/talks/usage.json").read_text())
    assert used["calls"] == 9
    unanswered = folder / "out/talks/unanswered.json"
    assert json.loads(unanswered.read_text())["calls"] == 2
    assert "9 calls, of at most 48, and up to $" in sjdsl(*SCHELLING, "--status").out
    server.reply = by_role
    assert sjdsl(*SCHELLING).status == 0
    assert len(server.requests) == 11 + CALLS - 9
    unanswered.unlink()
    assert timeless(folder / "out") == timeless(folder / "whole")


def test_a_full_disk_stops_it(
    folder: Path, sjdsl: Sjdsl, server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No message follows a reply that isn't on disk, and the same command asks for it again."""
    assert sjdsl(*SCHELLING).status == 0
    (folder / "out").rename(folder / "whole")
    server.requests.clear()

    def full(file: int) -> None:
        """Loses the end of whatever is written, once six replies are on disk."""
        if len(server.requests) > 6:
            os.ftruncate(file, os.fstat(file).st_size - 9)
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patched:
        patched.setattr("os.fsync", full)
        stopped = sjdsl(*SCHELLING, "--parallel", "1")
    assert stopped.status == 1
    assert "agent_0.jsonl: no space left on device. A reply is acted on once" in stopped.err
    assert "the same command goes on" in stopped.err
    assert recorded_calls(folder / "out") == 6
    assert len(server.requests) == 7
    assert sjdsl(*SCHELLING).status == 0
    assert len(server.requests) == 7 + CALLS - 6
    assert timeless(folder / "out") == timeless(folder / "whole")


def test_another_model_does_not_go_on(folder: Path, sjdsl: Sjdsl, server: Server) -> None:
    """Neither if the file names another one, nor if the server does, whose reply isn't kept."""
    assert sjdsl(*SCHELLING, "--calls", "7").status == 3
    write_models(folder, server.url, model="m2")
    refused = sjdsl(*SCHELLING)
    assert refused.status == 1
    assert "out holds another experiment: its policies differ" in refused.err
    assert len(server.requests) == 7
    write_models(folder, server.url)
    server.model = "luna-2027"
    refused = sjdsl(*SCHELLING)
    assert refused.status == 1
    assert "the server of luna says now that its model is `luna-2027`, and earlier" in refused.err
    assert len(server.requests) == 8
    assert recorded_calls(folder / "out") == 7
    server.model = "luna-2026"
    assert sjdsl(*SCHELLING).status == 0
    assert recorded_calls(folder / "out") == CALLS


def test_calls_of_all_commands_in_a_folder_count(
    folder: Path, sjdsl: Sjdsl, server: Server
) -> None:
    """Scenarios played one by one are added up, in what is reported and against limits."""
    server.reply = lambda _: KEEPS
    command = ("evaluate", "models.toml:luna", "--game", VISITORS, "--episodes", "2", "-o", "out")
    assert sjdsl(*command, "--scenario", "alone").status == 0
    assert len(server.requests) == 12
    shown = sjdsl(*command, "--scenario", "visitor")
    assert "luna: 16 calls, 0 of them" in shown.out
    (used,) = json.loads((folder / "out/scenarios/talks/usage.json").read_text())
    assert (used["model"], used["calls"], used["input"]) == ("luna", 16, 1600)
    stored = json.loads((folder / "out/scenarios.json").read_text())
    assert stored["models"]["luna"]["calls"] == 16
    stopped = sjdsl(*command, "--scenario", "intruded", "--calls", "18")
    assert stopped.status == 3
    assert "18 calls were made, and at most 18 may be" in stopped.err
    assert len(server.requests) == 18
