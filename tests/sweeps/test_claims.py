"""Claims: of several processes one has a cell, and another takes over when that one has died."""

import json
import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import psutil
import pytest

from sjdsl.sweeps import claims
from sjdsl.sweeps.claims import Claim, holder_of, left_by, take

ELSEWHERE = {"machine": "another", "host": "far", "pid": 7, "started": 0.0}


def write_claim(folder: Path, number: int, content: dict[str, object], age: float = 0.0) -> Path:
    path = folder / "claims" / f"cell@{number}.json"
    path.parent.mkdir(exist_ok=True)
    path.write_text(json.dumps(content))
    then = time.time() - age
    os.utime(path, (then, then))
    return path


def test_one_at_a_time(tmp_path: Path) -> None:
    first = take(tmp_path, "cell")
    assert first is not None
    assert take(tmp_path, "cell") is None
    holder = holder_of(tmp_path, "cell")
    assert holder is not None
    assert holder.pid == os.getpid()
    other = take(tmp_path, "cell.1")
    assert other is not None
    first.release()
    assert holder_of(tmp_path, "cell") is None
    assert left_by(tmp_path, "cell") is None
    again = take(tmp_path, "cell")
    assert again is not None
    assert again.path.name == "cell@1.json"
    assert not again.is_lost
    again.release()
    other.release()


def test_a_process_of_this_machine_that_died_holds_nothing(tmp_path: Path) -> None:
    program = (
        f"from sjdsl.sweeps.claims import take; from pathlib import Path; import os; take(Path({str(tmp_path)!r}), 'cell'); os._exit(9)"
    )
    subprocess.run([sys.executable, "-c", program], check=False)
    assert holder_of(tmp_path, "cell") is None
    assert left_by(tmp_path, "cell") is not None
    claim = take(tmp_path, "cell")
    assert claim is not None
    claim.release()


def test_another_machine_holds_a_cell_as_long_as_its_heart_beats(tmp_path: Path) -> None:
    path = write_claim(tmp_path, 0, ELSEWHERE, age=claims.STALE / 2)
    assert take(tmp_path, "cell") is None
    then = time.time() - 2 * claims.STALE
    os.utime(path, (then, then))
    claim = take(tmp_path, "cell")
    assert claim is not None
    assert claim.path.name == "cell@1.json"
    claim.release()
    write_claim(tmp_path, 2, {**ELSEWHERE, "released": True})
    assert holder_of(tmp_path, "cell") is None


def test_a_claim_that_is_being_written_is_one(tmp_path: Path) -> None:
    path = write_claim(tmp_path, 0, ELSEWHERE)
    path.write_text("")
    assert take(tmp_path, "cell") is None


def test_the_heart_beats(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(claims, "BEAT", 0.01)
    claim = take(tmp_path, "cell")
    assert claim is not None
    os.utime(claim.path, (0, 0))
    until = time.monotonic() + 30
    while claim.path.stat().st_mtime < 1:
        assert time.monotonic() < until
        time.sleep(0.01)
    claim.release()


def test_who_is_taken_over_from_is_told(tmp_path: Path) -> None:
    claim = take(tmp_path, "cell")
    assert claim is not None
    write_claim(tmp_path, 1, ELSEWHERE)
    assert claim.is_lost
    claim.release()
    assert take(tmp_path, "cell") is None, "the other one's claim counts"


def test_of_many_who_take_over_one_succeeds(tmp_path: Path) -> None:
    """Twenty at once, ten times; each time the claim is that of a machine that has died."""
    for number in range(10):
        write_claim(tmp_path, 2 * number, ELSEWHERE, age=2 * claims.STALE)
        taken: list[Claim] = []
        begin = threading.Barrier(20)

        def contend(taken: list[Claim] = taken, begin: threading.Barrier = begin) -> None:
            begin.wait()
            claim = take(tmp_path, "cell")
            if claim is not None:
                taken.append(claim)

        contenders = [threading.Thread(target=contend) for _ in range(20)]
        for thread in contenders:
            thread.start()
        for thread in contenders:
            thread.join()
        assert len(taken) == 1
        taken[0].release()


@pytest.mark.parametrize("content", [{}, {"pid": "seven"}, {"pid": None, "started": None}, {"started": 1.0}, {"pid": 1}])
def test_a_claim_that_does_not_say_of_which_process_it_is_holds_by_its_heartbeat(tmp_path: Path, content: dict[str, object]) -> None:
    own = {"machine": claims._machine()}
    path = write_claim(tmp_path, 0, {**own, **content}, age=claims.STALE / 2)
    holder = holder_of(tmp_path, "cell")
    assert holder is not None
    assert take(tmp_path, "cell") is None
    os.utime(path, (0, 0))
    assert left_by(tmp_path, "cell") is not None
    claim = take(tmp_path, "cell")
    assert claim is not None
    claim.release()


def test_a_clock_that_is_set_kills_no_claim(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Linux says when processes were started in time since the machine was: set by the clock, that was a second or a year ago."""
    claim = take(tmp_path, "cell")
    assert claim is not None
    create_time = psutil.Process.create_time
    monkeypatch.setattr(psutil.Process, "create_time", lambda process: create_time(process) + 3600.0)
    assert holder_of(tmp_path, "cell") is not None
    assert take(tmp_path, "cell") is None
    claim.release()
