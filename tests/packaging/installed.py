"""The wheel, built from this tree, or the one that `SJDSL_WHEEL` names, and installed where nothing of the tree can be seen."""

import importlib.metadata
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[2]
SHIPPED = ("sjdsl", "games", "trainers", "pyproject.toml", "README.md", "LICENSE")
SETUPTOOLS = tuple(map(int, importlib.metadata.version("setuptools").split(".")[:1]))
GAME = """sj 1
game my_game "Mine" {
  episode 5
  kind floor "."
  map { "..." }
  agents 1 { acts forward, stay  moves relative }
  phase start { each agent { send agent to floor } }
  schedule walk
  phase walk { move each agent }
  observe { window ahead 1, behind 0, left 1, right 1 }
}
"""


@pytest.fixture(scope="session")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Returns a copy of what the wheel is made of, where building leaves nothing behind in the tree."""
    if SETUPTOOLS < (77,):
        pytest.skip("building a wheel takes setuptools 77 or newer")
    copied = tmp_path_factory.mktemp("source")
    for name in SHIPPED:
        if (REPOSITORY / name).is_dir():
            shutil.copytree(
                REPOSITORY / name, copied / name, ignore=shutil.ignore_patterns("__pycache__")
            )
        elif (REPOSITORY / name).is_file():
            shutil.copy(REPOSITORY / name, copied / name)
    return copied


@pytest.fixture(scope="session")
def wheel(request: pytest.FixtureRequest) -> Path:
    """Returns the wheel that is tested: one that has been built already, or one of this tree."""
    named = os.environ.get("SJDSL_WHEEL")
    return Path(named) if named else build_wheel(request.getfixturevalue("source"))


@pytest.fixture(scope="session")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Returns a fresh environment that holds the wheel, and sees the other packages of this one."""
    folder = tmp_path_factory.mktemp("installed")
    run_in(sys.executable, "-m", "venv", "--without-pip", "empty", cwd=folder)
    python = folder / "empty/bin/python"
    run_in(
        sys.executable,
        "-m",
        "pip",
        "--python",
        python,
        "install",
        "-q",
        "--no-deps",
        wheel,
        cwd=folder,
    )
    (folder / "others").mkdir()
    for place in [Path(place) for place in sys.path if Path(place).name == "site-packages"]:
        for path in place.iterdir():
            if (
                "sjdsl" not in path.name
                and path.suffix != ".pth"
                and not (folder / "others" / path.name).exists()
            ):
                (folder / "others" / path.name).symlink_to(path)
    (site_packages(folder) / "others.pth").write_text(f"{folder / 'others'}\n")
    return folder


def build_wheel(source: Path) -> Path:
    """Returns the wheel of a source tree or an unpacked sdist, in its folder `dist`."""
    run_in(
        sys.executable,
        "-m",
        "pip",
        "wheel",
        "-q",
        "--no-deps",
        "--no-build-isolation",
        "-w",
        "dist",
        ".",
        cwd=source,
    )
    (wheel,) = (source / "dist").glob("*.whl")
    return wheel


def run_in(*command: str | Path, cwd: Path) -> str:
    """Runs a command in a folder and returns what it printed; fails with all of that if the command does."""
    done = subprocess.run(
        [str(part) for part in command], cwd=cwd, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def site_packages(folder: Path) -> Path:
    """Returns where an environment keeps its packages."""
    return next((folder / "empty/lib").glob("python*/site-packages"))
