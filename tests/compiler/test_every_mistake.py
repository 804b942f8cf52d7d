"""A check reports every mistake at once: what stands beside, inside or after something wrong is read all the same."""

from pathlib import Path

import pytest

from sjdsl.compiler import check
from sjdsl.compiler.diagnostics.diagnostic import Diagnostic
from sjdsl.compiler.diagnostics.source import Source

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
