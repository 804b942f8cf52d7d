"""Rule sheets as stored texts, and the page of the games: current, its figures found again."""

from collections.abc import Callable
from pathlib import Path

import pytest

from bench.game_pages import SEED, figures_text, measure, page_problems, read_figures
from sjdsl.doc import rule_sheet

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


def test_no_golden_is_left_over() -> None:
    assert {path.name for path in GOLDEN.iterdir()} == {f"{name}.md" for name in SHEETS}


def test_the_page_of_the_games_is_current(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(TESTS.parent)
    assert page_problems(Path("docs/games.md")) == [], "run `make docs`"


@pytest.mark.thorough
def test_a_page_that_is_not_current_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(TESTS.parent)
    figures = read_figures(PAGE.with_suffix(".json"))
    first = next(iter(figures))
    old = {**figures[first], "hash": "0" * 16}
    (tmp_path / "games.json").write_text(figures_text({**figures, first: old, "no_game": old}))
    (tmp_path / "games.md").write_text(PAGE.read_text(encoding="utf-8"), encoding="utf-8")
    told = page_problems(tmp_path / "games.md")
    assert f"{first}: the figures are of other rules" in told
    assert "no_game: figures of no game" in told
    assert sum("missing" in line for line in told) == len(figures)
    (tmp_path / "pictures").mkdir()
    drawn = TESTS.parent / "docs" / "pictures" / "coins.png"
    for name in ("coins", "mushrooms"):
        (tmp_path / "pictures" / f"{name}.png").write_bytes(drawn.read_bytes())
    (said,) = [line for line in page_problems(tmp_path / "games.md") if "looks" in line]
    assert said.endswith("mushrooms.png: of other rules or looks")
    assert not any("not what the games say" in line for line in told)


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
