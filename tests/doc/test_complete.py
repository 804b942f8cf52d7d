"""A sheet says all: every node of the IR has its English, and no part of the rules can change without the sheet changing."""

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

import pytest

from sjdsl.compiler import ir
from sjdsl.doc import Written, rule_sheet
from sjdsl.doc.statements import lines

from .changes import SILENT, small_changes, without_origins
from .corpus import games, manual, small

SECTIONS_THAT_REPEAT = ("Process overview: one step", "Random draws")  # what they say stands in the phases already
LEFT_OVER = re.compile(r"\bTrue\b|\bFalse\b|\binf\b|\(\)|[a-z]  [a-z]|\w+\(.*?=|object at|\* \*|[.,:;][.,:;]|\b(?:of|the|a) *[.,:)]")
QUOTED = {"checks": (), "looks": (), "policies": ()}  # the sheet has them as the file does
NO_GAME = "not even a game"  # said of a game in which something reads a name that nothing has
ABSTRACT = {ir.Node, ir.Expression, ir.Statement, ir.RestrictionNode, ir.TurnNode, ir.CourseNode, ir.PolicyRuleNode}


def node_classes(parent: type[ir.Node] = ir.Node) -> Iterator[type[ir.Node]]:
    for child in parent.__subclasses__():
        yield child
        yield from node_classes(child)


@pytest.mark.thorough
@pytest.mark.parametrize("programs", [games, small, manual], ids=["games", "small", "manual"])
def test_every_program_has_a_sheet(programs) -> None:
    for name, written in programs().items():
        text = rule_sheet(written)
        assert text.startswith("# ") and "\n## Phases\n" in text, name
        prose = re.sub(r"`\w+\([^`\n]*\)`", "`code`", re.sub(r"```text\n.*?```", "", text, flags=re.DOTALL))
        found = [prose[max(0, m.start() - 40) : m.end() + 20] for m in LEFT_OVER.finditer(prose)]
        assert not found, (name, found)


def test_every_node_of_the_ir_is_in_some_program() -> None:
    found = {type(node) for written in (small() | manual()).values() for node in ir.walk(written.game)}
    assert set(node_classes()) - ABSTRACT - found == set()


def test_a_statement_without_english_is_an_error() -> None:
    class Jump(ir.Statement):
        pass

    written = small()["walking"]
    with pytest.raises(AssertionError):
        lines(Jump(), written.game)  # type: ignore[arg-type]


def said(written: Written, game: ir.Game) -> str:
    """Returns the sheet of changed rules, without the sections that say again what the phases say."""
    changed = replace(written, game=game)
    try:
        sections = rule_sheet(changed).split("\n## ")
    except (KeyError, StopIteration, ValueError, AttributeError, IndexError, RuntimeError, AssertionError):
        return NO_GAME
    return "\n## ".join(s for s in sections if not s.startswith(SECTIONS_THAT_REPEAT))


@pytest.mark.thorough
def test_no_part_of_the_rules_changes_without_the_sheet() -> None:
    tried: Counter[tuple[str, str]] = Counter()
    met: set[type[ir.Node]] = set()
    unnoticed = []
    for name, written in (small() | manual()).items():
        game = without_origins(written.game.model_copy(update=QUOTED))
        before = said(written, game)
        met |= {type(node) for node in ir.walk(game)}
        for sort, field, changed in small_changes(game, tried):
            sheets = [before, *(text for text in (said(written, other) for other in changed) if text != NO_GAME)]
            if len(set(sheets)) < len(sheets):
                unnoticed.append((name, sort, field))
    assert unnoticed == []
    fields = {(c.__name__, f) for c in met for f, info in c.model_fields.items() if not is_part(info.annotation)}
    fields -= {("Game", name) for name in QUOTED}
    assert fields - set(tried) - {(c, f) for c, f in fields if f in SILENT["*"] | SILENT.get(c, set())} == set()


def is_part(annotation: object) -> bool:
    """Returns whether a field always holds one node: that changes where the node itself is changed."""
    return isinstance(annotation, type) and issubclass(annotation, ir.Node)


@pytest.mark.thorough
def test_what_is_quoted_is_every_word_of_the_file() -> None:
    """Checks, looks and policies, and the defines without a sentence of their own."""
    for written in (small() | manual()).values():
        c, sheet = written.composition, rule_sheet(written)
        words = "".join(sheet.split())
        groups = [*c.checks.values(), *c.looks.values(), *(policy.rules for policy in c.policies.values())]
        for node in (node for group in groups for node in group):
            text = "\n".join(
                line.partition("#")[0] for line in c.sources[node.span.file].text[node.span.start : node.span.end].splitlines()
            )
            assert "".join(text.split()) in words, (written.game.name, text)
        assert all(f"`{name}" in sheet or f"define {name}" in sheet for name in c.defines)
