"""The page about testing tells the truth: its tests pass under plain pytest, far from this folder, and its failure is shown as it is."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

PAGE = (Path(__file__).parents[2] / "docs" / "testing.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


SHOWN = """
from pathlib import Path

from test_orchard import STAGE


def test_failure():
    try:
        {block}
    except AssertionError as failure:
        (Path(__file__).parent / "failure.txt").write_text(str(failure))
"""


@pytest.mark.thorough
def test_its_tests_pass_under_plain_pytest_and_its_failure_is_shown(tmp_path: Path) -> None:
    files = {
        "orchard.sj": blocks("sj")[0],
        "test_orchard.py": blocks("python")[0],
        "test_shown.py": SHOWN.format(block=blocks("python")[1]),
    }
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-p",
        "no:cacheprovider",
        "-q",
        "--rootdir",
        str(tmp_path),
        str(tmp_path),
    ]
    run = subprocess.run(
        command,
        cwd=tmp_path,
        env={**os.environ, "PYTEST_ADDOPTS": ""},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stdout
    assert f"{1 + blocks('python')[0].count('def test_')} passed" in run.stdout
    failure = (tmp_path / "failure.txt").read_text(encoding="utf-8")
    assert failure.splitlines() == blocks("text")[0].splitlines()


@pytest.mark.thorough
def test_its_test_of_checks_passes_and_fails_as_the_checks_do(tmp_path: Path) -> None:
    (tmp_path / "games").mkdir()
    for name, check in (("good", "always count(agent) == 2"), ("bad", "require nap > 3")):
        text = blocks("sj")[0].replace(
            "  metrics { event eaten }", f"  metrics {{ event eaten }}\n  checks {{ {check} }}"
        )
        (tmp_path / "games" / f"{name}.sj").write_text(text, encoding="utf-8")
    names = {"__file__": str(tmp_path / "test_checks.py")}
    exec(blocks("python")[-1], names)
    ((_, games),) = (mark.args for mark in names["test_checks"].pytestmark)
    bad, good = games
    names["test_checks"](good)
    with pytest.raises(AssertionError, match="require nap > 3"):
        names["test_checks"](bad)
