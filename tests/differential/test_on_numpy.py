"""Games written to be awkward about one construct each: the compiled step, run on NumPy, equals the interpreter."""

from pathlib import Path

import pytest

from tests.fuzz.judge import TRACED, judge
from tests.fuzz.programs import Program

GAMES = sorted((Path(__file__).parent / "on_numpy").glob("*.sj"))


@pytest.mark.parametrize("seed", [TRACED, pytest.param(TRACED + 1, marks=pytest.mark.thorough)])
@pytest.mark.parametrize("path", GAMES, ids=lambda path: path.stem)
def test_interpreter_and_compiled_agree(path: Path, seed: int) -> None:
    (verdict,) = judge(Program(path.read_text("utf-8")), seed=seed, steps=20, jit=False)
    assert verdict.accepted, verdict.messages
    assert not verdict.fault
    assert verdict.steps == 20
