"""Measures whether a stopped and resumed training run ends bit for bit like one that was not stopped."""

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sjdsl.bench.machine import describe_machine

DETERMINISTIC = "--xla_gpu_deterministic_ops=true"
OF_THE_CLOCK = frozenset({"seconds", "steps_per_second", "rollout_share"})  # columns of the metrics that no two runs share
SETTINGS = ("total_timesteps=327680", "num_envs=64", "num_steps=128", "evaluate_every=0")  # 40 updates
UPDATES = 40
PATIENCE = 300.0  # seconds until a run is given up


@dataclass(frozen=True)
class Resume:
    """A run of `updates` updates that was stopped after `stopped_after` of them and resumed, beside one that was never stopped.

    `different`: what of the two is not the same, bit for bit: metrics by their column, policies by their file. Nothing: the same.
    """

    machine: dict[str, Any]
    name: str
    updates: int
    stopped_after: int
    flags: str
    different: tuple[str, ...]
    seconds: float


def measure_resume(name: str, tell: Callable[[str], object] = lambda _: None, settings: Sequence[str] = SETTINGS) -> Resume:
    """Trains a game twice with the command line, once stopped half-way by Ctrl-C and resumed, and compares the ends.

    The runs are processes of their own: the flag for deterministic operations has to be set before JAX starts.

    Args:
      name: a bundled game, or a file.
      tell: called with a line whenever a run begins.
      settings: of both runs, as `--set` takes them; they make `UPDATES` updates. The network is the default one, with convolutions.
    Raises RuntimeError where a run fails, or ends before it can be stopped.
    """
    began = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        whole, stopped = Path(folder) / "whole", Path(folder) / "stopped"
        tell("training without a stop")
        _finish(_start(name, whole, settings))
        tell("training with a stop")
        process = _start(name, stopped, settings)
        _wait_for(process, stopped, UPDATES // 2)
        process.send_signal(signal.SIGINT)
        process.wait(PATIENCE)
        stopped_after = len(_rows(stopped))
        if stopped_after >= UPDATES:
            raise RuntimeError("the run ended before it could be stopped")
        tell(f"resuming after update {stopped_after}")
        _finish(_command("train", "--resume", str(stopped)))
        seconds = time.perf_counter() - began
        return Resume(describe_machine(), name, UPDATES, stopped_after, DETERMINISTIC, differences(whole, stopped), seconds)


def differences(whole: Path, resumed: Path) -> tuple[str, ...]:
    """Returns what of two run folders is not the same: columns of the metrics that do not depend on the clock, and policies."""
    rows, others = _rows(whole), _rows(resumed)
    found = [] if len(rows) == len(others) else [f"{len(rows)} and {len(others)} rows of metrics"]
    columns = sorted(set().union(*rows, *others) - OF_THE_CLOCK)
    found += [column for column in columns if [row.get(column) for row in rows] != [row.get(column) for row in others]]
    policies, of_other = _policies(whole), _policies(resumed)
    return (*found, *(name for name in sorted(policies.keys() | of_other.keys()) if policies.get(name) != of_other.get(name)))


def _rows(run: Path) -> list[dict[str, Any]]:
    """Returns the rows of metrics that are written whole."""
    path = run / "metrics.jsonl"
    text = path.read_text(encoding="utf-8") if path.exists() else ""
    return [json.loads(line) for line in text[: text.rfind("\n") + 1].splitlines()]


def _policies(run: Path) -> Mapping[str, bytes]:
    """Returns the policies of a run by their file, as bytes."""
    return {path.relative_to(run).as_posix(): path.read_bytes() for path in run.rglob("*.safetensors")}


def _start(name: str, run: Path, settings: Sequence[str]) -> "subprocess.Popen[str]":
    options = [word for setting in settings for word in ("--set", setting)]
    return _command("train", name, "--algorithm", "ippo", "--episodes", "0", "--run", str(run), *options)


def _command(*arguments: str) -> "subprocess.Popen[str]":
    """Starts `sjdsl` with deterministic operations, in a part of the device's memory: this process may hold the rest."""
    flags = f"{os.environ.get('XLA_FLAGS', '')} {DETERMINISTIC}".strip()
    environment = os.environ | {"XLA_FLAGS": flags, "XLA_PYTHON_CLIENT_MEM_FRACTION": "0.1"}
    return subprocess.Popen(
        [sys.executable, "-m", "sjdsl", *arguments], env=environment, text=True, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    )


def _finish(process: "subprocess.Popen[str]") -> None:
    """Waits for the end of a process. Raises RuntimeError with its last line where it failed or took too long."""
    try:
        _, said = process.communicate(timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        process.kill()
        raise RuntimeError(f"a training run took more than {PATIENCE:.0f} seconds") from None
    if process.returncode != 0:
        raise RuntimeError(f"a training run failed: {(said.strip().splitlines() or ['it said nothing'])[-1]}")


def _wait_for(process: "subprocess.Popen[str]", run: Path, updates: int) -> None:
    """Waits until a run has done `updates` updates, or is over."""
    deadline = time.monotonic() + PATIENCE
    while process.poll() is None and len(_rows(run)) < updates:
        if time.monotonic() > deadline:
            process.kill()
            raise RuntimeError(f"a training run did not do {updates} updates in {PATIENCE:.0f} seconds")
        time.sleep(0.02)
