"""A folder that is not there is asked for, not made: it may be a typing mistake, and nothing has been played or measured by then."""

import sys
from pathlib import Path

import click
import pytest
from command_line import Sjdsl

CALLS = [
    ["render", "orchard.sj", "-o", "lost/a.gif"],
    ["render", "orchard.sj", "-o", "lost/a.png"],
    ["compile", "orchard.sj", "-o", "lost"],
    ["compile", "orchard.sj", "-o", "lost/a.py"],
    ["doc", "orchard.sj", "-o", "lost/a.md"],
    ["new", "pond", "-o", "lost"],
    ["play", "orchard.sj", "--watch", "--record", "lost/a.json"],
    ["replay", "none.json", "-o", "lost/a.gif"],
    ["evaluate", "runs/some", "--film", "lost/a.gif"],
    ["plot", "runs/some", "-o", "lost/a.png"],
]


@pytest.mark.parametrize("call", CALLS, ids=" ".join)
def test_where_nobody_can_be_asked_it_is_an_error(sjdsl: Sjdsl, folder: Path, call: list[str]) -> None:
    shown = sjdsl(*call)
    assert shown.status == 1
    assert "there is no folder `lost`" in shown.err
    assert "make it first (mkdir -p lost), or name another place" in shown.err
    assert not (folder / "lost").exists()


@pytest.mark.parametrize("answer", [True, False])
def test_on_a_terminal_it_is_asked_for(sjdsl: Sjdsl, folder: Path, monkeypatch: pytest.MonkeyPatch, answer: bool) -> None:
    asked: list[str] = []
    monkeypatch.setattr(sys.stdin, "isatty", lambda: True, raising=False)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    monkeypatch.setattr(click, "confirm", lambda question, **_: asked.append(question) or answer)
    shown = sjdsl("doc", "orchard.sj", "-o", "deep/down/a.md")
    assert asked == ["There is no folder `deep/down` to write a.md to. Make it?"]
    assert (folder / "deep/down/a.md").is_file() == answer
    assert shown.status == int(not answer)
    assert ("nothing was written" in shown.err) == (not answer)


def test_a_file_is_no_folder(sjdsl: Sjdsl) -> None:
    shown = sjdsl("doc", "orchard.sj", "-o", "orchard.sj/a.md")
    assert shown.status == 1
    assert "`orchard.sj` is a file, not a folder to write a.md to" in shown.err


def test_recorded_episodes_are_not_written_over(sjdsl: Sjdsl, folder: Path) -> None:
    (folder / "orchard.npz").write_bytes(b"episodes of before")
    for call in (["record", "orchard.sj"], ["record", "orchard.sj", "-o", "orchard.npz"]):
        shown = sjdsl(*call)
        assert shown.status == 1
        assert "`orchard.npz` exists already; name another file with -o, or move it away" in shown.err
    assert (folder / "orchard.npz").read_bytes() == b"episodes of before"
