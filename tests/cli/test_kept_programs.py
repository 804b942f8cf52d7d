"""A second start: programs that JAX compiled in one process are found by the next."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import GAME

from sjdsl.library.cache import keep_programs

VARIABLE = "JAX_COMPILATION_CACHE_DIR"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("SJDSL_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv(VARIABLE, "")  # so that it is put back as it was
    monkeypatch.delenv(VARIABLE)
    return tmp_path / "cache" / "programs"


def test_jax_is_told_where(folder: Path) -> None:
    keep_programs()
    assert os.environ[VARIABLE] == str(folder)
    assert folder.is_dir()


@pytest.mark.usefixtures("folder")
def test_another_folder_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "elsewhere")
    keep_programs()
    assert os.environ[VARIABLE] == "elsewhere"


@pytest.mark.usefixtures("folder")
def test_no_folder_is_no_error(tmp_path: Path) -> None:
    (tmp_path / "cache").write_text("a file where the folder should be")
    keep_programs()
    assert VARIABLE not in os.environ


@pytest.mark.slow
def test_a_damaged_program_is_compiled_again(folder: Path, tmp_path: Path) -> None:
    """Three starts of a command: what the first keeps, the second finds; what is damaged before the third is no error in it."""
    game = tmp_path / "orchard.sj"
    game.write_text(GAME)
    environment = {
        **os.environ,
        "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0",
        "JAX_PLATFORMS": "cpu",
    }

    def render(name: str) -> bytes:
        picture = tmp_path / name
        command = [
            sys.executable,
            "-m",
            "sjdsl",
            "render",
            str(game),
            "--steps",
            "2",
            "-o",
            str(picture),
        ]
        done = subprocess.run(
            command, env=environment, capture_output=True, text=True, timeout=300, check=False
        )
        assert done.returncode == 0, done.stderr
        return picture.read_bytes()

    first = render("first.gif")
    kept = {path.name: path.stat().st_mtime_ns for path in folder.rglob("*-cache")}
    assert kept
    assert render("second.gif") == first
    assert {path.name: path.stat().st_mtime_ns for path in folder.rglob("*-cache")} == kept
    for path in folder.rglob("*-cache"):
        path.write_bytes(b"no program")
    assert render("third.gif") == first
