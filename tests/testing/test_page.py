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


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "orchard.sj").write_text(blocks("sj")[0], encoding="utf-8")
    (tmp_path / "test_orchard.py").write_text(blocks("python")[0], encoding="utf-8")
    return tmp_path


def test_its_tests_pass_under_plain_pytest(folder: Path) -> None:
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-q", "--rootdir", str(folder), str(folder)]
    run = subprocess.run(command, cwd=folder, env={**os.environ, "PYTEST_ADDOPTS": ""}, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout
    assert f"{blocks('python')[0].count('def test_')} passed" in run.stdout


def test_its_failure(folder: Path) -> None:
    names: dict = {"__file__": str(folder / "test_orchard.py")}
    exec(blocks("python")[0], names)
    with pytest.raises(AssertionError) as failure:
        exec(blocks("python")[1], names)
    assert str(failure.value).splitlines() == [line.rstrip() for line in blocks("text")[0].splitlines()]


def test_its_table_names_what_there_is() -> None:
    """Every method and argument of a stage and of a scene is on the page."""
    import inspect

    from sjdsl.testing import Scene, Stage

    methods = [f for cls in (Stage, Scene) for name, f in vars(cls).items() if inspect.isfunction(f) and name[0] != "_"]
    told = {f.__name__ for f in methods} - {"numbers", "compare_start"}  # between the two classes
    told |= {name for f in methods for name in inspect.signature(f).parameters} - {"self", "board", "name", "plane"}
    told |= set(inspect.signature(Stage).parameters)
    assert {name for name in told if not re.search(rf"\b{name}\b", PAGE)} == set()
