"""Locks of cells: of several processes one has a cell, and another takes over when that one has died."""

import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from sjdsl.sweeps import locks
from sjdsl.sweeps.locks import is_running, take_lock

HOLDS = "from sjdsl.sweeps.locks import take_lock; from pathlib import Path; import sys, time; lock = take_lock(Path(sys.argv[1]), 'cell')\n"


@pytest.fixture(autouse=True)
def no_patience(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(locks, "PATIENCE", 0.05)


def test_one_at_a_time(tmp_path: Path) -> None:
    assert not is_running(tmp_path, "cell")
    assert [*tmp_path.iterdir()] == [], "a look leaves nothing behind"
    first = take_lock(tmp_path, "cell")
    assert first is not None
    assert is_running(tmp_path, "cell")
    assert take_lock(tmp_path, "cell") is None
    other = take_lock(tmp_path, "cell.1")
    assert other is not None
    first.release()
    assert not is_running(tmp_path, "cell")
    again = take_lock(tmp_path, "cell")
    assert again is not None
    again.release()
    other.release()


def test_a_process_that_died_holds_nothing(tmp_path: Path) -> None:
    with subprocess.Popen(
        [sys.executable, "-c", HOLDS + "print('held', flush=True); time.sleep(600)", tmp_path],
        stdout=subprocess.PIPE,
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"held\n"
        assert is_running(tmp_path, "cell")
        assert take_lock(tmp_path, "cell") is None
        process.kill()
    assert not is_running(tmp_path, "cell")
    lock = take_lock(tmp_path, "cell")
    assert lock is not None
    lock.release()


def test_of_many_at_once_one_succeeds(tmp_path: Path) -> None:
    taken, begin = [], threading.Barrier(20)

    def contend() -> None:
        begin.wait()
        taken.append(take_lock(tmp_path, "cell"))

    contenders = [threading.Thread(target=contend) for _ in range(20)]
    for thread in contenders:
        thread.start()
    for thread in contenders:
        thread.join()
    assert sum(lock is not None for lock in taken) == 1


def test_who_looks_is_in_nobodys_way(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A look takes the lock for a moment: who wants the cell just then waits for that long, and gets it."""
    monkeypatch.setattr(locks, "PATIENCE", 10.0)
    looking = threading.Event()

    def look() -> None:
        lock = take_lock(tmp_path, "cell")
        assert lock is not None
        looking.set()
        time.sleep(0.2)
        lock.release()

    threading.Thread(target=look).start()
    looking.wait()
    lock = take_lock(tmp_path, "cell")
    assert lock is not None
    lock.release()
