"""What holds for the whole tree: files and functions stay short enough to read, and the wheel holds every package."""

import ast
import tomllib
from pathlib import Path

from tests.conftest import LONGEST

REPOSITORY = Path(__file__).parents[2]
CEILING = 410
LONGEST_FUNCTION = 60  # lines, decorators not counted
OURS = ("bench", "sjdsl", "tests", "trainers")


def test_no_file_is_longer_than_the_ceiling() -> None:
    files = [path for folder in OURS for path in (REPOSITORY / folder).rglob("*.py") if "golden" not in path.parts]
    lengths = {path.relative_to(REPOSITORY).as_posix(): len(path.read_text("utf-8").splitlines()) for path in files}
    too_long = {name: length for name, length in lengths.items() if length > CEILING}
    assert not too_long


def test_no_function_is_longer_than_a_screen() -> None:
    too_long = {}
    for path in (path for folder in ("sjdsl", "trainers") for path in (REPOSITORY / folder).rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                assert node.end_lineno is not None
                length = node.end_lineno - node.lineno + 1
                if length > LONGEST_FUNCTION:
                    too_long[f"{path.relative_to(REPOSITORY).as_posix()}:{node.lineno} {node.name}"] = length
    assert not too_long


def test_every_package_is_in_the_wheel() -> None:
    listed = set(tomllib.loads((REPOSITORY / "pyproject.toml").read_text("utf-8"))["tool"]["setuptools"]["packages"])
    folders = {path.parent for path in (REPOSITORY / "sjdsl").rglob("__init__.py")}
    found = {".".join(folder.relative_to(REPOSITORY).parts) for folder in folders}
    assert listed == found | {"sjdsl.games", "sjdsl.trainers"}


def test_requirements_are_pinned() -> None:
    lines = (REPOSITORY / "requirements.txt").read_text("utf-8").splitlines()
    pins = [line for line in lines if not line.startswith("#")]
    assert all(line.count("==") == 1 and " " not in line for line in pins)
    names = {line.split("==")[0].lower() for line in pins}
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text("utf-8"))["project"]
    wanted = project["dependencies"] + project["optional-dependencies"]["test"]
    assert {text.split(">=")[0] for text in wanted} <= names


def test_the_longest_files_of_tests_are_there() -> None:
    """A file that was renamed would come late, and one worker would wait for the other."""
    assert [name for name in LONGEST if not (REPOSITORY / "tests" / name).is_file()] == []
    assert len(set(LONGEST)) == len(LONGEST)
