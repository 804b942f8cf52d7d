"""`require` counts the map that the game is built on, cell by cell as it begins."""

import pytest

from sjdsl.compiler import build, build_composition, ir
from sjdsl.compiler.compose import compose
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.elaborate import Overrides
from sjdsl.compiler.elaborate.world_map import row_spans
from sjdsl.compiler.ir.values import holds

GAME = """sj 1
game counted "Counts of the map" {{
  param most : count = 3 in 0 .. 9
  episode 5
  kind grass "."
  kind tree "T" {{ field fruit : {{ none, ripe }} = ripe  field age : 0 .. 5 = 2  field owner : agent  glyph "t" with fruit = none with age = 4 }}
  kind rock "r"
  group thing = tree, rock
  map {{ ".TtT" ".rt." }}
  agents 2 {{ acts stay }}
  movers deer 1 "D"
  phase start {{ each agent {{ send agent to grass }} each deer {{ send deer to tree }} }}
  schedule rest
  phase rest {{ each agent on tree {{ set tree.fruit = none  set tree.owner = agent }} }}
  checks {{ require {test} }}
}}
"""


def game(test: str, rows: tuple[str, ...] | None = None) -> ir.Game:
    composed = compose(Source("counted.sj", GAME.format(test=test)))
    return build_composition(
        composed, Overrides(rows=rows, row_spans=row_spans(rows, "map")) if rows else None
    ).game


@pytest.mark.parametrize(
    ("counted", "number"),
    [
        ("count(tree)", 4),
        ("count(thing)", 5),
        ("count(agent)", 2),
        ("count(deer)", 1),
        ("count(tree where tree.fruit is ripe)", 2),
        ("count(tree as one where one.fruit is ripe or one.age in 4 .. 5)", 4),
        ("count(tree where tree.age * 2 > 4 and not (tree.fruit is ripe))", 2),
        ("count(tree where tree.owner is nobody)", 4),
        ("count(grass) + count(rock)", 4),
    ],
)
def test_the_number_is_that_of_the_map(counted: str, number: int) -> None:
    game(f"{counted} == {number}")
    with pytest.raises(CompileError) as refused:
        game(f"{counted} == {number + 1}")
    assert [d.code for d in refused.value.diagnostics] == ["SJ212"]


def test_another_map_is_counted_anew() -> None:
    needed = "count(rock) >= 1"
    assert game(needed).rows == (".TtT", ".rt.")
    with pytest.raises(CompileError):
        game(needed, rows=(".TtT", "..t."))
    assert game(needed, rows=("..T", "rrr")).checks[0].values


def test_a_parameter_is_compared_with_the_map() -> None:
    """Set when the game is played: the count stays in the check."""
    (check,) = game("most < count(tree)").checks
    assert holds(check.values[0], {"most": 3})
    assert not holds(check.values[0], {"most": 4})


@pytest.mark.parametrize(
    "test",
    [
        "count(agent on tree) == 0",
        "count(tree where tree.col > 1) > 0",
        "count(tree where tree.age > most) > 0",
        "count(tree where nobody on tree) > 0",
    ],
)
def test_what_is_not_the_maps_alone_is_refused(test: str) -> None:
    with pytest.raises(CompileError) as refused:
        build(Source("counted.sj", GAME.format(test=test)))
    assert "SJ216" in [d.code for d in refused.value.diagnostics]
