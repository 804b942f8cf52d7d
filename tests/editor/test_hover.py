"""Hover says what a name is, and what a function gives."""

import pytest

from sjdsl.compiler.ir.operations import FUNCTIONS, Function
from tests.editor.asked import ORCHARD, opened, place


def shown(before: str, text: str = ORCHARD) -> str:
    session, uri = opened(text)
    found = session.hover(uri, place(session, uri, before))
    return "" if found is None else found.contents.value  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("before", "parts"),
    [
        (
            "give app",
            ("param apple   : reward      = 1                # ours", "`apple` is 1 (reward)"),
        ),
        ("-> ea", ("phase eat {", "give apple to eater")),
        ("tree.own", ("field owner : agent",)),
        ("on tr", ('kind tree  "T"',)),
        ("each pla", ("group plants = tree, bush",)),
        ("chose za", ("zap",)),
        ("tally hi", ("event hits",)),
        ("policy eater_f", ("seek tree where tree.fruit is ripe",)),
    ],
)
def test_a_name_is_shown_with_its_declaration(before: str, parts: tuple[str, ...]) -> None:
    text = shown(before)
    assert [part for part in parts if part not in text] == [], text


@pytest.mark.parametrize(
    "function", [row for row in FUNCTIONS.values() if not row.word], ids=lambda row: row.name
)
def test_a_function_is_explained(function: Function) -> None:
    text = shown(
        f"give {function.name[:-1]}", ORCHARD.replace("give apple", f"give {function.name}(apple)")
    )
    assert [use for use in function.uses if f"`{use[0]}`: {use[1]}" not in text] == []


@pytest.mark.parametrize("before", ["  episode 20\n", "  epis", "give appe"])
def test_nothing_is_said_of_spaces_keywords_and_unknown_names(before: str) -> None:
    assert shown(before, ORCHARD.replace("give apple", "give appel")) == ""
