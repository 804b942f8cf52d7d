"""A sheet says all: every declaration is on it as written."""

import re
from itertools import chain

import pytest

from sjdsl.compiler import ir
from sjdsl.doc import rule_sheet

from .corpus import games, manual, small

pytestmark = [
    pytest.mark.thorough,
    pytest.mark.parametrize("programs", [games, small, manual], ids=["games", "small", "manual"]),
]
LEFT_OVER = re.compile(
    r"\bTrue\b|\bFalse\b|\bNone\b|\binf\b|\(\)|[a-z]  [a-z]|\w+\(.*?=|object at|\* \*|[.,:;][.,:;]"
)


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
