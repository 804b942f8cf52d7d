"""What a guard proves about a whole number: also when the number it is compared to is no whole one."""

import pytest

from sjdsl.compiler import build
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.source import Source

GAME = """sj 1
game frame "Guards" {{
  episode 9
  param worth : reward = {{ raw: 1, cut: 2 }}
  kind grass "."
  map {{ "...." }}
  agents 2 {{
    acts stay
    field held : 0 .. 9 = 0
    field bag by {{ raw, cut }} : 0 .. 3 = 0
  }}
  phase start {{ each agent {{ send agent to grass }} }}
  schedule rule
  phase rule {{ {body} }}
}}
"""
MIX = "each agent where sum(agent.bag) {} {{ give worth[mix(agent.bag)] to agent }}"
WRITES = (
    "each agent where agent.held {} {{ set agent.held = 1 }} each agent as other where other.held {} {{ set other.held = other.index }}"
)


def codes(body: str) -> set[str]:
    try:
        build(Source("frame.sj", GAME.format(body=body)))
    except CompileError as error:
        return {d.code for d in error.diagnostics if d.severity == "error"}
    return set()


@pytest.mark.parametrize("guard", ["> 0", "> 1", ">= 1", ">= 2", "> 0.5", ">= 0.5", "== 2"])
def test_a_row_of_at_least_one_has_shares(guard):
    assert codes(MIX.format(guard)) == set()


@pytest.mark.parametrize("guard", [">= 0", "> -1", "< 3", "!= 1"])
def test_a_row_that_can_be_empty_has_none(guard):
    assert codes(MIX.format(guard)) == {"SJ208"}


def test_one_lies_between_one_half_and_more():
    assert codes(WRITES.format("> 1.5", "< 1.5")) == set()
    assert codes(WRITES.format("> 0.5", "< 1.2")) == {"SJ401"}
