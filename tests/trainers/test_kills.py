"""Runs of the command line whose process is killed or interrupted, at times nobody chose."""

import random
import signal
import time
from pathlib import Path

import pytest
from run_outcomes import (
    ORCHARD,
    TWELVE,
    VALUES,
    assert_same_end,
    read_lines,
    read_manifest,
    run_sjdsl,
    sets,
    start_sjdsl,
    wait_for_rows,
)

from tests.cli.command_line import GAME

pytestmark = pytest.mark.slow

ARGUMENTS = {
    "ippo": sets(*ORCHARD, *TWELVE),
    "vdn": ["--algorithm", "vdn", *sets(*VALUES, *TWELVE)],
}


@pytest.fixture(scope="module")
def games(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("games")
    (folder / "orchard.sj").write_text(GAME)
    return folder


@pytest.fixture(scope="module", params=["ippo", "vdn"])
def arguments(request: pytest.FixtureRequest, games: Path) -> list[str]:
    return [str(games / "orchard.sj"), *ARGUMENTS[request.param], "--episodes", "0"]


@pytest.fixture(scope="module")
def whole(arguments: list[str], tmp_path_factory: pytest.TempPathFactory) -> Path:
    run_dir = tmp_path_factory.mktemp("runs") / "whole"
    run_sjdsl("train", *arguments, "--run", run_dir)
    assert len(read_lines(run_dir / "metrics.jsonl")) == 12
    return run_dir


def _resume(run_dir: Path) -> None:
    run_sjdsl("train", "--resume", run_dir, "--episodes", "0")


@pytest.mark.parametrize("seed", range(4))
def test_killed_again_and_again(
    arguments: list[str], whole: Path, tmp_path: Path, seed: int
) -> None:
    """Within a second of the first update that a process makes: also while it saves, and while it reads what was saved."""
    chance = random.Random(seed)
    run_dir = tmp_path / "run"
    process = start_sjdsl("train", *arguments, "--run", run_dir)
    for _ in range(3):
        wait_for_rows(run_dir, len(read_lines_or_none(run_dir)) + 1, process)
        time.sleep(chance.random() * 0.7)
        process.kill()
        process.communicate()
        process = start_sjdsl("train", "--resume", run_dir, "--episodes", "0")
    _, err = process.communicate(timeout=400)
    assert process.returncode == 0, err[-3000:]
    assert_same_end(run_dir, whole)


def read_lines_or_none(run_dir: Path) -> list[str]:
    lines = run_dir / "metrics.jsonl"
    return lines.read_text().splitlines() if lines.exists() else []


def test_ctrl_c_is_told_and_gone_on_from(arguments: list[str], whole: Path, tmp_path: Path) -> None:
    run_dir = tmp_path / "run"
    process = start_sjdsl("train", *arguments, "--run", run_dir)
    wait_for_rows(run_dir, 2, process)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=120)
    assert process.returncode == 130, out + err
    assert err.splitlines()[-1] == "interrupted"
    manifest = read_manifest(run_dir)
    assert manifest["status"] == "interrupted"
    done = manifest["updates"]
    assert 2 <= done < 12
    assert (run_dir / "checkpoints" / f"{done}.safetensors").is_file()
    _resume(run_dir)
    assert_same_end(run_dir, whole)


@pytest.mark.parametrize("wait", [0.0, 0.7, 1.5])
def test_ctrl_c_while_the_program_is_compiled(games: Path, tmp_path: Path, wait: float) -> None:
    """The manifest is written before; nothing is kept, and the process ends as it is told, whatever XLA is at."""
    run_dir = tmp_path / "run"
    process = start_sjdsl(
        "train",
        str(games / "orchard.sj"),
        *ARGUMENTS["ippo"],
        "--set",
        f"gamma={0.9 + wait / 100}",
        "--run",
        run_dir,
    )
    until = time.monotonic() + 120
    while not (run_dir / "manifest.json").exists():
        assert process.poll() is None
        assert time.monotonic() < until
        time.sleep(0.01)
    time.sleep(wait)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=120)
    assert process.returncode == 130, out + err
    assert err.splitlines()[-1] == "interrupted"
    assert read_manifest(run_dir)["status"] == "interrupted"
