"""`sjdsl doc` and `sjdsl diff`: what they print, write and refuse."""

import json
from pathlib import Path

import pytest
from command_line import GAME, Sjdsl


def test_a_sheet_is_printed_or_written(sjdsl: Sjdsl, folder: Path) -> None:
    printed = sjdsl("doc", "orchard.sj")
    assert printed.status == 0
    assert printed.out.startswith("# A Small Orchard\n")
    assert "| `apple` | 1 | reward | 0 to 5 |" in printed.out
    Path("sheets").mkdir()
    written = sjdsl("doc", "orchard.sj", "-o", "sheets/orchard.md")
    assert written.status == 0
    assert (folder / "sheets" / "orchard.md").read_text() == printed.out
    assert [path.name for path in (folder / "sheets").iterdir()] == ["orchard.md"]


def test_a_variant_has_a_sheet_of_its_own(sjdsl: Sjdsl) -> None:
    shown = sjdsl("doc", "orchard.sj", "--variant", "rich").out
    assert "variant `rich`" in shown
    assert "| `apple` | 2 | reward | 0 to 5 |" in shown


def test_differences_are_printed(sjdsl: Sjdsl) -> None:
    shown = sjdsl("diff", "orchard.sj", "--variants", "default", "rich")
    assert shown.status == 0
    assert shown.out.splitlines() == ["orchard  ->  orchard, variant rich", "", "Numbers", "  apple: 1 -> 2 (reward)"]


def test_differences_of_two_files_and_as_json(sjdsl: Sjdsl, folder: Path) -> None:
    (folder / "other.sj").write_text(GAME.replace("step", "step").replace("set soil.fruit = none  give", "give"))
    found = json.loads(sjdsl("diff", "orchard.sj", "other.sj", "--json").out)
    assert [section["section"] for section in found["sections"]] == ["Phases"]
    crossed = json.loads(sjdsl("diff", "orchard.sj", "other.sj", "--variants", "rich", "rich", "--json").out)
    assert crossed["sections"] == found["sections"]
    assert crossed["old"]["variants"] == ["rich"]


def test_nothing_differs(sjdsl: Sjdsl) -> None:
    shown = sjdsl("diff", "orchard.sj", "orchard.sj")
    assert shown.status == 0
    assert "nothing differs" in shown.out


def test_an_unknown_variant_is_refused_with_those_there_are(sjdsl: Sjdsl) -> None:
    refused = sjdsl("diff", "orchard.sj", "--variants", "default", "ritch")
    assert (refused.status, refused.out) == (1, "")
    assert refused.err == "error: `orchard.sj` has no variant `ritch`; did you mean `rich`?; its variants are default, rich\n"


@pytest.mark.parametrize(
    "arguments",
    [
        ("diff",),
        ("diff", "orchard.sj"),
        ("diff", "a", "b", "c"),
        ("doc",),
    ],
)
def test_what_cannot_be_meant(sjdsl: Sjdsl, arguments: tuple[str, ...]) -> None:
    assert sjdsl(*arguments).status == 2


def test_games_with_mistakes_are_refused(sjdsl: Sjdsl, folder: Path) -> None:
    (folder / "wrong.sj").write_text(GAME.replace("give apple", "give aple"))
    for arguments in (("doc", "wrong.sj"), ("diff", "orchard.sj", "wrong.sj")):
        refused = sjdsl(*arguments)
        assert refused.status == 1
        assert "did you mean `apple`?" in refused.text
    assert sjdsl("doc", "orchrd").status == 1
