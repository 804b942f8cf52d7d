"""`require` on numbers of a game: decided when it is compiled as the interpreter decides it, whatever it is made of."""

import pytest

from sjdsl.compiler import build
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.interpreter.evaluate import evaluate
from sjdsl.interpreter.state import default_params
from tests.compiler.refusals import codes_in
from tests.interpreter.games import instance

GAME = """sj 1
game frame "Requires" {{
  episode 9
  param many by {{ x, y }} : count = {{ x: 0, y: 2 }}
  param none by {{ x, y }} : count = {{ x: 0, y: 0 }}
  param steps by 1 .. 3 : count = {{ 1: 5, otherwise: 7 }}
  param pay by {{ x, y }} : reward = {{ x: 1, y: 4 }}
  param table : reward = {{ x: {{ x: 3, y: 0 }}, y: {{ x: 5, y: 1 }} }}
  param chosen : word = y
  define both = table + table
  define moved_on = shift(many, -1, 9)
  kind grass "."
  map {{ "...." }}
  agents 2 {{ acts stay  field word : {{ x, y }} = x }}
  phase start {{ each agent {{ send agent to grass }} }}
  schedule rule
  phase rule {{ each agent {{ set agent.word = y }} }}
  checks {{ require {required} }}
}}
"""
REQUIRED = (
    "sum(many + none) == 2",
    "max(many - none) == 2",
    "min(many + many) >= 0",
    "both[y][x] == 10",
    "ramp(many[y], 0, 4) == 0.5",
    "abs(pay[x] - pay[y]) == 3",
    "case pay[x] > 0.5 { yes: 1, no: 2 } == 1",
    "case chosen { x: 1, y: 2 } == 2",
    "case many[y] { 0: 1, 1 .. 3: 2, otherwise: 3 } == 2",
    "lowest(many) is y",
    "highest(many) is y",
    "lowest(none) is x",
    "highest(none) is y",
    "lowest(steps) == 1",
    "highest(steps) == 3",
    "max(shift(many, -1, 9)) == 9",
    "moved_on[x] == 2",
    "sum(many) > 0 and pay[mix(many)] == 4",
    "pay[lowest(many)] == 4",
    "pay[chosen] == 4",
    "prisoners_dilemma(table)",
)


@pytest.mark.parametrize("required", REQUIRED)
def test_it_holds_when_compiled_and_for_the_interpreter(required: str) -> None:
    game = build(Source("frame.sj", GAME.format(required=required))).game
    (test,) = [check.values[0] for check in game.checks]
    assert default_params(game)
    assert evaluate(test, instance(game)) is True
    assert codes_in(GAME.format(required=f"not ({required})")) == {"SJ212"}
