"""`sjdsl fmt`: formats files in place, or only reports; a file with syntax errors stays as it is."""

import io
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from command_line import GAME, Sjdsl

UGLY = GAME.replace("  agents players {", "agents   players{").replace(
    "episode length", "episode length # steps"
)
WRONG = UGLY.replace("schedule", "shedule")


@pytest.fixture(autouse=True)
def formatted_orchard(folder: Path, sjdsl: Sjdsl) -> None:
    """The game of the other tests is not laid out in columns everywhere."""
    sjdsl("fmt orchard.sj")
    assert (folder / "orchard.sj").is_file()


def test_a_file_is_laid_out_in_place(sjdsl: Sjdsl, folder: Path) -> None:
    (folder / "ugly.sj").write_text(UGLY)
    shown = sjdsl("fmt ugly.sj orchard.sj")
    assert shown.status == 0
    assert shown.out == "ugly.sj was reformatted\n2 files: 1 reformatted, 1 unchanged\n"
    assert (folder / "ugly.sj").read_text() == (folder / "orchard.sj").read_text().replace(
        "episode length", "episode length  # steps"
    )


def test_a_formatted_file_is_not_touched(sjdsl: Sjdsl, folder: Path) -> None:
    before = (folder / "orchard.sj").stat()
    assert sjdsl("fmt orchard.sj").out == "1 file: 1 unchanged\n"
    after = (folder / "orchard.sj").stat()
    assert (before.st_mtime_ns, before.st_ino) == (after.st_mtime_ns, after.st_ino)


def test_check_writes_nothing_and_names_the_files(sjdsl: Sjdsl, folder: Path) -> None:
    (folder / "ugly.sj").write_text(UGLY)
    shown = sjdsl("fmt --check .")
    assert shown.status == 1
    assert shown.out == "ugly.sj would be reformatted\n2 files: 1 to be reformatted, 1 unchanged\n"
    assert (folder / "ugly.sj").read_text() == UGLY
    assert sjdsl("fmt --check orchard.sj").status == 0


def test_a_file_with_mistakes_is_left_alone_and_the_others_are_done(
    sjdsl: Sjdsl, folder: Path
) -> None:
    (folder / "a_wrong.sj").write_text(WRONG)
    (folder / "ugly.sj").write_text(UGLY)
    shown = sjdsl("fmt .")
    assert shown.status == 1
    assert "did you mean `schedule`?" in shown.err
    assert (folder / "a_wrong.sj").read_text() == WRONG
    assert "ugly.sj was reformatted" in shown.out
    assert "3 files: 1 reformatted, 1 unchanged, 1 with errors" in shown.out


def test_folders_are_searched_but_not_hidden_ones(sjdsl: Sjdsl, folder: Path) -> None:
    for name in ("inner", ".hidden", "empty"):
        (folder / name).mkdir()
    (folder / "inner/one.sj").write_text(UGLY)
    (folder / ".hidden/two.sj").write_text(UGLY)
    assert "inner/one.sj was reformatted" in sjdsl("fmt . inner").out
    assert (folder / ".hidden/two.sj").read_text() == UGLY
    assert "no `.sj` files in the folder empty" in sjdsl("fmt empty").err


def test_line_ends_stay(sjdsl: Sjdsl, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    formatted = (folder / "orchard.sj").read_bytes().replace(b"\n", b"\r\n")
    ugly = UGLY.replace("\n", "\r\n").encode()
    (folder / "orchard.sj").write_bytes(formatted)
    (folder / "ugly.sj").write_bytes(ugly)
    assert sjdsl("fmt --check orchard.sj").status == 0
    assert sjdsl("fmt --check ugly.sj").status == 1
    for content, status in ((formatted, 0), (ugly, 1)):
        monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=io.BytesIO(content)))
        assert sjdsl("fmt --check -").status == status
    sjdsl("fmt orchard.sj ugly.sj")
    assert (folder / "orchard.sj").read_bytes() == formatted
    assert (folder / "ugly.sj").read_bytes() == formatted.replace(
        b"episode length", b"episode length  # steps"
    )


@pytest.mark.parametrize(
    ("text", "option", "status"), [(UGLY, None, 0), (UGLY, "--check", 1), (WRONG, None, 1)]
)
def test_standard_input(
    sjdsl: Sjdsl, monkeypatch: pytest.MonkeyPatch, text: str, option: str | None, status: int
) -> None:
    monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=io.BytesIO(text.encode())))
    shown = sjdsl("fmt -", *([option] if option else []))
    assert shown.status == status
    match text, option:
        case _, "--check":
            assert shown.out == "standard input would be reformatted\n"
        case str(), None if text == WRONG:
            assert "standard input" in shown.err
            assert "did you mean `schedule`?" in shown.err
            assert "shedule walk" in shown.err, "the line itself"
            assert shown.out == ""
        case _:
            assert shown.out.startswith('sj 1\ngame orchard "A Small Orchard" {\n')
            assert "  episode length  # steps\n" in shown.out
