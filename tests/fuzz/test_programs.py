"""Random programs: the interpreter and the compiled game go one way, with every pass and with none; `make fuzz` takes more of them."""

from functools import partial
from zlib import crc32

import pytest
from hypothesis import Phase, given, settings

from tests.fuzz.judge import judge
from tests.fuzz.kept import keep
from tests.fuzz.programs import Program, programs

# A failure is made small by leaving out parts of the text, not by other programs.
few = partial(settings, derandomize=True, deadline=None, database=None, phases=[Phase.generate])


@few(max_examples=3)
@given(programs)
def test_interpreter_equals_compiled(made: Program) -> None:
    examine(made)


@pytest.mark.thorough
@few(max_examples=30)
@given(programs)
def test_interpreter_equals_compiled_in_more_programs(made: Program) -> None:
    examine(made)


@pytest.mark.thorough
@few(max_examples=2)
@given(programs)
def test_interpreter_equals_compiled_by_jax(made: Program) -> None:
    examine(made, jit=True)


def examine(made: Program, jit: bool = False) -> None:
    """Fails with the smallest program found that goes wrong in the same way, kept in a file."""
    seed = crc32(made.text.encode()) % 2**16
    again = partial(judge, seed=seed, jit=jit)
    for verdict in again(made):
        if verdict.fault:
            path = keep(made, verdict, f"seed_{seed}", again, tries=200)
            pytest.fail(f"{verdict.fault}\n{path}, made small:\n{path.read_text('utf-8')}")
