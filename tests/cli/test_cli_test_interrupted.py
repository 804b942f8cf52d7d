"""`sjdsl test` says verdicts as they are decided, and when interrupted what is decided and what is not."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from command_line import GAME, Sjdsl

from sjdsl.properties import Verification

CHECKS = """require apple >= 0
    always count(agent on wall) == 0
    always count(agent on soil where soil.fruit is ripe) == 0
    symmetric agents
    expect eaten == 0 with never(forward) over 3 episodes"""


@pytest.fixture
def game(folder: Path) -> Path:
    path = folder / "checked.sj"
    path.write_text(
        GAME.replace("  variant rich", f"  checks {{\n    {CHECKS}\n  }}\n  variant rich")
    )
    return path


@pytest.mark.usefixtures("game")
def test_a_verdict_is_said_before_the_next_check_is_tested(
    sjdsl: Sjdsl, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[str] = []
    order: list[str] = []
    decide: Callable[[Verification, int], Any] = Verification.verdict

    def watched(self: Verification, number: int) -> Any:
        if not self.has_played or number not in order:
            order.append(f"{number} after {len(said)}")
        return decide(self, number)

    monkeypatch.setattr(Verification, "verdict", watched)
    monkeypatch.setattr("sjdsl.cli.test.click.echo", lambda text, **_: said.append(text))
    sjdsl("test checked.sj --examples 5")
    assert order[:5] == [
        "0 after 1",
        "1 after 2",
        "2 after 3",
        "3 after 4",
        "4 after 5",
    ]  # the first is the heading


def interrupting(monkeypatch: pytest.MonkeyPatch, when: str) -> None:
    """Interrupts where the progress begins with some words."""
    made = Verification.__init__

    def begin(
        self: Verification, *arguments: Any, progress: Callable[[str], None], **named: Any
    ) -> None:
        def interrupted(said: str) -> None:
            progress(said)
            if said.startswith(when):
                raise KeyboardInterrupt

        made(self, *arguments, progress=interrupted, **named)

    monkeypatch.setattr(Verification, "__init__", begin)


@pytest.mark.usefixtures("game")
@pytest.mark.parametrize(
    ("when", "decided", "not_yet"),
    [
        (
            "0 steps",
            {"require", "symmetric"},
            {"always count(agent on wall)", "always count(agent on soil", "expect"},
        ),
        (
            "3 episodes of `expect",
            {"require", "symmetric", "always count(agent on wall)", "always count(agent on soil"},
            {"expect"},
        ),
    ],
)
def test_an_interruption_leaves_a_summary(
    when: str, decided: set[str], not_yet: set[str], sjdsl: Sjdsl, monkeypatch: pytest.MonkeyPatch
) -> None:
    interrupting(monkeypatch, when)
    shown = sjdsl("test checked.sj --seed 1 --examples 20")
    assert shown.status == 130
    assert "Traceback" not in shown.text
    lines = shown.out.splitlines()
    missed = ", 1 not passed" if "always count(agent on soil" in decided else ""
    assert lines[-1] == f"checked.sj: interrupted: {len(decided)} of 5 checks decided{missed}"
    for words, marks in ((decided, ("passed", "FAILED")), (not_yet, ("not yet",))):
        for word in words:
            (line,) = (
                line
                for line in lines
                if line.startswith("  ") and f"  {word}" in line and "checked.sj:" in line
            )
            assert line.strip().startswith(marks), line
