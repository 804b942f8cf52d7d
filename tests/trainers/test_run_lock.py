"""The folder of a run is one process's at a time, and its lock ends with the process."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from probes import matching
from run_outcomes import SHORT, counting, read_manifest

from sjdsl.trainers import RunError, resume, train
from sjdsl.trainers.runs import run
from sjdsl.trainers.runs.run_lock import LOCK, is_unused
from sjdsl.trainers.runs.updates import Update

CONFIG = SHORT.model_copy(update={"evaluate_every": 0})
HOLDS = "from sjdsl.trainers.runs.run_lock import locked; from pathlib import Path; import sys, time\nwith locked(Path(sys.argv[1])): print('held', flush=True); time.sleep(600)"

COUNTS = """
import sys
from pathlib import Path
from sjdsl.trainers import RunError
from sjdsl.trainers.runs.run_lock import locked

folder = Path(sys.argv[1])
counted = 0
while counted < 40:
    try:
        with locked(folder / "run"):
            number = int((folder / "count").read_text())
            (folder / "count").write_text(str(number + 1))
            counted += 1
    except RunError:
        pass
"""


@pytest.fixture(autouse=True)
def learns_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run, "make_train", lambda *_: counting())


def test_a_second_process_is_refused_until_the_first_has_died(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    train(matching(), CONFIG, folder, "none", callback=lambda update: update.number == 4)
    before = read_manifest(folder)
    with subprocess.Popen(
        [sys.executable, "-c", HOLDS, str(folder)], stdout=subprocess.PIPE, text=True
    ) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "held\n"
        with pytest.raises(
            RunError,
            match=rf"run is in use: process {other.pid} on .* trains there. Wait until it has ended",
        ):
            resume(matching(), folder, "none")
        assert read_manifest(folder) == before, "nothing was written"
        other.send_signal(signal.SIGKILL)
    assert resume(matching(), folder, "none").updates == 12


def test_a_run_that_is_under_way_is_not_begun_or_resumed_beside(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    said = []

    def beside(update: Update) -> None:
        if update.number == 3:
            for start in (
                lambda: resume(matching(), folder, "none"),
                lambda: train(matching(), CONFIG, folder, "none"),
            ):
                with pytest.raises(RunError) as error:
                    start()
                said.append(str(error.value))

    assert train(matching(), CONFIG, folder, "none", callback=beside).updates == 12
    assert not (folder / LOCK).exists(), "nobody holds it any more"
    assert f"process {os.getpid()}" in said[0]
    assert "is not empty" in said[1]
    assert read_manifest(folder)["status"] == "finished"
    assert [
        json.loads(line)["update"] for line in (folder / "metrics.jsonl").read_text().splitlines()
    ] == [*range(1, 13)]


def test_a_lock_that_nobody_holds_is_in_no_ones_way(tmp_path: Path) -> None:
    """As of a process that was killed before its run began."""
    (tmp_path / LOCK).write_text("process 1 of nowhere")
    assert is_unused(tmp_path)
    assert train(matching(), CONFIG, tmp_path, "none").updates == 12
    assert not (tmp_path / LOCK).exists()
    assert not is_unused(tmp_path)


def test_the_lock_is_held_by_one_however_often_its_file_goes(tmp_path: Path) -> None:
    """Processes that take and release it in turns: each adds to a count while it holds it."""
    count = tmp_path / "count"
    count.write_text("0")
    processes = [subprocess.Popen([sys.executable, "-c", COUNTS, str(tmp_path)]) for _ in range(3)]
    assert [process.wait() for process in processes] == [0, 0, 0]
    assert count.read_text() == "120"
    assert not (tmp_path / "run" / LOCK).exists()


def test_a_file_is_no_folder_for_a_run(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    assert not is_unused(tmp_path / "file")
