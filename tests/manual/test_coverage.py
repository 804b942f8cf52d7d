"""The manual leaves nothing out: its examples use the whole grammar, and its links lead somewhere."""

import re
from collections.abc import Iterable, Iterator
from functools import cache
from typing import get_args

import pytest

from sjdsl.compiler import build, ir
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.elaborate import lookup, observed_paths, shapes
from sjdsl.compiler.elaborate.constants import UNITS
from sjdsl.compiler.elaborate.window import SIDES
from sjdsl.compiler.ir.operations import FUNCTIONS
from sjdsl.compiler.syntax.parse import parser
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
    "sides of the window": SIDES,
    "whose fields are seen": observed_paths.OWNERS,
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
