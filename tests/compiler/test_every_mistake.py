"""A check reports every mistake at once: what stands beside, inside or after something wrong is read all the same."""

from pathlib import Path

import pytest

from sjdsl.compiler import check
from sjdsl.compiler.diagnostics.diagnostic import Diagnostic
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.near_names import either, meant, nearest
from tests.editor.asked import opened

GAME = (Path(__file__).parents[2] / "examples" / "orchard.sj").read_text(encoding="utf-8")
RULE = "set tree.fruit = none\n      give 1 to agent"


def found(text: str) -> list[Diagnostic]:
    return [d for d in check(Source("orchard.sj", text)) if d.severity == "error"]


def misspelt(text: str, words: list[str]) -> None:
    """Asserts that just these words are reported, each where it stands."""
    assert [text[d.span.start : d.span.end] for d in found(text)] == words


@pytest.mark.parametrize(
    ("rule", "words"),
    [
        ("when tree.friut is noen { give bery to agent }", ["friut", "noen", "bery"]),
        (
            "when tree.friut is not noen and agent.rwo > appel { }",
            ["friut", "noen", "rwo", "appel"],
        ),
        ("when tree.friut in { rpie, none } or step > lenght { }", ["friut", "rpie", "lenght"]),
        ("when tree.friut in 0 .. lots { }", ["friut", "lots"]),
        ("set tree.friut = rpie", ["friut", "rpie"]),
        ("add appel to agent.bga", ["appel", "bga"]),
        ("give appel to agnet", ["appel", "agnet"]),
        (
            "when appel > 1 { when tree.friut is ripe { set tree.fruit = rpie } }",
            ["appel", "friut", "rpie"],
        ),
        (
            "when appel > 1 { give bery to agent } otherwise { give cherry to agent }",
            ["appel", "bery", "cherry"],
        ),
        (
            "chance appel { give bery to agent } otherwise chance pear { give cherry to agent }",
            ["appel", "bery", "pear", "cherry"],
        ),
        ("each tree as t where t.friut is ripe { set t.fruit = noen }", ["friut", "noen"]),
        ("pick 1 tree as t where t.friut is ripe { set t.fruit = noen }", ["friut", "noen"]),
        (
            "match tree as a where a.friut is ripe with tree as b in disc(1) of a { set b.fruit = noen }",
            ["friut", "noen"],
        ),
        # what may be a word, a value or a place is no mistake only because what it is compared with is one
        ("when tree.friut is ripe { set tree.friut = none }", ["friut", "friut"]),
        ("when agent.headng is north or agent.frend is nobody { }", ["headng", "frend"]),
        ("when tree.friut in { ripe, none } { }", ["friut"]),
        ("when tree.friut > 0 { give 1 / tree.row to agent }", ["friut"]),
    ],
)
def test_a_mistake_hides_no_other(rule: str, words: list[str]) -> None:
    misspelt(GAME.replace(RULE, rule), words)


def test_words_of_a_declaration_with_a_mistake_are_not_missed() -> None:
    game = GAME.replace(
        "field fruit : { none, ripe } = ripe", "field fruit : { none, ripe } = rpie"
    )
    misspelt(
        game.replace(RULE, "when tree.fruit is ripe { set tree.friut = ripe }"), ["rpie", "friut"]
    )


@pytest.mark.parametrize(
    ("name", "known", "near"),
    [
        ("eest", ["north", "east", "south", "west"], ("east", "west")),
        ("est", ["north", "east", "south", "west"], ("east", "west")),
        ("ripee", ["none", "ripe"], ("ripe",)),
        ("cat", ["bat", "hat", "rat", "dog"], ("bat", "hat", "rat")),
        ("cat", ["cat", "cart"], ("cart",)),
        ("zebra", ["north", "east"], ()),
        ("zebra", [], ()),
    ],
)
def test_all_that_are_equally_near_are_meant(
    name: str, known: list[str], near: tuple[str, ...]
) -> None:
    assert nearest(name, known) == near


def test_alternatives_are_listed() -> None:
    assert [either(names) for names in ((), ("a",), ("a", "b"), ("a", "b", "c"))] == [
        "",
        "`a`",
        "`a` or `b`",
        "`a`, `b` or `c`",
    ]
    assert meant("eest", ["east", "west"]) == "; did you mean `east` or `west`?"


def test_messages_offer_all_that_are_equally_near() -> None:
    game = GAME.replace(
        "size  players", "param bet : reward = 1\n  param bat : reward = 1\n  size  players"
    ).replace("give 1 to", "give bit to")
    (mistake,) = found(game)
    assert mistake.hint == "did you mean `bat` or `bet`?"
    assert [suggestion.says for suggestion in mistake.suggestions] == ["write `bat`", "write `bet`"]
    game = GAME.replace(RULE, "when agent.heading is eest { give 1 to agent }")
    (mistake,) = found(game)
    assert mistake.hint.startswith("did you mean `east` or `west`? the words are")
    session, uri = opened(game)
    (shown,) = [d for d in session.diagnostics(uri) if d.severity == 1]
    fixes = session.quick_fixes(uri, shown.range)
    assert [(fix.title, fix.is_preferred) for fix in fixes] == [
        ("Write `east`", False),
        ("Write `west`", False),
    ]
