"""A user without a home folder, as in many containers: nothing is cached, and everything works."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import GAME

import sjdsl as package
from sjdsl.library.cache import cache_folder
from sjdsl.studio.access import kept_token


@pytest.fixture(autouse=True)
def _homeless(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("HOME", "XDG_CACHE_HOME", "SJDSL_CACHE", "JAX_COMPILATION_CACHE_DIR"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("pwd.getpwuid", _unknown)


def _unknown(number: int) -> None:
    raise KeyError(f"getpwuid(): uid not found: {number}")


def test_there_is_no_cache() -> None:
    assert cache_folder() is None
    assert kept_token(None) != kept_token(None)


def test_a_game_is_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "orchard.sj").write_text(GAME)
    assert package.make("orchard.sj").num_agents == 2
    assert os.listdir() == ["orchard.sj"]


HOMELESS = """
import pwd, sys
def unknown(number): raise KeyError("getpwuid(): uid not found")
pwd.getpwuid = unknown
from sjdsl.cli import main
sys.exit(main())
"""


@pytest.mark.parametrize("arguments", [["--version"], ["check", "orchard.sj"], ["list"]])
def test_commands_work(arguments: list[str], tmp_path: Path) -> None:
    (tmp_path / "orchard.sj").write_text(GAME)
    ran = subprocess.run(
        [sys.executable, "-c", HOMELESS, *arguments], cwd=tmp_path, capture_output=True, text=True
    )
    assert (ran.returncode, ran.stderr) == (0, "")
