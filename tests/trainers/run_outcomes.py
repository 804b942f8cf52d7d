"""What tests of runs share: a run that learns nothing, and what must be the same however often a run was stopped."""

import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import flax
import jax
import jax.numpy as jnp
import pytest
from probes import QUICK, matching

from sjdsl.trainers import Config, Train, TrainState, make_config, make_train
from sjdsl.trainers.runs import recorder, run
from sjdsl.trainers.runs.compiled import Compiled, compile_train

OF_THE_CLOCK = ("seconds", "steps_per_second", "rollout_share")

# Twelve updates of 64 steps, with a checkpoint and a policy after every second and an evaluation after every third.
SHORT = make_config(
    {
        **QUICK,
        "num_envs": 8,
        "num_steps": 8,
        "total_timesteps": 64 * 12,
        "checkpoint_updates": 2,
        "policy_every": 2,
        "evaluate_every": 3,
    },
    normalise_values=True,
    evaluation_episodes=8,
    seed=5,
)


@flax.struct.dataclass
class Worlds:
    """The worlds of a run without any."""

    steps: jax.Array  # [2] int32


def counting(diverges_after: int = 1_000_000, seed_that_diverges: int | None = 0) -> Train:
    """Returns a run that learns nothing and compiles at once; its parameter counts the updates. Keys are those of seeds; None: all diverge."""

    def init(key: jax.Array) -> TrainState:
        return TrainState(
            key,
            {"updates": jnp.zeros(())},
            Worlds(jnp.zeros(2, jnp.int32)),
            jnp.int32(0),
            jnp.bool_(False),
        )

    def collect(state: TrainState) -> tuple[TrainState, Any]:
        return state.replace(worlds=Worlds(state.worlds.steps + 1)), state.worlds.steps.sum()

    def learn(state: TrainState, played: Any) -> tuple[TrainState, dict[str, jax.Array]]:
        updates = state.updates + 1
        seed = jax.random.key_data(state.key)[1]
        bad = state.diverged | (updates > diverges_after) & (
            (seed == seed_that_diverges) if seed_that_diverges is not None else True
        )
        good = jnp.where(bad, state.learner["updates"], updates.astype(jnp.float32))
        metrics = {
            "episodes": updates,
            "collective_return": jnp.float32(2),
            "agent_return": jnp.ones(2),
            "loss": jnp.where(bad, jnp.nan, 1.0),
            "played": played,
        }
        return state.replace(learner={"updates": good}, updates=updates, diverged=bad), metrics

    return Train(init, collect, learn, lambda state: state.learner)


def read_manifest(run_dir: Path) -> dict[str, Any]:
    return json.loads((run_dir / "manifest.json").read_text())


def read_lines(path: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in path.read_text().splitlines()]


def outcome(folder: Path) -> dict[str, Any]:
    """Returns what a seed of a run came to, without what depends on the clock; policies as their bytes."""
    metrics = read_lines(folder / "metrics.jsonl")
    evaluations = folder / "evaluations.jsonl"
    return {
        "metrics": [
            {name: value for name, value in row.items() if name not in OF_THE_CLOCK}
            for row in metrics
        ],
        "columns": list(metrics[0]),
        "evaluations": read_lines(evaluations) if evaluations.exists() else [],
        "policies": {
            path.name: path.read_bytes() for path in sorted((folder / "policies").iterdir())
        },
    }


def assert_same_end(folder: Path, other: Path) -> None:
    """Checks that two runs came to the same, bit for bit."""
    left, right = outcome(folder), outcome(other)
    assert left["metrics"] == right["metrics"]
    assert left["evaluations"] == right["evaluations"]
    assert left["policies"].keys() == right["policies"].keys()
    for name, content in left["policies"].items():
        assert content == right["policies"][name], name
    assert left == right


@contextmanager
def compiled_once() -> Iterator[None]:
    """Has all runs of `matching` share what is compiled: only that makes a hundred of them quick. Configurations: `SHORT`, or how often
    it saves and evaluates changed."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            run,
            "compile_train",
            lambda _, config, __: compiled_matching(config.model_copy(update=_ALIKE)),
        )
        patch.setattr(recorder, "make_evaluator", lambda _, __, number: _evaluator(number))
        yield


_ALIKE = {"checkpoint_updates": 2, "policy_every": 2, "evaluate_every": 3}


@cache
def compiled_matching(config: Config) -> Compiled:
    """Returns the program of a run of `matching`, compiled once however many runs there are."""
    return compile_train(make_train(matching(), config), config)


@cache
def _evaluator(number: int) -> Callable[..., Any]:
    from sjdsl.trainers.policies.evaluation import make_evaluator
    from sjdsl.trainers.policies.loading import trained_policy

    return make_evaluator(
        matching(), lambda parameters: trained_policy(matching(), SHORT, parameters), number
    )


def copy_run(source: Path, target: Path) -> Path:
    """Copies the folder of a run as it is now: as a process that is killed now leaves it."""
    shutil.copytree(source, target)
    return target


# The command line in processes of its own.

ORCHARD = (
    "num_envs=4",
    "num_steps=4",
    "num_minibatches=2",
    "num_epochs=1",
    "network=mlp",
    "network_width=8",
)
TWELVE = (
    "total_timesteps=192",
    "checkpoint_updates=2",
    "policy_every=2",
    "evaluate_every=3",
    "evaluation_episodes=4",
)
VALUES = (
    "num_envs=4",
    "num_steps=4",
    "network=mlp",
    "network_width=8",
    "buffer_size=64",
    "batch_size=8",
    "learning_starts=32",
)


def sets(*assignments: str) -> list[str]:
    """Returns `--set` before each."""
    return [part for text in assignments for part in ("--set", text)]


def start_sjdsl(*arguments: str | Path, **variables: str) -> subprocess.Popen[str]:
    """Starts the command line in a process; what is compiled is shared with the other tests' processes."""
    environment = {
        **os.environ,
        "JAX_PLATFORMS": "cpu",
        "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0",
    }
    environment |= {"JAX_DISABLE_MOST_OPTIMIZATIONS": "true", **variables}
    command = [sys.executable, "-m", "sjdsl", *(str(argument) for argument in arguments)]
    return subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def run_sjdsl(*arguments: str | Path, **variables: str) -> str:
    """Runs the command line in a process to its end; returns what it printed."""
    process = start_sjdsl(*arguments, **variables)
    out, err = process.communicate(timeout=400)
    assert process.returncode == 0, err[-3000:]
    return out + err


def wait_for_rows(run_dir: Path, number: int, process: subprocess.Popen[str]) -> None:
    """Waits until a run's metrics have so many rows, or its process has ended."""
    until = time.monotonic() + 300
    lines = run_dir / "metrics.jsonl"
    while process.poll() is None and not (
        lines.exists() and lines.read_bytes().count(b"\n") >= number
    ):
        assert time.monotonic() < until, "nothing was written"
        time.sleep(0.001)
