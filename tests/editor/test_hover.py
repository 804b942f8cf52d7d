"""Hover says what a name is, what a word of the language means, and what a message is about."""

from pathlib import Path

import pytest

from sjdsl.compiler.diagnostics.explanations import explain
from sjdsl.compiler.ir.operations import FUNCTIONS, Function
from sjdsl.compiler.syntax.parse import automaton
from sjdsl.editor.hover import examples, meanings
from tests.editor.asked import ORCHARD, opened, place

MANUAL = Path(__file__).parents[2] / "docs" / "language.md"


def shown(before: str, text: str = ORCHARD, folder: Path | None = None) -> str:
    session, uri = opened(text, folder)
    found = session.hover(uri, place(session, uri, before))
    return "" if found is None else found.contents.value  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("before", "parts"),
    [
        ("give app", ("param apple   : reward      = 1                # ours",)),
        ("-> ea", ("phase eat {",)),
        ("tree.own", ("field owner : agent",)),
        ("on tr", ('kind tree  "T"',)),
        ("each pla", ("group plants = tree, bush",)),
        ("chose za", ("zap",)),
        ("tally hi", ("event hits",)),
        ("policy eater_f", ("seek tree where tree.fruit is ripe",)),
        ("    mo", ("**`moves`**", "one cell the way the agent faces", "moves relative")),
        ("phase walk { mo", ("**`move`**", "move each agent")),
    ],
)
def test_a_place_is_explained(before: str, parts: tuple[str, ...]) -> None:
    text = shown(before)
    assert [part for part in parts if part not in text] == [], text


def test_a_message_is_explained_with_the_name_that_it_is_about() -> None:
    assert shown("episode ", ORCHARD.replace("give apple", "give appel")) == ""  # the game has a mistake, but not at this place
    text = shown("give appe", ORCHARD.replace("give apple", "give appel"))
    assert text == explain("SJ101")


def test_a_mistake_of_one_variant_is_explained_too() -> None:
    assert explain("SJ108") in shown("set orang", ORCHARD.replace("set apple", "set orange"))


@pytest.mark.parametrize("function", [row for row in FUNCTIONS.values() if not row.word], ids=lambda row: row.name)
def test_a_function_is_explained(function: Function) -> None:
    text = shown(f"give {function.name[:-1]}", ORCHARD.replace("give apple", f"give {function.name}(apple)"))
    assert [use for use in function.uses if f"`{use[0]}`: {use[1]}" not in text] == []


def test_nothing_is_said_of_nothing() -> None:
    assert shown("  episode 20\n") == ""


def test_every_word_of_the_language_has_a_sentence_of_the_manual_and_an_example() -> None:
    words = {word for word in automaton().words.values() if word.isalpha()}
    assert set(meanings()) == words
    assert words - set(examples()) == set()
    page = " ".join(MANUAL.read_text("utf-8").split())
    assert [(word, sentence) for word, told in meanings().items() for sentence in told if sentence not in page] == []
    assert all(word in line for word, lines in examples().items() for line in lines)
