"""Quick fixes: what a message suggests, applied as edits, is accepted."""

import pytest
from lsprotocol import types

from sjdsl.compiler import check
from sjdsl.compiler.diagnostics.diagnostic import Diagnostic, Suggestion
from sjdsl.compiler.diagnostics.source import Source
from tests.editor.asked import ORCHARD, edited, opened, place
from tests.suggestions.frame import Case, cases

CASES = cases()


def applied(text: str, suggestion: Suggestion) -> str:
    for edit in sorted(suggestion.edits, key=lambda edit: edit.span.start, reverse=True):
        text = text[: edit.span.start] + edit.text + text[edit.span.end :]
    return text


def errors_of(text: str) -> list[Diagnostic]:
    return [d for d in check(Source("meadow.sj", text)) if d.severity == "error"]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_a_suggestion_of_a_message_is_accepted(case: Case) -> None:
    """Each removes its own mistake and makes none of the same stage; of several at least one leaves nothing wrong."""
    (found,) = errors_of(case.mistaken)
    left = [errors_of(applied(case.mistaken, suggestion)) for suggestion in found.suggestions]
    for suggestion, errors in zip(found.suggestions, left, strict=True):
        assert (found.code, found.message) not in {(d.code, d.message) for d in errors}, (
            suggestion.says
        )
        assert not any(d.code < "SJ1" for d in errors), suggestion.says


@pytest.mark.parametrize(
    ("old", "new", "title"),
    [
        ("give apple", "give appel", "Write `apple`"),
        ("chose share", "chose shaer", "Write `share`"),
        ("eater.bag  give", "eater.bga  give", "Write `bag`"),
        ("tree.fruit = none", "tree.fruit = nnoe", "Write `none`"),
        ("-> walk ->", "-> wlak ->", "Write `walk`"),
        ("observe { window", "observe window", "Write `{`"),
        ("chance regrow", "chanec regrow", "Write `chance`"),
    ],
)
def test_a_quick_fix_repairs_the_game(old: str, new: str, title: str) -> None:
    assert old in ORCHARD
    text = ORCHARD.replace(old, new, 1)
    session, uri = opened(text)
    told = session.diagnostics(uri)
    found = {action.title: action for d in told for action in session.quick_fixes(uri, d.range)}
    assert title in found, (list(found), [d.message for d in told])
    action = found[title]
    assert action.edit is not None and action.edit.document_changes is not None
    (change,) = action.edit.document_changes
    assert isinstance(change, types.TextDocumentEdit)
    session.open(uri, edited(session, uri, change.edits), 2)  # type: ignore[arg-type]
    assert len(session.diagnostics(uri)) < len(told)
    assert change.text_document.version == 1
    assert [d.code for d in action.diagnostics or ()] == [told[0].code]


def test_a_word_of_the_language_gets_another_name_everywhere() -> None:
    session, uri = opened(ORCHARD.replace("ready", "window"))
    (found, *_) = [
        a
        for d in session.diagnostics(uri)
        if d.code == "SJ003"
        for a in session.quick_fixes(uri, d.range)
    ]
    assert found.edit is not None and found.edit.document_changes is not None
    assert len(found.edit.document_changes[0].edits) == 2  # type: ignore[union-attr]


def test_no_fix_is_offered_where_nothing_is_wrong() -> None:
    session, uri = opened(ORCHARD.replace("give apple", "give appel"))
    here = place(session, uri, "episode")
    assert session.quick_fixes(uri, types.Range(here, here)) == []


def test_a_mistake_of_a_variant_is_repaired_there() -> None:
    session, uri = opened(ORCHARD.replace("set apple = 2", "set appel = 2"))
    (found,) = session.diagnostics(uri)
    assert [action.title for action in session.quick_fixes(uri, found.range)] == ["Write `apple`"]
