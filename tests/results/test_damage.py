"""A report, a sweep and a plot meet damaged files: each shape of garbage is one clear message or a note, never a traceback."""

import csv
import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from report_folders import write_run

from sjdsl.cli import run
from sjdsl.trainers.policies.stored_evaluation import read_evaluation
from sjdsl.trainers.runs.curves import read_seeds
from sjdsl.trainers.runs.run_errors import RunError

DEEP = "[" * 100_000
FIGURE = {"mean": 1.0, "low": 0.0, "high": 2.0}
CONTRASTS = dict.fromkeys(("A", "B", "fear", "greed"), FIGURE)
GAME = {"name": "coins", "hash": "1a2b", "num_agents": 2, "params": {}}
VERDICT = {
    "outcome": "dilemma",
    "fear": True,
    "greed": False,
    "reason": "A is above 0",
    "caution": None,
}
DIAGRAM: dict[str, Any] = {
    "format": 1, "cooperators": "stay", "defectors": "random", "game": GAME, "unit": "episode", "units": 30, "episodes": 30,
    "notes": [], "contrasts": CONTRASTS, "verdict": VERDICT,
}  # fmt: skip
MIXTURE = {
    "mixture": "2 random",
    "slots": ["random", "random"],
    "policies": {"random": FIGURE},
    "unit": "episode",
    "episodes": 30,
}
CROSS_PLAY: dict[str, Any] = {
    "format": 1, "game": GAME, "unit": "episode", "episodes": 30, "notes": [], "keys": [[0, 1]], "mixtures": [MIXTURE],
}  # fmt: skip


def replaced(content: dict[str, Any], place: str, value: Any) -> dict[str, Any]:
    """Returns JSON with another value at `a.b.0.c`; ... leaves it out."""
    name, _, rest = place.partition(".")
    if isinstance(content, list):
        return [
            *content[: int(name)],
            replaced(content[int(name)], rest, value) if rest else value,
            *content[int(name) + 1 :],
        ]  # type: ignore[return-value]
    if value is ... and not rest:
        return {key: entry for key, entry in content.items() if key != name}
    return {**content, name: replaced(content[name], rest, value) if rest else value}


ODD = (..., [], {}, 3.5, -(10**30), "\ud800", True, [[1]], {"a": None}, "x" * 10)
PLACES = {
    "schelling.json": (DIAGRAM, ["game", "game.name", "game.params", "game.num_agents", "game.hash", "units", "unit", "verdict", "verdict.fear",
                                 "verdict.reason", "contrasts.A.mean", "contrasts.fear", "notes", "cooperators", "episodes", "format"]),
    "crossplay.json": (CROSS_PLAY, ["game", "game.name", "unit", "keys", "mixtures", "mixtures.0.slots", "mixtures.0.policies",
                                    "mixtures.0.policies.random", "mixtures.0.policies.random.low", "mixtures.0.episodes", "notes", "format"]),
}  # fmt: skip


def report(folder: Path, capsys: pytest.CaptureFixture[str]) -> tuple[int, str]:
    capsys.readouterr()
    shutil.rmtree(folder / "out", ignore_errors=True)
    status = run(["report", str(folder / "in"), "-o", str(folder / "out")])
    return status, "".join(capsys.readouterr())


@pytest.mark.parametrize("name", PLACES)
def test_whatever_stands_in_the_file_of_an_experiment(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    content, places = PLACES[name]
    (tmp_path / "in").mkdir()
    for place in places:
        for value in ODD:
            (tmp_path / "in" / name).write_text(json.dumps(replaced(content, place, value)))
            status, told = report(tmp_path, capsys)
            assert status in (0, 1)
            assert status == 0 or str(tmp_path / "in" / name) in told, (place, value, told)


@pytest.mark.parametrize(
    "text", ["", "[]", DEEP, '{"format": 1', '{"format": 2}', "3", '"\\ud800"', "\0"]
)
@pytest.mark.parametrize("name", ["schelling.json", "crossplay.json", "sweep.json"])
def test_what_is_no_such_file(
    name: str, text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in/results.csv").write_text("cell,game\n")
    (tmp_path / "in" / name).write_text(text)
    status, told = report(tmp_path, capsys)
    assert (status, f"{tmp_path / 'in' / name} cannot be read" in told) == (1, True), told


def with_line(text: str) -> Callable[[Path], object]:
    return lambda path: path.write_text(path.read_text() + text)


METRICS: dict[str, Callable[[Path], object]] = {
    "a folder": lambda path: (path.unlink(), path.mkdir()),
    "a pipe": lambda path: (path.unlink(), os.mkfifo(path)),
    "a device": lambda path: (path.unlink(), path.symlink_to("/dev/zero")),
    "deep": with_line(f"{DEEP}\n"),
    "a list": with_line("[1]\n"),
    "text": with_line('{"update": 9, "env_steps": "many"}\n'),
    "a table": with_line('{"update": 9, "env_steps": {}}\n'),
    "no steps": with_line('{"update": 9, "collective_return": 1}\n'),
    "a long line": with_line("1" * (2**20 + 2) + "\n"),
    "many digits": with_line(f'{{"update": {"9" * 5000}, "env_steps": 1}}\n'),
    "no UTF-8": lambda path: path.write_bytes(path.read_bytes() + b'{"\xff": 1}\n'),
}


@pytest.fixture(autouse=True)
def _without_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sjdsl.results.report.draw_pictures", lambda _: {})


@pytest.mark.parametrize("damage", METRICS)
def test_damaged_metrics_leave_the_run_out(
    damage: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("a", "b"):
        write_run(tmp_path / "in" / name, "coins", [1.0])
    METRICS[damage](tmp_path / "in/b/metrics.jsonl")
    status, told = report(tmp_path, capsys)
    assert (status, str(tmp_path / "in/b/metrics.jsonl") in told) == (0, True), told
    with pytest.raises(RunError, match=r"metrics\.jsonl"):
        read_seeds(tmp_path / "in/b", "collective_return")


EVALUATION = {
    "policy": "last",
    "update": 4,
    "seed": 0,
    "greedy": None,
    "episodes": 30,
    "summary": {"collective return": FIGURE},
}


@pytest.mark.parametrize(
    "place", ["summary", "summary.collective return", "summary.collective return.mean", "episodes"]
)
def test_a_damaged_evaluation_is_none(place: str, tmp_path: Path) -> None:
    path = tmp_path / "evaluation.json"
    path.write_text(json.dumps(EVALUATION))
    assert read_evaluation(path) is not None
    for value in ([], {"x": 3}, "many", -1 if place == "episodes" else [1], 10**400, float("inf")):
        path.write_text(json.dumps(replaced(EVALUATION, place, value)))
        assert read_evaluation(path) is None, value


def test_settings_of_stored_results_are_checked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_run(tmp_path / "in/a", "coins", [1.0])
    status, told = report(tmp_path, capsys)
    assert status == 0, told
    stored = (tmp_path / "out/data/results.csv").read_text()
    (row,) = csv.DictReader(stored.splitlines())
    damaged = tmp_path / "in/results.csv"
    shutil.rmtree(tmp_path / "in/a")
    for settings in ("{", "[]", "3", DEEP, '"{}"'):
        with damaged.open("w") as file:
            writer = csv.DictWriter(file, [*row])
            writer.writeheader()
            writer.writerow({**row, "settings": settings})
        status, told = report(tmp_path, capsys)
        assert status == 1
        assert f"{damaged}: `settings` must be JSON" in told
