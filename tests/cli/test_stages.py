"""No long silence: commands say what they are at, and what is wrong with a call is said before anything slow begins."""

import pytest
from command_line import Sjdsl

from sjdsl.cli.stages import stages, status_line


def test_stages_are_lines_where_nobody_watches(capsys: pytest.CaptureFixture[str]) -> None:
    with stages("loading [red]") as say:
        say("playing")
    assert capsys.readouterr().err.splitlines() == ["loading [red]", "playing"]


def test_stages_have_their_time_on_a_terminal(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    monkeypatch.setenv("TERM", "xterm")
    with stages("loading [red]") as say:
        say("playing")
    shown = capsys.readouterr().err
    assert "playing" in shown
    assert "0:00:00" in shown
    assert shown.endswith("\x1b[2K"), "the line vanishes"


def test_tests_say_what_they_are_at(sjdsl: Sjdsl) -> None:
    shown = sjdsl("test", "orchard.sj", "--examples", "1")
    assert "testing the checks of orchard.sj" in shown.err


def test_a_status_line_makes_room_for_what_is_printed(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    monkeypatch.setenv("TERM", "xterm")
    with status_line("testing [red]") as status:
        status.show("trajectory 7 of 400")
        with status.hidden():
            print("a verdict")
            captured = capsys.readouterr()
        assert captured.out == "a verdict\n"
        assert "testing [red]: trajectory 7 of 400" in captured.err
        assert captured.err.endswith("\x1b[2K"), "the line is gone while the verdict is printed"
    assert capsys.readouterr().err.endswith("\x1b[2K"), "the line vanishes"


def test_a_status_line_makes_no_noise_elsewhere(capsys: pytest.CaptureFixture[str]) -> None:
    with status_line("testing [red]") as status:
        status.show("trajectory 7 of 400")
        with status.hidden():
            print("a verdict")
    assert capsys.readouterr() == ("a verdict\n", "testing [red]\n")
