"""`sjdsl doc` and `sjdsl diff`: what they print, write and refuse."""

from pathlib import Path

from command_line import Sjdsl


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
