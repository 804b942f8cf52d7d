"""The wheel alone: installed where nothing of this tree can be seen, it compiles, lists, makes and trains."""

import importlib.metadata
import shutil
import subprocess
import sys
import sysconfig
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
USE = """
import pathlib, sjdsl, sjdsl.trainers, sjdsl.bench, sjdsl.render
from sjdsl.compiler.explanations import explain
assert "site-packages" in sjdsl.__file__, sjdsl.__file__
assert sjdsl.make("coins").num_agents == 2
assert sjdsl.make("my_game.sj").num_agents == 1
assert sjdsl.trainers.load_preset("quick").game == "coins"
assert explain("SJ101")
"""


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Returns a fresh environment that holds the wheel, and sees the other packages of this one."""
    if SETUPTOOLS < (77,):
        pytest.skip("building a wheel takes setuptools 77 or newer")
    source, folder = tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("installed")
    for name in SHIPPED:
        if (REPOSITORY / name).is_dir():
            shutil.copytree(REPOSITORY / name, source / name, ignore=shutil.ignore_patterns("__pycache__"))
        elif (REPOSITORY / name).is_file():
            shutil.copy(REPOSITORY / name, source / name)
    _run(sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "--no-build-isolation", "-w", "dist", ".", cwd=source)
    (wheel,) = (source / "dist").glob("*.whl")
    _run(sys.executable, "-m", "venv", "--without-pip", "empty", cwd=folder)
    python = folder / "empty/bin/python"
    _run(sys.executable, "-m", "pip", "--python", python, "install", "-q", "--no-deps", wheel, cwd=folder)
    (folder / "others").mkdir()
    for path in Path(sysconfig.get_path("purelib")).iterdir():
        if "sjdsl" not in path.name and path.suffix != ".pth":
            (folder / "others" / path.name).symlink_to(path)
    (_site_packages(folder) / "others.pth").write_text(f"{folder / 'others'}\n")
    return folder


def _run(*command: str | Path, cwd: Path) -> str:
    done = subprocess.run([str(part) for part in command], cwd=cwd, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def _site_packages(folder: Path) -> Path:
    return next((folder / "empty/lib").glob("python*/site-packages"))


def test_only_sjdsl_is_installed(installed: Path) -> None:
    names = {path.name for path in _site_packages(installed).iterdir() if path.name != "__pycache__"}
    assert {name for name in names if not name.endswith((".dist-info", ".pth"))} == {"sjdsl"}


def test_it_works_in_an_empty_folder(installed: Path, tmp_path: Path) -> None:
    (tmp_path / "my_game.sj").write_text(GAME)
    shell = installed / "empty/bin"
    assert "generated/my_game.py" in _run(shell / "sjdsl", "compile", "my_game.sj", cwd=tmp_path)
    assert "clean_up" in _run(shell / "sjdsl", "list", cwd=tmp_path)
    assert "no problems" in _run(shell / "sjdsl", "check", "my_game.sj", "coins", cwd=tmp_path)
    _run(shell / "python", "-c", USE, cwd=tmp_path)
