"""Expressions that differ in meaning differ in words; names, brackets and comments are as they should be."""

from itertools import product

import pytest

from sjdsl.compiler import build, ir
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.ir.operations import CALCULATIONS
from sjdsl.compiler.syntax.read import read_source
from sjdsl.doc import read_written, rule_sheet
from sjdsl.doc.defines import vocabulary
from sjdsl.doc.phrases import condition, value
from sjdsl.doc.wording import Line, bullets, number, table, table_value
from sjdsl.doc.written import comments
from tests.doc.corpus import SMALL

NUMBER = ir.Type(kind="int")
ONE, A = ir.Number(type=NUMBER, value=1), ir.Local(type=NUMBER, name="a")
SIMPLE = vocabulary(build(read_source(next(path for path in SMALL if path.stem == "walking"))).game)


def arithmetic(fn: str, *args: ir.Expr) -> ir.Expr:
    return ir.Arithmetic(type=NUMBER, fn=fn, args=args)


def calculations(of: list[ir.Expr]) -> list[ir.Expr]:
    rows = [(row, many) for row in CALCULATIONS.values() for many in (1, 2) if row.least <= many <= row.most]
    return [arithmetic(row.name, *args) for row, many in rows for args in product(of, repeat=many)]


def test_no_two_calculations_read_the_same() -> None:
    found = calculations([ONE, A, *calculations([ONE, A])])
    assert len({value(e, SIMPLE) for e in found}) == len(found)


def conditions(of: list[ir.Expr]) -> list[ir.Expr]:
    pairs = [ir.Logic(fn=fn, args=(x, y)) for fn in ("and", "or") for x, y in product(of, of)]  # type: ignore[arg-type]
    return [*pairs, *(ir.Not(value=x) for x in of)]


def truth(e: ir.Expr, given: dict[str, bool]) -> bool:
    match e:
        case ir.Local():
            return given[e.name]
        case ir.Not():
            return not truth(e.value, given)
        case ir.Logic():
            return (all if e.fn == "and" else any)(truth(a, given) for a in e.args)
    raise AssertionError(e)


def test_conditions_that_read_the_same_mean_the_same() -> None:
    names = [ir.Local(type=ir.CONDITION, name=name) for name in "pqr"]
    simple = conditions(names)
    found: dict[str, tuple[bool, ...]] = {}
    cases = [dict(zip("pqr", case, strict=True)) for case in product((False, True), repeat=3)]
    for e in [*names, *simple, *conditions([names[0], *simple])]:
        text = condition(e, SIMPLE)
        meaning = tuple(truth(e, case) for case in cases)
        assert found.setdefault(text, meaning) == meaning, text


@pytest.mark.parametrize("fn", ["<", "<=", ">", ">=", "==", "!="])
def test_the_opposite_of_a_comparison(fn: str) -> None:
    opposite = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}[fn]
    one, other = (ir.Compare(fn=f, left=A, right=ONE) for f in (fn, opposite))  # type: ignore[arg-type]
    assert condition(ir.Not(value=one), SIMPLE) == condition(other, SIMPLE)
    assert condition(one, SIMPLE) == condition(other, SIMPLE, holds=False) != condition(other, SIMPLE)


def test_lines_inside_lines() -> None:
    leaf = Line("it rains")
    assert list(bullets([Line("each day", (leaf,))])) == ["- Each day: it rains."]
    assert list(bullets([Line("each day", (leaf, leaf))])) == ["- Each day:", "  - It rains.", "  - It rains."]
    assert list(bullets([Line("each day", (Line("if so", (leaf,)),)), leaf])) == ["- Each day: if so: it rains.", "- It rains."]
    long = Line("x" * 230)
    assert list(bullets([Line("each day", (long,))])) == ["- Each day:", f"  - X{'x' * 229}."]


def test_numbers_and_tables() -> None:
    assert [number(x) for x in (1, 1.0, 0.25, 0.00008, 1e-12, -3.5)] == ["1", "1", "0.25", "0.00008", "1e-12", "-3.5"]
    assert (
        table_value(((1, 0), (2, 3.5)), (ir.Level("word", ("raw", "cut")),) * 2)
        == "`raw`: (`raw`: 1, `cut`: 0), `cut`: (`raw`: 2, `cut`: 3.5)"
    )
    assert table(("a", "b"), [("|", "c")]) == ["| a | b |", "| --- | --- |", "| \\| | c |"]


BEFORE = 'sj 1\ngame pit "A pit" {\n'
AFTER = """
  episode 5
  kind grass "#"   # the glyph is no comment
  map { "##" }
  agents players { acts stay  field bag by { red, blue } : 0 .. 9 = 0 }
  phase start { each agent { send agent to grass } }
  schedule rest
  phase rest { each agent { give pay[red] + pay[blue] * rate to agent } }
  variant rich { set pay[red] = 7   # ours: more
  }
}
"""
NUMBERS = """  size players : count = 1 + 1 in 1 .. 2   # paper: two
  param rate : probability = 0.5
  param pay : reward = {   # first part
    red: 2 / players,      # second part
    blue: 3 }
"""


def sheet_lines(variants: tuple[str, ...] = ()) -> list[str]:
    source = Source("pit.sj", BEFORE + NUMBERS + AFTER)
    return rule_sheet(read_written(source, variants)).splitlines()


def test_numbers_name_their_sources() -> None:
    rows = [line for line in sheet_lines() if line.startswith(("| `players`", "| `rate`", "| `pay`"))]
    assert rows == [
        "| `players` | 2; computed as `1 + 1` | count | 1 to 2 | before compiling | paper: two |",
        "| `rate` | 0.5 | probability | 0 to 1 | at any time |  |",
        "| `pay` | `red`: 1, `blue`: 3; `red` computed as `2 / players` | reward | any | at any time | first part; second part |",
    ]


def test_a_variant_names_the_source_of_what_it_changes() -> None:
    (row,) = (line for line in sheet_lines(("rich",)) if line.startswith("| `pay`"))
    assert row == "| `pay` | `red`: 7, `blue`: 3 | reward | any | at any time | first part; second part; ours: more |"


def test_comments_are_not_found_in_texts() -> None:
    source = Source("pit.sj", 'kind grass "#"  # one\nkind wall "##"\n')
    assert comments(source.span(0, 4), {"pit.sj": source}) == "one"
    assert comments(source.span(22, 30), {"pit.sj": source}) == ""


def test_a_glyph_that_means_something_to_markdown() -> None:
    text = BEFORE + NUMBERS + AFTER.replace('kind grass "#"', 'kind grass "|"').replace('"##"', '"||"').replace("A pit", "A pit")
    rows = rule_sheet(read_written(Source("pit.sj", text.replace('"A pit"', '"A *pit*"')))).splitlines()
    assert rows[0] == "# A \\*pit\\*"
    assert "| `\\|` | grass | 2 |  |" in rows


def test_a_map_of_backticks_stays_in_its_fence() -> None:
    text = (BEFORE + NUMBERS + AFTER).replace('kind grass "#"', 'kind grass "`"').replace('"##"', '"````"')
    rows = rule_sheet(read_written(Source("pit.sj", text))).splitlines()
    place = rows.index("````")
    assert rows[place - 1 : place + 2] == ["`````text", "````", "`````"]
