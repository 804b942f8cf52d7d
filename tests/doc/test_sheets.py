"""Rule sheets as stored texts, and the page of the games: current, its figures found again."""

from collections.abc import Callable
from pathlib import Path

import pytest

from bench.game_pages import SEED, measure, page_problems, read_figures
from sjdsl.doc import rule_sheet
from sjdsl.doc.wording import plain

from .corpus import TESTS, small

GOLDEN = TESTS / "golden" / "doc"
SHEETS = (
    "beams",
    "chances",
    "everyone",
    "looking",
    "looks",
    "matching",
    "pictures",
    "policies",
    "rows",
    "sending",
    "sight",
    "timers",
)
PAGE = TESTS.parent / "docs" / "games.md"


@pytest.mark.parametrize("name", SHEETS)
def test_sheet(name: str, golden: Callable[[Path, str], None]) -> None:
    golden(GOLDEN / f"{name}.md", rule_sheet(small()[name]))


def test_the_page_of_the_games_is_current(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(TESTS.parent)
    assert page_problems(Path("docs/games.md")) == [], "run `make docs`"


@pytest.mark.thorough
def test_figures_are_found_again() -> None:
    stored = read_figures(PAGE.with_suffix(".json"))["coins"]
    again = measure("coins", stored["episodes"], stored["seed"])
    assert again["hash"] == stored["hash"]
    assert again["values"].keys() == stored["values"].keys()
    for name, figure in stored["values"].items():
        assert {end: value or 0.0 for end, value in again["values"][name].items()} == pytest.approx(
            {end: value or 0.0 for end, value in figure.items()}, rel=1e-4
        )
    assert stored["seed"] == SEED


def test_code_in_an_authors_text_stays_code_and_other_marks_are_escaped() -> None:
    assert plain("hits within `recovery_time` *steps*") == r"hits within `recovery_time` \*steps\*"
    assert plain("a ` alone") == r"a \` alone"
    assert plain("`a | b`") == r"\`a \| b\`", "in a table"
