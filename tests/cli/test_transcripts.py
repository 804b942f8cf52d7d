"""Transcripts: calls of `sjdsl`, and what each says. `refused.txt` has what is refused, and in which words; `shown.txt` what is shown of games."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from command_line import GAME, GROVE

FILES = {
    "orchard.sj": GAME,
    "grove.sj": GROVE,
    "wrong.sj": GAME.replace("give apple", "give aple"),
    "orchard.npz": "episodes of before",
    "kept/notes.txt": "mine",
    "own.py": "def idle(key, observation):\n    return observation[:, 0, 0, 0]\n",
    "two_errors.sj": GAME.replace("send agent to floor", "send agent to flor").replace(
        "each agent on soil", "each agnt on soil"
    ),
    "wrong_variant.sj": GAME.replace("set apple = 2", "set aple = 2"),
    "unused.sj": GAME.replace("  episode length", "  param idle : reward = 1\n  episode length"),
    "idle.sj": GAME.replace("forward, stay", "forward, stay, dance").replace(
        "event eaten", "event eaten  event lost"
    ),
    "other.sj": GAME.replace("set soil.fruit = none  give", "give"),
    "sure.sj": GAME.replace("none: 0.1, ripe: 0", "none: 1, ripe: 0").replace(
        "{ none, ripe } = ripe", "{ none, ripe } = none"
    ),
}
SCRIPT = """
import contextlib, io, os, shlex, sys
from sjdsl.cli import run
for call in sys.stdin.read().splitlines():
    with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(io.StringIO()) as err:
        status = run(shlex.split(call)[1:])
    said = (out.getvalue() + err.getvalue()).replace(f"{os.getcwd()}/", "").splitlines()
    slow = sorted({"jax", "flax", "matplotlib", "hypothesis"} & {*sys.modules})
    print(f"$ {call}", *said, f"-> {status}" + (f", with {', '.join(slow)}" if slow else ""), "", sep="\\n")
"""


@pytest.mark.parametrize("name", ["refused.txt", "shown.txt"])
def test_a_transcript(name: str, tmp_path: Path, golden: Callable[[Path, str], None]) -> None:
    """All calls in one process, which write nothing; those above the first `with` import nothing that is slow to import."""
    for file, text in FILES.items():
        (tmp_path / file).parent.mkdir(exist_ok=True)
        (tmp_path / file).write_text(text)
    stored = Path(__file__).with_name(name)
    calls = "\n".join(line[2:] for line in stored.read_text().splitlines() if line.startswith("$ "))
    environment = {**os.environ, "JAX_PLATFORMS": "cpu"}
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT],
        input=calls,
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    golden(stored, done.stdout)
    kept = (path for path in tmp_path.rglob("*") if path.is_file() and path.suffix != ".pyc")
    assert sorted(FILES) == sorted(path.relative_to(tmp_path).as_posix() for path in kept)
