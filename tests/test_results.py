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


def test_cross_play_is_of_the_policies_of_the_diagrams() -> None:
    """Both play a policy with itself by the same keys, so that A is the difference of two mixtures, to the digits that are kept."""
    data = load(DATA)
    met, diagrams = (data[data.record == record] for record in ("mixture", "diagram"))
    earned = {(row.hash, row.mixture): row["mean"] for _, row in met.iterrows()}
    found = 0
    for _, row in diagrams.iterrows():
        both = [
            earned.get((row.hash, f"{row.num_agents} x {policy}"))
            for policy in (row.cooperators, row.defectors)
        ]
        if None not in both:
            assert pytest.approx(both[0] - both[1], abs=1e-3) == row.A_mean
            found += 1
    assert found
    trained = {policy for policy in met.policy if policy.startswith("runs/")}
    assert trained <= {*diagrams.cooperators, *diagrams.defectors}
