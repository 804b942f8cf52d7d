"""No long silence: commands say what they are at."""

import pytest
from command_line import Sjdsl

from sjdsl.cli.stages import stages


def test_stages_are_lines_where_nobody_watches(capsys: pytest.CaptureFixture[str]) -> None:
    with stages("loading [red]") as say:
        say("playing")
    assert capsys.readouterr().err.splitlines() == ["loading [red]", "playing"]


def test_tests_say_what_they_are_at(sjdsl: Sjdsl) -> None:
    shown = sjdsl("test", "orchard.sj", "--examples", "1")
    assert "testing the checks of orchard.sj" in shown.err
