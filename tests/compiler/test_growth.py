"""A file twice as long takes about twice the work to check: an editor checks it at each keystroke. Work is counted in calls, not in time."""

import sys
from pathlib import Path

import pytest

from sjdsl.compiler import check
from sjdsl.compiler.diagnostics.source import Source

GAME = (Path(__file__).parents[2] / "examples" / "orchard.sj").read_text(encoding="utf-8")
GIVE = "give 1 to agent"


def with_part(text: str, game: str = GAME) -> str:
    """Returns a game with more declarations."""
    end = game.rindex("}")
    return f"{game[:end]}{text}\n{game[end:]}"


def lines(line: str, number: int) -> str:
    """Returns a line so many times, with numbers of four digits in place of `#`."""
    return "\n".join(line.replace("#", str(n)) for n in range(1000, 1000 + number))


def calls(text: str) -> int:
    """Returns how many functions are called to check a game."""
    source, number = Source("game.sj", text), 0

    def count(_frame: object, event: str, _argument: object) -> None:
        nonlocal number
        number += event in ("call", "c_call")

    sys.setprofile(count)
    try:
        check(source)
    finally:
        sys.setprofile(None)
    return number


def formula(operator: str, operand: str, number: int, statement: str) -> str:
    tens = f" {operator} ".join([operand] * 10)
    whole = f" {operator} ".join(["ten(agent)"] * number)
    return with_part(f"define ten(x) = {tens}\n", GAME.replace(GIVE, statement.replace("#", whole)))


LONG = {
    "requires": lambda n: with_part(f"checks {{\n{lines('require regrow < #', n)}\n}}"),
    "parameters": lambda n: with_part(lines("param p# : reward = 1", n)),
    "unknown names": lambda n: GAME.replace(GIVE, lines("give nothing# to agent", n)),
    "checks": lambda n: with_part(f"checks {{\n{lines('always step >= 0 or step > #', n)}\n}}"),
    "metrics": lambda n: with_part(f"metrics {{\n{lines('mean m# = count(tree) + #', n)}\n}}"),
    "events": lambda n: with_part(
        f"metrics {{\n{lines('event e#', n)}\n}}",
        GAME.replace(GIVE, lines("tally e# for agent", n)),
    ),
    "kept numbers": lambda n: GAME.replace(GIVE, lines("let x# = step + #", n) + GIVE),
    "defines": lambda n: with_part(lines("define d# = step + #", n)),
    "policies": lambda n: with_part(lines('policy p# "goes" { seek tree }', n)),
    "variants": lambda n: with_part(lines("variant v# { set regrow = 0.1 }", n)),
    "conditions": lambda n: formula("and", "x.row > 0", n // 10, "when # { give 1 to agent }"),
    "alternatives": lambda n: formula("or", "x.row > 3", n // 10, "when # { give 1 to agent }"),
    "a sum that is compared": lambda n: formula(
        "+", "x.row", n // 10, "when # > 3 { give 1 to agent }"
    ),
    "a sum under a guard": lambda n: formula(
        "+", "x.row", n // 10, "when agent.row > 1 { when # > 3 { give 1 to agent } }"
    ),
}


@pytest.mark.parametrize("name", LONG)
def test_twice_the_text_is_twice_the_work(name: str) -> None:
    calls(LONG[name](10))  # builds what is built once
    short, middle, long = (calls(LONG[name](number)) for number in (30, 60, 120))
    assert long - middle < 2.5 * (middle - short)  # in proportion 2; as the square 4


@pytest.mark.parametrize(
    "statement",
    ["add 1 to taken", "when step == # { set taken = 3 }", "give # to agent", "add agent to seen"],
)
def test_many_writes_are_no_deep_nest(statement: str) -> None:
    """Sums are nested in the program, and Python goes through them recursively."""
    fields = "field taken : 0 .. 9 capped = 0  field seen : set of agent"
    found = check(Source("game.sj", with_part(fields, GAME.replace(GIVE, lines(statement, 700)))))
    assert [d for d in found if d.severity == "error"] == []


def test_each_cell_has_a_sum_of_its_own() -> None:
    """Nine reals are added to each of 62,500 cells: many additions, but nine a sum."""
    row = '"' + "." * 250 + '"\n'
    game = f"""sj 1
game lawns {{
  episode 5
  kind lawn "." {{ field heat : reward }}
  map {{ {row * 250} }}
  agents 1 {{ acts stay }}
  phase start {{ each agent {{ send agent to lawn }} }}
  schedule warm -> cool
  phase warm {{ each lawn {{ {"add 0.1 to lawn.heat " * 9} }} }}
  phase cool {{ each lawn where lawn.heat > 3 {{ set lawn.heat = 0 }} }}
  observe {{ window ahead 1, behind 1, left 1, right 1 }}
}}"""
    assert [d for d in check(Source("lawns.sj", game)) if d.severity == "error"] == []
