"""One message for one mistake, it says what to write instead, and what it suggests is accepted."""

import pytest

from sjdsl.compiler import check
from sjdsl.compiler.diagnostics.diagnostic import Diagnostic
from sjdsl.compiler.diagnostics.slips import SLIPS
from sjdsl.compiler.diagnostics.source import Source
from tests.suggestions.frame import Case, cases

CASES = cases()


def errors_of(text: str) -> list[Diagnostic]:
    return [d for d in check(Source("meadow.sj", text)) if d.severity == "error"]


def test_the_names_of_the_cases_differ() -> None:
    assert len({case.name for case in CASES}) == len(CASES)


def test_every_slip_has_a_case() -> None:
    hints = {hint for patterns in SLIPS.values() for hint in patterns.values()}
    assert hints - {d.hint for case in CASES for d in errors_of(case.mistaken)} == set()


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_a_mistake_gets_one_message_that_helps(case: Case) -> None:
    found = errors_of(case.mistaken)
    told = [f"{d.code} {d.span.line}:{d.span.column} {d.message}; {d.hint}" for d in found]
    assert len(found) == 1, told
    assert (found[0].span.line, found[0].span.column) > (1, 1)
    missing = [phrase for phrase in case.says if phrase not in told[0]]
    assert missing == [], told[0]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_what_the_message_suggests_is_accepted(case: Case) -> None:
    assert [f"{d.code} {d.message}" for d in errors_of(case.repaired)] == []


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_an_edit_that_comes_with_a_message_can_be_read(case: Case) -> None:
    text = case.mistaken
    for fix in [d.fix for d in errors_of(text) if d.fix is not None]:
        text = text[: fix.span.start] + fix.text + text[fix.span.end :]
        assert [d.message for d in errors_of(text) if d.code < "SJ1"] == []
