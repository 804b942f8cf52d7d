"""No long silence: commands say what they are at."""

import pytest

from sjdsl.cli.stages import stages


def test_stages_are_lines_where_nobody_watches(capsys: pytest.CaptureFixture[str]) -> None:
    with stages("loading [red]") as say:
        say("playing")
    assert capsys.readouterr().err.splitlines() == ["loading [red]", "playing"]
