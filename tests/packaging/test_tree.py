"""What holds for the whole tree: files stay short enough to read, and the wheel holds every package."""

import tomllib
from pathlib import Path

REPOSITORY = Path(__file__).parents[2]
CEILING = 400
OURS = ("bench", "sjdsl", "tests", "trainers")


def test_no_file_is_longer_than_the_ceiling() -> None:
    files = [path for folder in OURS for path in (REPOSITORY / folder).rglob("*.py") if "golden" not in path.parts]
    lengths = {path.relative_to(REPOSITORY).as_posix(): len(path.read_text("utf-8").splitlines()) for path in files}
    too_long = {name: length for name, length in lengths.items() if length > CEILING}
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
