"""Every phrase of the table is recognised somewhere, and every name that is proposed can be had."""

import re
from collections.abc import Iterator

import pytest

from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.guesses import NAMES
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.parse import parse, parser
from sjdsl.compiler.syntax.recovery.phrases import PHRASES, Phrase

PARTS = {
    "PATH": "agent.bag", "EXPR": "2", "DOMAIN": "tree", "NAME": "one", "INT": "3", "STRING": '"x"', "NAMES": "left right",
    "TURNS": "walk, rule",
}  # fmt: skip
PLACES = (
    "phase p {{ each tree {{ {} }} }}",
    "phase p {{ {} {{ give 1 to all }} }}",
    "phase p {{ when step > 3 {{ end }} {} {{ give 1 to all }} }}",
    "metrics {{ mean x = {} }}",
    "metrics {{ {} }}",
    "checks {{ {} }}",
    "observe {{ {} }}",
    "agents 2 {{ {} }}",
    "{}",
    "{} {{ acts stay }}",
    "phase p {{ each {} {{ give 1 to all }} }}",
    "phase p {{ each tree {} {{ give 1 to all }} }}",
    'kind stone "s" {{ {} }}',
    "policy p {{ {} }}",
    "policy p {{ seek tree {} }}",
    "policy p {{ when step > 3 choose stay {} }}",
    "scenario s {{ {} }}",
)


def written(phrase: Phrase) -> str:
    return " ".join(PARTS.get(element, element) for element in phrase.pattern)


def hints(text: str) -> Iterator[str]:
    """Yields what is said of a text, in one place after the other."""
    for place in PLACES:
        try:
            parse(Source("x.sj", f"sj 1\ngame x {{ {place.format(text)}\nepisode 5 }}"))
        except CompileError as error:
            yield from (d.hint for d in error.diagnostics)


@pytest.mark.parametrize("phrase", PHRASES, ids=lambda phrase: " ".join(phrase.pattern))
def test_a_phrase_is_recognised(phrase: Phrase) -> None:
    parts = {str(n): PARTS[e] for n, e in enumerate((e for e in phrase.pattern if e.isupper()), 1)}
    parts |= (
        {f"minus{n}": f"-{p}" for n, p in parts.items()} | {f"and{n}": " where" for n in parts} | {f"all{n}": p for n, p in parts.items()}
    )
    wanted = phrase.explain(parts) if phrase.explanation else f"write `{phrase.write(parts)}`"
    assert wanted in hints(written(phrase))


def test_the_names_proposed_are_no_words_of_the_language() -> None:
    words = {t.pattern.value for t in parser().terminals if t.pattern.type == "str"}
    assert set(NAMES) <= words
    assert not set(NAMES.values()) & words
    assert all(re.fullmatch("[a-z][a-z0-9_]*", name) for name in NAMES.values())
