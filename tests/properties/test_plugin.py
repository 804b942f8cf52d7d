"""`pytest --sj` in a folder of an author: one test a check, under its own text, and nothing at all without `--sj`."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import sjdsl

from .small_games import ORCHARD

CHECKS = """require regrow <= 0.5
    conserved count(tree where tree.col > 1)
    always apples[ripe] >= 0.0
    always apples[ripe] < 1.5
    always apples[ripe] < 1.5"""
WITH_WORDS = (("tally eaten for agent", "tally apples[ripe] for agent"), ("event eaten ", "event apples by { none, ripe } "))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with one game."""
    (tmp_path / "orchard.sj").write_text(orchard(CHECKS))
    return tmp_path


def orchard(checks: str) -> str:
    text = ORCHARD.format(rule="each agent where agent chose zap { tally zaps for agent }", checks=checks, more="")
    for before, after in WITH_WORDS:
        text = text.replace(before, after)
    return text


OPTIONS = ("-p", "no:cacheprovider", "-p", "no:xdist", "-p", "no:asyncio", "--sj-examples", "20")


@pytest.fixture
def run(folder: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, list[str]]]:
    """Runs pytest in the folder, in this process; returns the exit status and the lines."""
    monkeypatch.chdir(folder)
    monkeypatch.setenv("COLUMNS", "140")

    def run_here(*arguments: str) -> tuple[int, list[str]]:
        capfd.readouterr()
        status = pytest.main([*OPTIONS, "--rootdir", str(folder), *arguments])
        said = capfd.readouterr()
        return int(status), (said.out + said.err).splitlines()

    return run_here


def run_apart(folder: Path, *arguments: str) -> tuple[int, list[str]]:
    """Returns the exit status and the lines of a pytest in a process of its own."""
    home = str(Path(sjdsl.__file__).parents[1])
    command = [sys.executable, "-m", "pytest", *OPTIONS, *arguments]
    done = subprocess.run(
        command, cwd=folder, env={**os.environ, "PYTHONPATH": home, "COLUMNS": "140"}, capture_output=True, text=True, check=False
    )
    return done.returncode, (done.stdout + done.stderr).splitlines()


def test_a_check_is_a_test_under_its_own_text(run: Callable[..., tuple[int, list[str]]]) -> None:
    status, lines = run("--sj", "-v")
    assert status == 1
    said = [line.split("::", 1)[1].rsplit("[", 1)[0].strip() for line in lines if line.startswith("orchard.sj::")]
    assert said == [
        "require regrow <= 0.5 PASSED",
        "conserved count(tree where tree.col > 1) PASSED",
        "always apples[ripe] >= 0.0 PASSED",
        "always apples[ripe] < 1.5 FAILED",
        "always apples[ripe] < 1.5 (2) FAILED",
    ]
    line = next(i for i, text in enumerate(orchard(CHECKS).splitlines(), 1) if "< 1.5" in text)
    start = lines.index(f"orchard.sj:{line}: the check failed: always apples[ripe] < 1.5")
    told = lines[start : start + next(i for i, text in enumerate(lines[start:]) if text.startswith("  apples[ripe] = "))]
    assert told[1].startswith("fails after step ")
    assert any(line.startswith("  step ") for line in told)
    assert not any("Traceback" in line or "pytest_plugin.py" in line for line in lines)


@pytest.mark.thorough
def test_one_check_can_be_chosen(run: Callable[..., tuple[int, list[str]]]) -> None:
    status, lines = run("--sj", "-v", "orchard.sj::always apples[ripe] >= 0.0")
    assert status == 0
    assert "1 passed" in lines[-1]


@pytest.mark.thorough
def test_an_untested_check_is_skipped_and_fails_if_strict(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The rule of the check runs in step 900, an episode has 20."""
    rule = "each tree where step > 900 { set tree.fruit = ripe }"
    path = folder / "late.sj"
    path.write_text(ORCHARD.format(rule=rule, checks="once fruit == 0 always fruit == 0", more=""))
    monkeypatch.chdir(folder)
    options = ["-p", "no:cacheprovider", "-p", "no:xdist", "-rs", "--sj", "--sj-examples", "10", str(path)]
    assert pytest.main(options) == pytest.ExitCode.OK
    said = capsys.readouterr().out
    assert "1 skipped" in said
    assert "untested: these lines never ran" in said
    assert pytest.main([*options, "--sj-strict"]) == pytest.ExitCode.TESTS_FAILED
    said = capsys.readouterr().out
    assert "the check is untested: once fruit == 0 always fruit == 0" in said
    assert "set tree.fruit = ripe" in said


def test_mistakes_are_told_without_a_traceback(folder: Path, run: Callable[..., tuple[int, list[str]]]) -> None:
    (folder / "orchard.sj").write_text(orchard("always appels[ripe] >= 0"))
    status, lines = run("--sj")
    assert status == 2
    assert any("`appels`" in line for line in lines)
    assert not any("Traceback" in line for line in lines)


@pytest.mark.thorough
def test_without_the_option_nothing_happens(folder: Path) -> None:
    (folder / "test_own.py").write_text(
        "import sys\n\n\ndef test_own():\n    assert not {'jax', 'lark', 'sjdsl.properties'} & set(sys.modules)\n"
    )
    status, lines = run_apart(folder)
    assert status == 0
    assert "1 passed" in lines[-1]
    status, lines = run_apart(folder, "orchard.sj")
    assert status != 0
    assert not any("always" in line for line in lines)
