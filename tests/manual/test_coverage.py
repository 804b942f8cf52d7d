"""The manual leaves nothing out: grammar, functions, codes, limits and words are compared with the compiler's own lists."""

import re
from collections.abc import Iterable, Iterator
from functools import cache
from typing import get_args

import pytest

from sjdsl.compiler import build, ir
from sjdsl.compiler.diagnostics import limits
from sjdsl.compiler.diagnostics.explanations import all_codes
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.elaborate import declarations, lookup, observations, shapes
from sjdsl.compiler.elaborate.constants import UNITS
from sjdsl.compiler.ir import types
from sjdsl.compiler.ir.operations import FUNCTIONS
from sjdsl.compiler.syntax.parse import parser
from sjdsl.compiler.syntax.soft_words import SOFT
from sjdsl.interpreter.state import Facing
from sjdsl.runtime import actions
from tests.fuzz.coverage import Grammar

from .blocks import MANUAL, examples

EXECUTED = [e for e in examples(MANUAL) if e.said("result")]
WORDS_OF_RULES = {
    "units": UNITS,
    "functions": tuple(FUNCTIONS),
    "actions": actions.BUILT_IN,
    "attributes": (*lookup.AGENT_ATTRIBUTES, *lookup.CELL_ATTRIBUTES),
    "shapes": (*shapes.BUILT_IN, "centre"),
    "facings": get_args(Facing),
    "sides of the window": observations.SIDES,
    "whose fields are seen": observations.OWNERS,
    "frames of moves": ("relative", "compass"),
    "checks": ("random", "never", "falling", "rising", "agents"),
    "values": ("step", "nobody", "nowhere", "yes", "no"),
    "field types": ("agent", "cell", "reward"),
}


def text() -> str:
    return MANUAL.read_text(encoding="utf-8")


@cache
def executed() -> tuple[Grammar, frozenset[str]]:
    """Returns what the executed examples use of the grammar, and the texts of all their tokens."""
    grammar, found = Grammar(), set()
    for example in (*EXECUTED, *(e for e in examples(MANUAL) if "frame" in e.block.info)):
        found |= {str(token) for token in grammar.read_text(Source("example.sj", example.source))}
    return grammar, frozenset(found)


def parts(alternatives: Iterable[str]) -> set[tuple[str, str]]:
    """Returns each symbol of some alternatives of the grammar, with its rule."""
    rules = [alternative.partition(": ") for alternative in alternatives]
    return {(rule, symbol) for rule, _, symbols in rules for symbol in symbols.split()}


def test_every_part_of_every_grammar_rule_is_in_an_executed_example():
    grammar, _ = executed()
    assert sorted(parts(grammar.alternatives) - parts(grammar.used)) == []


def test_every_keyword_and_sign_is_in_an_executed_example():
    _, tokens = executed()
    wanted = {word for t in parser().terminals for word in _literals(t.pattern)}
    assert sorted(wanted - tokens) == []


def _literals(pattern) -> Iterator[str]:
    if pattern.type == "str":
        yield pattern.value
    elif re.fullmatch(r"\(\?:[^()]*\)", pattern.value):
        yield from (re.sub(r"\\", "", part) for part in pattern.value[3:-1].split("|"))


@pytest.mark.parametrize("sort", WORDS_OF_RULES)
def test_every_name_with_a_meaning_is_in_an_executed_example(sort):
    assert sorted(set(WORDS_OF_RULES[sort]) - executed()[1]) == []


def test_every_kind_of_typed_rule_is_in_an_executed_example(folder):
    found = set()
    for example in EXECUTED:
        game = build(Source(f"{example.name}.sj", example.source, folder)).game
        found |= {type(node) for node in ir.walk(game)}
    sorts = ir.Expression | ir.Statement | ir.RestrictionNode | ir.TurnNode | ir.PolicyRuleNode
    wanted = {t for t in vars(ir).values() if isinstance(t, type) and issubclass(t, sorts)}
    assert sorted(t.__name__ for t in wanted - found if not t.__subclasses__()) == []


def section(title: str) -> str:
    """Returns the text of a chapter of the manual."""
    return re.split(r"^## ", text().split(f"\n## {title}\n")[1], maxsplit=1, flags=re.MULTILINE)[0]


def table(heading: str) -> list[list[str]]:
    """Returns the rows of the table whose first row begins with a heading, as texts."""
    lines = text().split(f"\n| {heading} |")[1].split("\n\n")[0].splitlines()
    return [
        [cell.strip(" *") for cell in line.strip("|").split("|")]
        for line in (f"| {heading} |{lines[0]}", *lines[2:])
    ]


def test_the_reserved_words_are_those_of_the_grammar():
    words = {t.name: t.pattern.value for t in parser().terminals if t.pattern.value.isalpha()}
    taken, soft = (
        section("24. Words that are taken")
        .split("cannot be names:")[1]
        .split("These have")[0]
        .split("These were added")
    )
    assert sorted(re.findall(r"`(\w+)`", taken)) == sorted(
        word for kind, word in words.items() if kind not in SOFT
    )
    assert sorted(re.findall(r"`(\w+)`", soft)) == sorted(words[kind] for kind in SOFT)


def test_the_names_with_a_meaning_are_those_of_the_compiler():
    listed = (
        section("24. Words that are taken").split("These have a fixed meaning")[1].split("\n\n")[1]
    )
    keywords = {t.pattern.value for t in parser().terminals}
    assert set(re.findall(r"`(\w+)`", listed)) == set(declarations.RESERVED_VARIABLES) - keywords


def test_every_code_is_listed_with_its_title():
    listed = re.findall(r"`(SJ\d+)` (.*?) (?:·|\|$)", section("22. Errors"), re.MULTILINE)
    wanted = [
        (code, error.title + " (warning)" * (error.severity == "warning"))
        for code, error in all_codes().items()
    ]
    assert listed == wanted


LIMITS = {  # the row of the table -> the compiler's own name
    "agents": "MAX_AGENTS",
    "movers of one sort": "MAX_MOVERS",
    "actions": "MAX_ACTIONS",
    "words in one set": "MAX_WORDS",
    "entries of one row": "MAX_WORDS",
    "kinds": "MAX_KINDS",
    "fields and timers, of all owners together": "MAX_FIELDS",
    "phases": "MAX_PHASES",
    "rows or columns of a map": "MAX_MAP_SIDE",
    "cells that `send … by` sends an agent": "MAX_SHIFT",
    "cells of a shape": "MAX_SHAPE_CELLS",
    "window, cells to one side": "MAX_WINDOW",
    "turns of a schedule": "MAX_TURNS",
    "statements in one file": "MAX_STATEMENTS",
    "bytes in one file": "MAX_BYTES",
    "characters in one line": "MAX_LINE",
    "words and signs in one file": "MAX_TOKENS",
    "brackets around one place": "MAX_DEPTH",
    "brackets, blocks, operators in a row and `otherwise`s around one place": "MAX_TREE",
    "defines that use each other in a row": "MAX_DEFINES_DEEP",
    "uses of defines, with those inside them": "MAX_EXPANSIONS",
    "characters of one number with a fraction": "MAX_DIGITS",
}
IN_WORDS = {"MAX_DRAWN", "MAX_INTEGER", "MAX_PROBLEMS", "MAX_VALUE"}  # below the table
IMPLIED = {"MAX_MAP_CELLS"}  # by the rows and columns


def test_the_limits_are_those_of_the_compiler():
    assert {row[0]: int(row[1]) for row in table("limit")[1:]} == {
        row: getattr(limits, name) for row, name in LIMITS.items()
    }
    for name in IN_WORDS:
        assert f"{getattr(limits, name):,}" in section("23. Limits"), name


def test_every_limit_of_the_compiler_is_told():
    assert {name for name in vars(limits) if name.startswith("MAX_")} == {
        *LIMITS.values()
    } | IN_WORDS | IMPLIED
    assert limits.MAX_MAP_CELLS == limits.MAX_MAP_SIDE**2


@pytest.mark.parametrize(("sign", "unit_of"), [("×", types.times_unit), ("÷", types.over_unit)])
def test_the_tables_of_units_are_those_of_the_compiler(sign, unit_of):
    rows = table(sign)
    columns = rows[0][1:]
    assert set(columns) == {"number", *types.UNIT_LIMITS}
    for left, *cells in rows[1:]:
        for right, cell in zip(columns, cells, strict=True):
            unit = unit_of(left, right)
            if sign == "÷" and unit in types.INTEGER_UNITS:
                unit = "number"  # a quotient is a real number
            assert cell == (unit or "–"), (left, sign, right)


def test_every_link_leads_somewhere():
    headings = re.findall(
        r"^#+ (.*)$",
        re.sub(r"^```.*?^```", "", text(), flags=re.MULTILINE | re.DOTALL),
        re.MULTILINE,
    )
    anchors = {"#" + re.sub(r"[^\w\- ]", "", h.lower()).replace(" ", "-") for h in headings}
    for link in re.findall(r"\]\(([^)]+)\)", text()):
        assert link in anchors or (
            link[0] != "#" and (MANUAL.parent / link.partition("#")[0]).is_file()
        ), link


def sections() -> dict[str, str]:
    """Returns the text of each section of the manual, without its subsections, by its anchor."""
    parts = re.split(r"^##+ (.*)$", text(), flags=re.MULTILINE)
    return {
        re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-"): part
        for title, part in zip(parts[1::2], parts[2::2], strict=True)
    }


def test_every_section_begins_with_what_it_is_for():
    assert [
        anchor for anchor, part in sections().items() if not part.lstrip().startswith("To ")
    ] == []


def test_the_index_has_every_word_and_leads_to_where_it_stands():
    entries = [entry for row in table("letter") for entry in row[1].split(" · ") if "](" in entry]
    words = {
        t.pattern.value
        for t in parser().terminals
        if t.pattern.type == "str" and t.pattern.value.isalpha()
    }
    found = {name for entry in entries for name in named(entry.split("`")[1])}
    assert words.union(*WORDS_OF_RULES.values()) - found == set()
    for entry in entries:
        for anchor in re.findall(r"\(#(.*?)\)", entry):
            assert named(entry.split("`")[1]) <= named(sections()[anchor]), (entry, anchor)


def named(part: str) -> set[str]:
    return set(re.findall(r"[a-z_]+", part))
