"""More than one device, and more than one process: the run is the same.

Draws are the same to the bit. Losses and gradients are means over environments: over several devices each adds up its own, and the parts
are added then. Float sums depend on their order, so the last digits differ, and a few updates carry that on: a thousandth is far more than
they come to.
"""

import socket
from pathlib import Path
from typing import Any

import jax
import pytest
from run_outcomes import (
    OF_THE_CLOCK,
    ORCHARD,
    assert_same_end,
    copy_run,
    read_lines,
    read_manifest,
    run_sjdsl,
    sets,
    start_sjdsl,
)

from sjdsl.trainers import ConfigError, PPOConfig, make_config
from sjdsl.trainers.algorithms import ppo
from sjdsl.trainers.runs import sharding
from tests.cli.command_line import GAME

TWO = "--xla_force_host_platform_device_count=2"
ONE = "--xla_force_host_platform_device_count=1"


def test_environments_must_divide_into_devices(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sharding.jax, "devices", lambda: [*jax.local_devices()] * 3)
    with pytest.raises(
        ConfigError,
        match="num_envs = 4 environments cannot be spread over 3 devices; choose a multiple",
    ):
        sharding.make_mesh(make_config(num_envs=4))


def test_minibatches_must_divide_into_devices(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ppo.jax, "devices", lambda: [*jax.local_devices()] * 2)
    with pytest.raises(
        ConfigError,
        match="spread over 2 devices; the largest below it that works is 2",
    ):
        ppo.check_minibatches(PPOConfig(num_envs=4, num_steps=125, num_minibatches=4))
    ppo.check_minibatches(PPOConfig(num_envs=4, num_steps=125, num_minibatches=2))


@pytest.fixture(scope="module")
def arguments(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    folder = tmp_path_factory.mktemp("games")
    (folder / "orchard.sj").write_text(GAME)
    more = sets(
        "total_timesteps=96",
        "preference_noise=2",
        "checkpoint_updates=2",
        "policy_every=2",
        "evaluate_every=3",
        "evaluation_episodes=4",
    )
    return [str(folder / "orchard.sj"), *sets(*ORCHARD), *more, "--episodes", "0"]


@pytest.fixture(scope="module")
def one(arguments: list[str], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The run on one device."""
    run_dir = tmp_path_factory.mktemp("runs") / "one"
    run_sjdsl("train", *arguments, "--run", run_dir, XLA_FLAGS=ONE)
    return run_dir


def _assert_alike(run_dir: Path, one: Path) -> None:
    rows, wanted = (read_lines(folder / "metrics.jsonl") for folder in (run_dir, one))
    assert len(rows) == len(wanted) == 6
    for row, other in zip(rows, wanted, strict=True):
        assert row.keys() == other.keys()
        for name in row.keys() - set(OF_THE_CLOCK):
            wanted_value = other[name]
            assert row[name] == (
                wanted_value
                if wanted_value is None
                else pytest.approx(wanted_value, rel=1e-3, abs=1e-5)
            ), name
    assert [row["update"] for row in read_lines(run_dir / "evaluations.jsonl")] == [3, 6]


@pytest.mark.slow
def test_two_devices_train_as_one(arguments: list[str], one: Path, tmp_path: Path) -> None:
    run_sjdsl("train", *arguments, "--run", tmp_path / "two", XLA_FLAGS=TWO)
    assert read_manifest(tmp_path / "two")["device"]["count"] == 2
    _assert_alike(tmp_path / "two", one)


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def _run_in_two_processes(*arguments: Any) -> list[str]:
    """Runs a command in two processes that join; returns what each printed."""
    joined = {
        "JAX_COORDINATOR_ADDRESS": f"127.0.0.1:{_free_port()}",
        "JAX_NUM_PROCESSES": "2",
        "XLA_FLAGS": ONE,
    }
    processes = [
        start_sjdsl(*arguments, "--distributed", **joined, JAX_PROCESS_ID=str(number))
        for number in range(2)
    ]
    printed = []
    try:
        for process in processes:
            out, err = process.communicate(timeout=300)
            assert process.returncode == 0, err[-3000:]
            printed.append(out)
    finally:
        for process in processes:
            process.kill()
    return printed


@pytest.mark.slow
def test_two_processes_train_as_one(arguments: list[str], one: Path, tmp_path: Path) -> None:
    """The first alone says and writes what people read; stopped and gone on with, both come to the same again."""
    run_dir = tmp_path / "two"
    first, second = _run_in_two_processes("train", *arguments, "--run", run_dir)
    assert "environment steps in" in first
    assert "update" not in second
    _assert_alike(run_dir, one)
    assert read_manifest(run_dir)["status"] == "finished"
    assert {path.name for path in run_dir.iterdir()} == {path.name for path in one.iterdir()}

    again = copy_run(run_dir, tmp_path / "again")
    max((again / "checkpoints").iterdir(), key=lambda path: int(path.stem)).unlink()
    _run_in_two_processes("train", "--resume", again, "--episodes", "0")
    assert_same_end(again, run_dir)


@pytest.mark.slow
def test_a_process_alone_is_told_what_is_missing(arguments: list[str]) -> None:
    process = start_sjdsl("train", *arguments, "--distributed")
    _, err = process.communicate(timeout=120)
    assert process.returncode == 1
    assert (
        "outside a cluster, set JAX_COORDINATOR_ADDRESS, JAX_NUM_PROCESSES, JAX_PROCESS_ID" in err
    )
