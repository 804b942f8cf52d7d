"""The typed rules and the module of five small games against stored texts; the same bytes wherever and whenever."""

import hashlib
import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterable
from pathlib import Path

import pytest

from sjdsl import __version__
from sjdsl.cli.dump import STAGES, dump
from sjdsl.compiler.syntax.read import read_source

TESTS = Path(__file__).parent.parent
CASES = sorted((TESTS / "cases").glob("*.sj"))
GAMES = sorted((TESTS.parent / "games").glob("*.sj"))
GOLDEN = TESTS / "golden"
EXEMPLARS = ("beams", "chances", "endings", "matching", "rows")


def text(path: Path, stage: str) -> str:
    return "".join(f"{line}\n" for line in dump(read_source(path), stage, positions=False))


def digests(work: Iterable[tuple[Path, str]]) -> dict[str, str]:
    """Returns a digest of each stage of each file."""
    return {
        f"{path.name} {stage}": hashlib.sha256(text(path, stage).encode()).hexdigest()
        for path, stage in work
    }


@pytest.mark.parametrize("stage", ["ir", "python"])
@pytest.mark.parametrize("name", EXEMPLARS)
def test_stage(name: str, stage: str, golden: Callable[[Path, str], None]) -> None:
    """The release and the hash of the rules are left out: both change without a change of the text."""
    printed = text(TESTS / "cases" / f"{name}.sj", stage).replace(f"sjdsl {__version__}", "sjdsl")
    without_hash = re.sub(r"(Game hash |HASH = .)\w{16}", r"\1", printed)
    golden(GOLDEN / stage / f"{name}.txt", without_hash)


@pytest.mark.thorough
def test_the_same_bytes_twice_elsewhere_and_in_another_order(tmp_path: Path) -> None:
    """In another process, folder, order and with other hashes of strings."""
    work = [
        *((case, stage) for case in CASES for stage in STAGES),
        *((game, stage) for game in GAMES for stage in ("ast", "python")),
    ]
    here = digests(work)
    assert digests(work[:20]) == {name: here[name] for name in list(here)[:20]}
    order = repr([(str(path), stage) for path, stage in reversed(work)])
    environment = {**os.environ, "PYTHONHASHSEED": "12345", "PYTHONPATH": str(TESTS.parent)}
    program = (
        "import ast, json, pathlib; from tests.compiler.test_goldens import digests\n"
        "print(json.dumps(digests((pathlib.Path(path), stage) for path, stage in ast.literal_eval(input()))))"
    )
    found = subprocess.run(
        [sys.executable, "-c", program],
        input=order,
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=environment,
        check=True,
    )
    assert sorted(here.items()) == sorted(json.loads(found.stdout).items())
