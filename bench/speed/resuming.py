"""Measures whether a stopped and resumed training run ends bit for bit like one that was not
stopped.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sjdsl.bench.machine import describe_machine

DETERMINISTIC = "--xla_gpu_deterministic_ops=true"
# Columns of the metrics that differ between any two runs.
OF_THE_CLOCK = frozenset({"seconds", "steps_per_second", "rollout_share"})
UPDATES = 40
# With the default network, which has convolutions.
SETTINGS = {
    "total_timesteps": UPDATES * 64 * 128,
    "num_envs": 64,
    "num_steps": 128,
    "evaluate_every": 0,
}
PATIENCE = 300.0  # seconds until a run is given up


@dataclass(frozen=True)
class Resume:
    """A run of `updates` updates that was stopped after `stopped_after` of them and resumed, beside
    one that was never stopped."""

    machine: dict[str, Any]
    name: str
    updates: int
    stopped_after: int
    flags: str
    # Columns of the metrics and files of policies that aren't equal, bit for bit.
    different: tuple[str, ...]
    seconds: float


def measure_resume(name: str) -> Resume:
    """Trains a game twice, once stopped half-way and resumed, and compares the ends.

    Each run is a process of its own: the flag for deterministic operations has to be set before JAX
    starts.

    Args:
      name: a bundled game, or a file.
    Raises:
      RuntimeError: a run fails. TimeoutExpired: it takes too long.
    """
    start = time.perf_counter()
    environment = dict(os.environ)
    environment["XLA_FLAGS"] = f"{os.environ.get('XLA_FLAGS', '')} {DETERMINISTIC}".strip()
    # This process may hold the other memory.
    environment["XLA_PYTHON_CLIENT_MEM_FRACTION"] = "0.1"
    with tempfile.TemporaryDirectory() as folder:
        whole = Path(folder) / "whole"
        stopped = Path(folder) / "stopped"
        for run, task in ((whole, "train"), (stopped, "stop"), (stopped, "resume")):
            process = subprocess.run(
                [sys.executable, "-m", "bench.speed.resuming", name, str(run), task],
                env=environment,
                text=True,
                capture_output=True,
                timeout=PATIENCE,
                check=False,
            )
            if process.returncode != 0:
                lines = process.stderr.strip().splitlines() or ["it said nothing"]
                raise RuntimeError(f"to {task} failed: {lines[-1]}")
        different = differences(whole, stopped)
    seconds = time.perf_counter() - start
    return Resume(
        describe_machine(), name, UPDATES, UPDATES // 2, DETERMINISTIC, different, seconds
    )


def differences(whole: Path, resumed: Path) -> tuple[str, ...]:
    """Returns the columns of the metrics, but for those of the clock, and the policies that aren't
    equal in two folders of runs."""
    rows = _read_metrics(whole)
    other_rows = _read_metrics(resumed)
    different = []
    if len(rows) != len(other_rows):
        different.append(f"{len(rows)} and {len(other_rows)} rows of metrics")
    for column in sorted(set().union(*rows, *other_rows) - OF_THE_CLOCK):
        if [row.get(column) for row in rows] != [row.get(column) for row in other_rows]:
            different.append(column)
    policies = _read_policies(whole)
    other_policies = _read_policies(resumed)
    for name in sorted(policies.keys() | other_policies.keys()):
        if policies.get(name) != other_policies.get(name):
            different.append(name)
    return tuple(different)


def _read_metrics(run: Path) -> list[dict[str, Any]]:
    lines = (run / "metrics.jsonl").read_text("utf-8").splitlines()
    return [json.loads(line) for line in lines]


def _read_policies(run: Path) -> dict[str, bytes]:
    files = run.rglob("*.safetensors")
    return {path.relative_to(run).as_posix(): path.read_bytes() for path in files}


def train_in_this_process(name: str, run: str, task: str) -> None:
    """Trains a game (`train`), only half of it (`stop`), or the rest of that (`resume`)."""
    from sjdsl import make
    from sjdsl.trainers import make_config, resume, train

    env = make(name)
    if task == "resume":
        resume(env, run, progress="none")
    else:
        train(
            env,
            make_config(SETTINGS),
            run,
            progress="none",
            callback=lambda update: task == "stop" and update.number == UPDATES // 2,
        )


if __name__ == "__main__":
    train_in_this_process(*sys.argv[1:])
