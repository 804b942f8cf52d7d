"""Every field of a manifest that is read is checked: what a stranger, or a fault of a disk, has written there is a message."""

import copy
import json
import warnings
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from probes import matching

from sjdsl.cli import run as command_line
from sjdsl.results import ResultsWarning
from sjdsl.results.loading import _read_run as read_run
from sjdsl.sweeps.folder import diverged_in, is_finished
from sjdsl.trainers import PolicyError, RunError, make_config
from sjdsl.trainers.runs.manifest import MANIFEST, read_manifest
from sjdsl.trainers.runs.resuming import check_same_run, extend_manifest
from sjdsl.trainers.runs.run_folder import describe_run
from sjdsl.trainers.runs.run_state import run_state

STRANGE = [
    None,
    True,
    -1,
    0.5,
    10**400,
    "x",
    "\udcff",
    [],
    {},
    [[]],
    [5],
    {"a": 1},
    ["\udcff"],
    [{"seed": []}],
]


@pytest.fixture(scope="module")
def whole() -> dict[str, Any]:
    """A manifest with all fields; its game is nowhere, so that no command trains."""
    provenance = {
        "game": "nowhere",
        "variant": None,
        "map": None,
        "num_agents": None,
        "params": {"a": 1},
    }
    later = {
        "status": "interrupted",
        "updates": 3,
        "diverged": [{"seed": 0, "update": 2}],
        "resumed": ["2026-01-01"],
    }
    asked = {
        "loggers": [],
        "asked": {"episodes": 3, "callback": "mine"},
        "extended": [{"from": 1, "to": 2, "updates": 1}],
    }
    return json.loads(
        json.dumps(describe_run(matching(), make_config(), provenance) | later | asked)
    )


def places(value: Any, place: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    yield place
    inner = (
        value.items()
        if isinstance(value, dict)
        else enumerate(value)
        if isinstance(value, list)
        else ()
    )
    for key, entry in inner:
        yield from places(entry, (*place, key))


def damaged(whole: dict[str, Any], place: tuple[Any, ...], value: Any) -> Any:
    if not place:
        return value
    changed: Any = copy.deepcopy(whole)
    inner = changed
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = value
    return changed


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (("asked", "episodes"), "many"),
        (("asked", "episodes"), -3),
        (("asked",), []),
        (("asked", "callback"), 5),
        (("loggers",), [{}]),
        (("provenance",), ["game"]),
        (("updates",), "3"),
        (("diverged",), [{"seed": 1}]),
        (("own_files",), "mine.py"),
        (("game", "params"), [1]),
        (("versions", "jax"), 5),
    ],
)
def test_what_is_wrong_is_named(
    whole: dict[str, Any],
    place: tuple[str, ...],
    value: Any,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / MANIFEST).write_text(json.dumps(damaged(whole, place, value)))
    with pytest.raises(
        RunError, match=rf"is damaged: `{'.'.join(place)}[^`]*` in its manifest\.json: "
    ):
        read_manifest(tmp_path)
    assert command_line(["train", "--resume", str(tmp_path)]) == 1
    assert f"`{'.'.join(place)}" in capsys.readouterr().err


@pytest.mark.thorough
def test_whatever_stands_there_is_a_message(
    whole: dict[str, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / MANIFEST).write_text(json.dumps(whole))
    assert read_manifest(tmp_path) == whole
    for place in places(whole):
        for value in STRANGE:
            (tmp_path / MANIFEST).write_text(json.dumps(damaged(whole, place, value)))
            with suppress(RunError, PolicyError):
                run_state(tmp_path)
            with suppress(RunError):
                extend_manifest(check_same_run(matching(), tmp_path), tmp_path, 10**9)
            is_finished(tmp_path), diverged_in(tmp_path)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", ResultsWarning)
                read_run(tmp_path)
    for partner in ("a" * 5000, "a\0", f"a@{'9' * 5000}"):
        (tmp_path / MANIFEST).write_text(
            json.dumps(damaged(whole, ("config", "partners"), [[1, partner]]))
        )
        with pytest.raises(RunError, match=r"has an invalid configuration|has done"):
            extend_manifest(check_same_run(matching(), tmp_path), tmp_path, 1)
    for place in places({key: whole[key] for key in ("asked", "loggers", "provenance", "status")}):
        for value in (
            value for value in STRANGE if "\\udcff" not in json.dumps(value)
        ):  # which pytest's capture cannot print
            (tmp_path / MANIFEST).write_text(json.dumps(damaged(whole, place, value)))
            for command in (["train", "--resume", str(tmp_path)], ["evaluate", str(tmp_path)]):
                assert command_line(command) == 1, (command, place, value)
                assert "error: " in capsys.readouterr().err, (command, place, value)
