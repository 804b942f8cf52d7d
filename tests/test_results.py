"""docs/results.md says what the CSV files in docs/results/data say, and they hold all diagrams of docs/schelling that something is published of."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from sjdsl.cli import run
from sjdsl.report import read_folders
from sjdsl.report.evidence import DiagramRow

ROOT = Path(__file__).parents[1]
FILES = sorted((ROOT / "docs" / "schelling").glob("*/schelling.json"))
DIAGRAMS = [file.parent for file in FILES if json.loads(file.read_text("utf-8"))["published"] is not None]


def test_the_page_of_results_is_up_to_date(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(ROOT)
    status = run(["report", "docs/results/data", "-o", "docs/results.md", "--suite", "--check"])
    assert (status, capsys.readouterr().out) == (0, ""), "write it again with `make results`"


def test_all_committed_diagrams_are_in_the_results() -> None:
    """Whatever folder their policies were in when they were played."""

    def named(row: DiagramRow) -> DiagramRow:
        return replace(row, cooperators=Path(row.cooperators).name, defectors=Path(row.defectors).name)

    there = {named(row) for row in read_folders([ROOT / "docs/results/data"]).diagrams}
    missing = [folder.name for folder in DIAGRAMS for row in read_folders([folder]).diagrams if named(row) not in there]
    assert not missing, "take them in as docs/reports.md says"


def test_cross_play_is_of_the_policies_of_the_diagrams() -> None:
    """Both play a policy with itself by the same keys, so that A is the difference of two mixtures, to the digits that are kept."""
    data = read_folders([ROOT / "docs/results/data"])
    earned = {(row.hash, row.mixture): row.mean for row in data.meetings}
    found = 0
    for row in data.diagrams:
        both = [earned.get((row.hash, f"{row.num_agents} x {policy}")) for policy in (row.cooperators, row.defectors)]
        if None not in both:
            assert pytest.approx(both[0] - both[1], abs=1e-3) == row.A
            found += 1
    assert found
    trained = {row.policy for row in data.meetings if row.policy.startswith("runs/")}
    assert trained <= {policy for row in data.diagrams for policy in (row.cooperators, row.defectors)}
