"""Programs that were compiled wrongly once, made small: the first line of each says what was wrong."""

from pathlib import Path

import pytest

from tests.fuzz.judge import TRACED, judge
from tests.fuzz.programs import Program

SLOW = {"thousands_of_additions"}
FOUND = sorted((Path(__file__).parent / "found").glob("*.sj"))


@pytest.mark.parametrize(
    "jit", [False, pytest.param(True, marks=pytest.mark.slow)], ids=["numpy", "jax"]
)
@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, marks=pytest.mark.thorough) if path.stem in SLOW else path
        for path in FOUND
    ],
    ids=lambda path: path.stem,
)
def test_interpreter_and_compiled_agree(path: Path, jit: bool) -> None:
    (verdict,) = judge(Program(path.read_text("utf-8")), seed=TRACED, steps=20, jit=jit)
    assert verdict.accepted, verdict.messages
    assert not verdict.fault
    assert verdict.steps == 20
