"""Completion offers what fits the place, and the words of the language that the grammar allows there."""

from pathlib import Path

import pytest
from lsprotocol import types

from sjdsl.editor.session import Session
from tests.editor.asked import ORCHARD, opened


def offered(marked: str) -> list[str]:
    """Returns what is offered at the `|` of a text, which was the orchard before it was changed."""
    session, uri, position = asked(marked)
    found = session.completion(uri, position)
    assert len({item.label for item in found}) == len(found)
    return [item.label for item in found]


def asked(marked: str) -> tuple[Session, str, types.Position]:
    session, uri = opened()
    session.completion(uri, types.Position(0, 0))
    session.open(uri, marked.replace("|", "", 1), 2)
    document = session.documents.get(uri)
    assert document is not None
    return session, uri, document.lines.position(marked.index("|"))


def inside(statement: str) -> str:
    """Returns the orchard with an unfinished phase, behind another one that is not finished either."""
    return ORCHARD.replace("  observe {", f"  phase late {{ {statement} }}\n  observe {{").replace(
        "phase walk {", "phase  {", 1
    )


@pytest.mark.parametrize(
    ("statement", "wanted", "unwanted"),
    [
        (
            "each agent as a { set a.| }",
            {"bag", "sore", "row", "col", "heading", "away"},
            {"fruit", "apple", "each"},
        ),
        ("each tree { when tree.| }", {"fruit", "owner", "row"}, {"bag", "index"}),
        ("each agent where agent chose |", {"zap", "share", "stay"}, {"apple", "agent", "walk"}),
        ("each |", {"agent", "tree", "bush", "plants"}, {"apple", "beam", "each"}),
        ("each agent as a { each agent as b in | }", {"beam", "disc", "line"}, {"walk"}),
        ("each agent as a { mark | }", {"beam", "disc"}, {"a"}),
        ("each tree where tree.fruit is |", {"none", "ripe", "not"}, {"walk"}),
        ("each agent { tally |", {"eaten", "hits", "given"}, {"ripe_trees"}),
        ("observe { show event |", {"eaten", "hits", "given"}, {"ripe_trees"}),
        (
            "each agent { give | to agent }",
            {"apple", "agent", "ready", "step", "min"},
            {"walk", "each"},
        ),
        ("each agent as me { send | }", {"me"}, {"tree"}),
        ("each agent { send agent to gate facing |", {"north", "same"}, {"apple"}),
        (
            "each agent as a { let mine = a.bag } each agent { add 1 to | }",
            {"agent"},
            {"a", "mine", "tree"},
        ),
        ("|", {"each", "when", "chance", "let"}, {"kind", "agent", "apple"}),
    ],
)
def test_what_fits_in_a_phase_is_offered(
    statement: str, wanted: set[str], unwanted: set[str]
) -> None:
    found = set(offered(inside(statement)))
    assert wanted <= found
    assert not unwanted & found


@pytest.mark.parametrize(
    ("old", "new", "wanted", "unwanted"),
    [
        (
            "schedule tick -> grow",
            "schedule tick -> |",
            {"grow", "walk", "tick"},
            {"start", "apple"},
        ),
        ("set apple = 2", "drop |", {"eat", "ripe_trees", "beam", "apple"}, {"each"}),
        ("with never(zap)", "with |", {"eater_first", "random", "never", "seek"}, {"tree"}),
        ("never(zap)", "never(|)", set(), {"tree"}),
        (
            "define ready(who) = who.bag > 0",
            "define ready(who) = |",
            {"who", "apple", "count"},
            {"tree", "walk"},
        ),
        ("episode 20", "episode 20\n  |", {"kind", "phase", "agents", "variant"}, {"each", "tree"}),
        ("phase walk {", "phase claim at | { }\n  phase walk {", {"start"}, {"tree", "agent"}),
        ("observe { window ahead 2", "observe { window |", {"ahead", "left"}, {"tree"}),
        ("always count(agent)", "always count(|)", {"agent", "tree"}, {"apple"}),
        ("{ always count", "{ |  always count", {"require", "expect"}, {"each"}),
        ('"An orchard" {', '"An | orchard" {', set(), {"kind", "tree"}),
    ],
)
def test_what_fits_in_a_declaration_is_offered(
    old: str, new: str, wanted: set[str], unwanted: set[str]
) -> None:
    assert old in ORCHARD
    found = set(offered(ORCHARD.replace(old, new, 1)))
    assert wanted <= found
    assert not unwanted & found


def test_words_of_a_field_come_first() -> None:
    session, uri, position = asked(inside("each tree where tree.fruit is |"))
    items = sorted(session.completion(uri, position), key=lambda item: item.sort_text or "")
    assert [item.label for item in items[:2]] == ["none", "ripe"]


def test_the_word_begun_is_replaced() -> None:
    session, uri, position = asked("# é😀\n" + inside("each agent { give ap| to agent }"))
    (apple,) = [item for item in session.completion(uri, position) if item.label == "apple"]
    assert apple.text_edit == types.TextEdit(
        types.Range(types.Position(position.line, position.character - 2), position), "apple"
    )
    assert apple.detail == "param apple : reward = 1"


def test_a_function_comes_with_what_it_gives() -> None:
    session, uri, position = asked(inside("each agent { give rou| to agent }"))
    (found,) = [item for item in session.completion(uri, position) if item.label == "round"]
    assert found.detail == "round(x): the nearest whole number; of two, the even one"


def test_files_are_offered_in_quotes(tmp_path: Path) -> None:
    (tmp_path / "maps").mkdir()
    for name in ("base.sj", "maps/small.txt", "notes.md"):
        (tmp_path / name).write_text("")
    text = 'sj 1\ngame g "G" extends "'
    session, uri = opened(text, tmp_path, "g.sj")
    assert [item.label for item in session.completion(uri, types.Position(1, 22))] == ["base.sj"]
    session.open(uri, 'sj 1\ngame g "G" { map "ma" }', 2)
    assert [item.label for item in session.completion(uri, types.Position(1, 20))] == [
        "maps/small.txt"
    ]
