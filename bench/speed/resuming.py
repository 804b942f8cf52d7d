"""Measures whether a stopped and resumed training run ends bit for bit like one that was not stopped."""

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
OF_THE_CLOCK = frozenset(
    {"seconds", "steps_per_second", "rollout_share"}
)  # columns of the metrics that no two runs share
UPDATES = 40
SETTINGS = {
    "total_timesteps": UPDATES * 64 * 128,
    "num_envs": 64,
    "num_steps": 128,
    "evaluate_every": 0,
}  # of the network with convolutions
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


def measure_resume(name: str) -> Resume:
    """Trains a game twice, once stopped half-way and resumed, and compares the ends.

    Each run is a process of its own: the flag for deterministic operations has to be set before JAX starts.

    Args:
      name: a bundled game, or a file.
    Raises RuntimeError where a run fails, TimeoutExpired where it takes too long.
    """
    began = time.perf_counter()
    flags = f"{os.environ.get('XLA_FLAGS', '')} {DETERMINISTIC}".strip()
    environment = os.environ | {
        "XLA_FLAGS": flags,
        "XLA_PYTHON_CLIENT_MEM_FRACTION": "0.1",
    }  # this process may hold the other memory
    with tempfile.TemporaryDirectory() as folder:
        whole, stopped = Path(folder) / "whole", Path(folder) / "stopped"
        for run, way in ((whole, "train"), (stopped, "stop"), (stopped, "resume")):
            asked = [sys.executable, "-m", "bench.speed.resuming", name, str(run), way]
            ended = subprocess.run(
                asked,
                env=environment,
                text=True,
                capture_output=True,
                timeout=PATIENCE,
                check=False,
            )
            if ended.returncode != 0:
                raise RuntimeError(
                    f"to {way} failed: {(ended.stderr.strip().splitlines() or ['it said nothing'])[-1]}"
                )
        different, seconds = differences(whole, stopped), time.perf_counter() - began
    return Resume(
        describe_machine(), name, UPDATES, UPDATES // 2, DETERMINISTIC, different, seconds
    )


def differences(whole: Path, resumed: Path) -> tuple[str, ...]:
    """Returns what of two run folders is not the same: columns of the metrics that do not depend on the clock, and policies."""
    rows, others = (
        [json.loads(line) for line in (run / "metrics.jsonl").read_text("utf-8").splitlines()]
        for run in (whole, resumed)
    )
    found = [] if len(rows) == len(others) else [f"{len(rows)} and {len(others)} rows of metrics"]
    columns = sorted(set().union(*rows, *others) - OF_THE_CLOCK)
    found += [
        column
        for column in columns
        if [row.get(column) for row in rows] != [row.get(column) for row in others]
    ]
    policies, of_other = (
        {path.relative_to(run).as_posix(): path.read_bytes() for path in run.rglob("*.safetensors")}
        for run in (whole, resumed)
    )
    return (
        *found,
        *(
            name
            for name in sorted(policies.keys() | of_other.keys())
            if policies.get(name) != of_other.get(name)
        ),
    )


def train_in_this_process(name: str, run: str, way: str) -> None:
    """Trains a game (`train`), only half of it (`stop`), or the rest of that (`resume`)."""
    from sjdsl import make
    from sjdsl.trainers import make_config, resume, train

    env = make(name)
    if way == "resume":
        resume(env, run, progress="none")
    else:
        train(
            env,
            make_config(SETTINGS),
            run,
            progress="none",
            callback=lambda update: way == "stop" and update.number == UPDATES // 2,
        )


if __name__ == "__main__":
    train_in_this_process(*sys.argv[1:])
