"""A sheet says all: every declaration is on it as written, and nothing in its tables can change without the sheet changing."""

import re
from collections.abc import Iterator
from dataclasses import replace
from itertools import chain

import pytest

from sjdsl.compiler import ir
from sjdsl.doc import Written, rule_sheet

from .changes import TABLED, small_changes
from .corpus import games, manual, small

LEFT_OVER = re.compile(
    r"\bTrue\b|\bFalse\b|\bNone\b|\binf\b|\(\)|[a-z]  [a-z]|\w+\(.*?=|object at|\* \*|[.,:;][.,:;]"
)
NO_GAME = "not even a game"  # said of a game in which something reads a name that nothing has
ABSTRACT = {
    ir.Node,
    ir.Expression,
    ir.Statement,
    ir.RestrictionNode,
    ir.TurnNode,
    ir.CourseNode,
    ir.PolicyRuleNode,
}


def node_classes(parent: type[ir.Node] = ir.Node) -> Iterator[type[ir.Node]]:
    for child in parent.__subclasses__():
        yield child
        yield from node_classes(child)


@pytest.mark.thorough
@pytest.mark.parametrize("programs", [games, small, manual], ids=["games", "small", "manual"])
def test_every_program_has_a_sheet(programs) -> None:
    for name, written in programs().items():
        text = rule_sheet(written)
        assert text.startswith("# ") and "\n## Initialisation\n" in text, name
        prose = re.sub(
            r"`[^`\n]+`",
            "`code`",
            re.sub(r"^(```+)\w+\n.*?^\1$", "", text, flags=re.DOTALL | re.MULTILINE),
        )
        found = [prose[max(0, m.start() - 40) : m.end() + 20] for m in LEFT_OVER.finditer(prose)]
        assert not found, (name, found)


def test_every_node_of_the_ir_is_in_some_program() -> None:
    found = {
        type(node) for written in (small() | manual()).values() for node in ir.walk(written.game)
    }
    assert set(node_classes()) - ABSTRACT - found == set()


def said(written: Written, game: ir.Game) -> str:
    """Returns the sheet of a game whose tables are made of other rules than its file has."""
    try:
        return rule_sheet(replace(written, game=game))
    except (
        KeyError,
        StopIteration,
        ValueError,
        AttributeError,
        IndexError,
        RuntimeError,
        AssertionError,
    ):
        return NO_GAME


@pytest.mark.thorough
def test_nothing_in_the_tables_changes_without_the_sheet() -> None:
    tried: dict[tuple[str, str], int] = {}
    unnoticed = []
    for name, written in (small() | manual()).items():
        before = said(written, written.game)
        for sort, field, changed in small_changes(written.game, tried):
            sheets = [
                before,
                *(text for text in (said(written, other) for other in changed) if text != NO_GAME),
            ]
            if len(set(sheets)) < len(sheets):
                unnoticed.append((name, sort, field))
    assert unnoticed == []
    assert {(sort, field) for sort, fields in TABLED.items() for field in fields} - set(
        tried
    ) == set()


@pytest.mark.thorough
@pytest.mark.parametrize("programs", [games, small, manual], ids=["games", "small", "manual"])
def test_what_is_quoted_is_every_word_of_the_file(programs) -> None:
    for name, written in programs().items():
        c, sheet = written.composition, "".join(rule_sheet(written).split())
        read = {node.name for node in ir.walk(written.game) if isinstance(node, ir.Named)}
        defines = {
            name: d for name, d in c.defines.items() if d.span.file == c.file or name in read
        }  # not those that only a base needs
        turns = [] if c.schedule is None else [turn.name.text for turn in c.schedule.turns]
        phases = [phase for called, phase in c.phases.items() if called in ("start", *turns)]
        kinds = [
            kind for kind in c.kinds.values() if kind.attributes
        ]  # of the others a table says all
        tables = (
            c.groups,
            c.fields,
            c.agent_fields,
            c.agent_blocks,
            c.forbids,
            c.movers,
            c.shapes,
            defines,
            c.observables,
            c.policies,
        )
        groups = [
            *c.checks.values(),
            *c.looks.values(),
            c.windows,
            kinds,
            phases,
            [c.schedule, c.episode],
            *(t.values() for t in tables),
        ]
        for node in filter(None, chain.from_iterable(groups)):
            text = c.sources[node.span.file].text[node.span.start : node.span.end]
            assert "".join(text.split()) in sheet, (name, text)
        for metric in c.metrics.values():
            words = (
                c.sources[metric.span.file]
                .text[metric.name.span.end : metric.span.end]
                .strip()
                .removeprefix("=")
            )
            assert f"|`{metric.name.text}`|" in sheet and "".join(words.split()) in sheet, (
                name,
                words,
            )
