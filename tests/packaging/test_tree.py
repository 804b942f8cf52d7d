"""What holds for the whole tree: the wheel holds every package, and lists of files name files that exist."""

import tomllib
from pathlib import Path

from tests.conftest import LONGEST

REPOSITORY = Path(__file__).parents[2]


def test_every_package_is_in_the_wheel() -> None:
    listed = set(
        tomllib.loads((REPOSITORY / "pyproject.toml").read_text("utf-8"))["tool"]["setuptools"][
            "packages"
        ]
    )
    inits = [
        path for name in ("sjdsl", "trainers") for path in (REPOSITORY / name).rglob("__init__.py")
    ]
    folders = {".".join(path.parent.relative_to(REPOSITORY).parts) for path in inits}
    packages = {f"sjdsl.{name}" if name.startswith("trainers") else name for name in folders}
    assert listed == packages | {"sjdsl.games"}


def test_requirements_are_pinned() -> None:
    lines = (REPOSITORY / "requirements.txt").read_text("utf-8").splitlines()
    pins = [line for line in lines if not line.startswith("#")]
    assert all(line.count("==") == 1 and " " not in line for line in pins)
    names = {line.split("==")[0].lower() for line in pins}
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text("utf-8"))["project"]
    extras, wanted, waiting = (
        project["optional-dependencies"],
        set(),
        [*project["dependencies"], "sjdsl[test]"],
    )
    assert len(project["dependencies"]) <= 14, "what only some users want is an extra"
    while waiting:
        name, _, brought = waiting.pop().partition(">=")[0].partition("[")
        if name == "sjdsl":
            waiting += [text for extra in brought.rstrip("]").split(",") for text in extras[extra]]
        else:
            wanted.add(name)
    assert {"jax", "pytest", "pygls"} <= wanted <= names


def test_the_longest_files_of_tests_are_there() -> None:
    """A file that was renamed would come late, and one worker would wait for the other."""
    assert [name for name in LONGEST if not (REPOSITORY / "tests" / name).is_file()] == []
    assert len(set(LONGEST)) == len(LONGEST)
