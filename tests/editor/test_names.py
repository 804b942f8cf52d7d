"""Every name is found with every place where it stands: renamed all at once, each game still compiles; a mistake hides no other name."""

from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from sjdsl.compiler import check
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.editor.navigation import FIXED
from sjdsl.editor.session import Session
from tests.editor.asked import ORCHARD, opened

FILES = sorted((Path(__file__).parents[2] / "games").rglob("*.sj"))
GAMES = [
    path for path in FILES if path.parent.name != "shared"
]  # the others are bases, and no games
SESSION = Session()


@cache
def renamed(path: Path) -> str:
    """Returns a game in which every name that it declares has two letters more."""
    analysis = SESSION.analyses.of(path.as_uri())
    assert analysis is not None
    text = analysis.document.text
    for end in sorted(_ends(path), reverse=True):
        text = text[:end] + "_q" + text[end:]
    return text


def _ends(path: Path) -> Iterator[int]:
    analysis = SESSION.analyses.of(path.as_uri())
    assert analysis is not None
    for o in {o.span: o for o in analysis.occurrences}.values():
        symbol = o.symbols[0]
        if symbol.name not in FIXED.get(symbol.space, ()):
            yield o.span.end


@pytest.mark.thorough
@pytest.mark.parametrize("path", GAMES, ids=lambda path: path.stem)
def test_a_game_with_other_names_still_compiles(path: Path) -> None:
    source = Source(
        path.as_posix(),
        renamed(path),
        path.parent,
        lambda other: renamed(other) if other in FILES else None,
    )
    assert "_q" in source.text
    assert [f"{d.span.line}: {d.message}" for d in check(source) if d.severity == "error"] == []


@pytest.mark.parametrize("path", GAMES, ids=lambda path: path.stem)
def test_elaboration_resolves_every_name(path: Path) -> None:
    """What is read by the name alone is for texts with mistakes, and for defines that nobody uses."""
    analysis = SESSION.analyses.of(path.as_uri())
    assert analysis is not None and analysis.file is not None
    left = [o for o in analysis.occurrences if not o.declares and o.span not in analysis.resolved]
    assert [(o.span.line, o.symbols[0].name) for o in left] == []


@pytest.mark.parametrize(
    ("sound", "damaged", "lost"),
    [
        ("give apple to eater", "give aplle to eater", set()),
        ("give apple to eater", "add  apple to eater", set()),
        ("agents players {", "agents playerz {", set()),
        ("kind gate  ", "kind gatt  ", {"gate"}),
        ('kind gate  "G"', 'kind gate  "T"', set()),
        ("field bag : 0 .. 9", "field bag : 9 .. 0", set()),
        ("in beam of zapper", "in beam of zappar", set()),
        ("where zapper chose zap", "where zapped chose zap", set()),
        ("set tree.owner = eater", "set tree.ownar = eater", set()),
        ("and ready(zapper)", "and reedy(zapper)", {"who"}),
        ("policy eater_first", "policy random     ", set()),
        ("set apple = 2", "set aplle = 2", set()),
    ],
)
def test_a_mistake_hides_no_other_name_but_local_ones_beside_it(
    sound: str, damaged: str, lost: set[str]
) -> None:
    assert len(sound) == len(damaged) and ORCHARD.count(sound) == 1
    before, after = (_meanings(text) for text in (ORCHARD, ORCHARD.replace(sound, damaged)))
    begin, end = ORCHARD.index(sound), ORCHARD.index(sound) + len(sound)
    gone = {
        name
        for (at, name), symbols in before.items()
        if not begin <= at < end and not symbols <= after.get((at, name), set())
    }
    assert gone == lost


def test_a_define_that_nobody_uses_is_read() -> None:
    text = ORCHARD.replace(
        "  define ready",
        "  define idle(who) = who.bag > 0 and count(tree where tree.fruit is ripe) > 0\n  define ready",
    )
    found = _meanings(text)
    assert found[text.index("who.bag") + 4, "bag"] == {Symbol("field", "bag", "agent")}
    assert Symbol("field", "fruit", "tree") in found[text.index("fruit is ripe) > 0"), "fruit"]


def test_a_game_without_its_base_is_read() -> None:
    text = ORCHARD.replace('"An orchard" {', '"An orchard" extends "nowhere.sj" {')
    found = _meanings(text)
    assert found[text.index("apple to eater"), "apple"] == {Symbol("name", "apple")}
    assert found[text.index("zap and ready"), "zap"] == {Symbol("action", "zap")}


def _meanings(text: str) -> dict[tuple[int, str], set[Symbol]]:
    """Returns what each name of a text stands for, by its place and itself."""
    session, uri = opened(text)
    analysis = session.analyses.of(uri)
    assert analysis is not None
    return {
        (o.span.start, text[o.span.start : o.span.end]): set(o.symbols)
        for o in analysis.occurrences
    }
