"""A stage that is `interpreted`: the same scenes, taken by the interpreter alone."""

from pathlib import Path
from typing import Any

import pytest

from sjdsl.testing import Scene, Stage

CAMP = Path(__file__).parent / "camp.sj"
ROWS = ("PPP..#", "..TT..", "..^^.<")


def played(interpreted: bool) -> Scene:
    return (
        Stage(CAMP, interpreted=interpreted)
        .put(*ROWS)
        .step("forward, forward, zap")
        .step("stay, turn_left")
    )


def test_it_shows_what_both_engines_show(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = played(False)
    monkeypatch.setattr(
        "sjdsl.testing.stage.compile_quickly", lambda *_: pytest.fail("nothing is compiled")
    )
    alone = played(True)
    assert alone.state is None
    assert alone.picture() == whole.picture()
    for what in ("reward", "events", "terminated", "truncated"):
        assert as_numbers(getattr(alone, what)) == as_numbers(getattr(whole, what)), what
    assert alone.metrics == pytest.approx(whole.metrics)
    assert (alone.observation == whole.observation).all()
    assert (alone.allowed == whole.allowed).all()
    assert alone.stage.start().observation.shape == whole.observation.shape  # type: ignore[attr-defined]


def as_numbers(value: Any) -> Any:
    return dict(value) if isinstance(value, dict) else value
