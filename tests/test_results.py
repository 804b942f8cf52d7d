"""docs/results.md says what the CSV files in docs/results/data say."""

from pathlib import Path

import pytest

from sjdsl.cli import run

ROOT = Path(__file__).parents[1]


def test_the_page_of_results_is_up_to_date(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(ROOT)
    status = run(["report", "docs/results/data", "-o", "docs/results.md", "--suite", "--check"])
    assert (status, capsys.readouterr().out) == (0, ""), "write it again with `make results`"
