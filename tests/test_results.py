"""docs/results.md says what the CSV files in docs/results/data say, and they hold the diagrams of docs/schelling that the paper has, too."""

from pathlib import Path

import pytest

from bench.paper import __main__ as paper
from bench.paper import published
from sjdsl.results import load

ROOT = Path(__file__).parents[1]
DATA = ROOT / "docs/results/data"
DIAGRAMS = [file.parent for file in sorted((ROOT / "docs" / "schelling").glob("*/schelling.json"))]


def test_the_page_of_results_is_up_to_date(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(ROOT)
    status = paper.main(["--check"])
    assert (status, capsys.readouterr().err) == (0, ""), "write it again with `make results`"


def test_all_committed_diagrams_are_in_the_results() -> None:
    """Whatever folder their policies were in when they were played."""
    columns = [
        "game",
        "hash",
        "params",
        "cooperators",
        "defectors",
        "unit",
        "units",
        "A_mean",
        "fear_low",
        "greed_high",
    ]
    there, here = (
        {
            (
                Path(row.cooperators).name,
                Path(row.defectors).name,
                *row[columns].drop(["cooperators", "defectors"]),
            )
            for _, row in load(*folders).query("record == 'diagram'").iterrows()
            if row.game in published.suite()
        }
        for folders in ([DATA], DIAGRAMS)
    )
    assert here - there == set(), "take them in as docs/reports.md says"
