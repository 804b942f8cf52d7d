"""A folder that is not there is asked for, not made: it may be a typing mistake, and nothing has been played or measured by then."""

import sys
from pathlib import Path

import click
import pytest
from command_line import Sjdsl


@pytest.mark.parametrize("answer", [True, False])
def test_on_a_terminal_it_is_asked_for(
    sjdsl: Sjdsl, folder: Path, monkeypatch: pytest.MonkeyPatch, answer: bool
) -> None:
    asked: list[str] = []
    monkeypatch.setattr(sys.stdin, "isatty", lambda: True, raising=False)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    monkeypatch.setattr(click, "confirm", lambda question, **_: asked.append(question) or answer)
    shown = sjdsl("doc orchard.sj -o deep/down/a.md")
    assert asked == ["There is no folder `deep/down` to write a.md to. Make it?"]
    assert (folder / "deep/down/a.md").is_file() == answer
    assert shown.status == int(not answer)
    assert ("nothing was written" in shown.err) == (not answer)


READ_ONLY = Path("/proc")


@pytest.mark.skipif(not READ_ONLY.is_dir(), reason="there is no folder that nobody can write to")
@pytest.mark.parametrize(
    "call",
    [
        "schelling orchard.sj --cooperators stay --defectors random -o /proc/deep/diagram",
        "crossplay orchard.sj --policies stay -o /proc/met",
        "evaluate random --game orchard.sj -o /proc/a.json",
        "record orchard.sj -o /proc/a.npz",
        "play orchard.sj --record /proc/a.json",
        "bench orchard.sj --json /proc/new/a.json",
        "report . -o /proc/report",
    ],
)
def test_a_place_that_cannot_be_written_is_refused_before_anything_is_played(
    call: str, sjdsl: Sjdsl
) -> None:
    refused = sjdsl(call)
    assert refused.status == 1
    assert refused.err.startswith("error: nothing can be written to `/proc`: "), refused.text
