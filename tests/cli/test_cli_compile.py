"""`sjdsl compile`: the same bytes for the same game, and a check that they are there."""

from pathlib import Path

import pytest
from command_line import GAME, Sjdsl


def test_it_writes_a_module_and_says_so(sjdsl: Sjdsl, folder: Path) -> None:
    shown = sjdsl("compile orchard.sj")
    written = folder / "generated" / "orchard.py"
    assert shown.status == 0
    text = written.read_text()
    assert (
        f"generated/orchard.py  {len(text) / 1000:.1f} kB  {len(text.splitlines())} lines"
        in shown.out
    )
    compile(text, str(written), "exec")


def test_a_variant_has_a_file_of_its_own(sjdsl: Sjdsl, folder: Path) -> None:
    sjdsl("compile orchard.sj --variant rich")
    assert [p.name for p in (folder / "generated").iterdir()] == ["orchard_rich.py"]


def test_bytes_do_not_depend_on_the_folder(
    sjdsl: Sjdsl, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sjdsl("compile orchard.sj -o here.py")
    (folder / "below").mkdir()
    monkeypatch.chdir(folder / "below")
    sjdsl("compile ../orchard.sj -o there.py")
    sjdsl("compile", folder / "orchard.sj", "-o", "third.py")
    first = (folder / "here.py").read_bytes()
    assert (folder / "below/there.py").read_bytes() == first
    assert (folder / "below/third.py").read_bytes() == first
    assert str(folder).encode() not in first


def test_check_finds_what_differs_or_is_missing(sjdsl: Sjdsl, folder: Path) -> None:
    assert "generated/orchard.py is missing" in sjdsl("compile orchard.sj --check").out
    assert not (folder / "generated").exists()
    sjdsl("compile orchard.sj")
    assert sjdsl("compile orchard.sj --check").status == 0
    (folder / "orchard.sj").write_text(
        GAME.replace("give apple to agent", "give apple + apple to agent")
    )
    shown = sjdsl("compile orchard.sj --check")
    assert shown.status == 1
    assert "generated/orchard.py differs from what its game compiles to now" in shown.out
