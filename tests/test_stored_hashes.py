"""Files that hold a hash of an earlier version are read as of the rules of today; policies: tests/trainers/test_policy_file.py."""

import json
import tomllib
from pathlib import Path

import pandas as pd
import pytest

from sjdsl.library.games_folder import games_folder
from sjdsl.library.stored_hashes import FILE, current_hash
from sjdsl.replay.recording import Recording, RecordingError, check_rules
from sjdsl.results.loading import COLUMNS, load, write_frame
from sjdsl.sweeps.cells import Cell
from sjdsl.trainers.runs.manifest import read_manifest

((OLD, NEW), *_) = tomllib.loads((games_folder() / FILE).read_text("utf-8"))["coins"].items()


def test_it_is_known_and_others_are_kept() -> None:
    assert OLD != NEW == current_hash(OLD) == current_hash(NEW)
    assert current_hash("0123456789abcdef") == "0123456789abcdef"


def test_recordings() -> None:
    recording = Recording(environment={"game": "coins"}, hash=OLD, seed=0, actions=[], returns=[])
    check_rules(recording, NEW, "coins")
    with pytest.raises(RecordingError, match="have changed"):
        check_rules(recording.model_copy(update={"hash": "0"}), NEW, "coins")


def test_runs(tmp_path: Path) -> None:
    manifest = {"game": {"name": "coins", "hash": OLD}, "config": {}, "versions": {}}
    (tmp_path / "manifest.json").write_text(json.dumps(manifest))
    assert read_manifest(tmp_path)["game"]["hash"] == NEW


def test_sweeps() -> None:
    described = {
        "game": "coins",
        "hash": OLD,
        "provenance": {},
        "config": {},
        "values": {},
        "stage": 1,
        "point": None,
    }
    assert Cell.read("coins", described).hash == NEW


def test_results(tmp_path: Path) -> None:
    """Two tables, one of them of before: what they say of one game is told once."""
    for name, rules in (("before", OLD), ("today", NEW)):
        found = pd.DataFrame(
            [{"record": "random", "game": "coins", "hash": rules, "collective_return": 1.0}],
            columns=COLUMNS,
        )
        (tmp_path / name).mkdir()
        (tmp_path / name / "results.csv").write_text(write_frame(found))
    assert load(tmp_path / "before", tmp_path / "today").hash.to_list() == [NEW]
