"""Every name is found with every place where it stands: renamed all at once, each game still compiles."""

from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from sjdsl.compiler import check
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.editor.family import read_names
from sjdsl.editor.navigation import FIXED, MEANT
from sjdsl.editor.session import Session

FILES = sorted((Path(__file__).parents[2] / "games").rglob("*.sj"))
GAMES = [path for path in FILES if path.parent.name != "shared"]  # the others are bases, and no games
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
    for o in {o.span: o for o in read_names(analysis)}.values():
        symbol = o.symbols[0]
        if symbol.name not in FIXED.get(symbol.space, ()) and (symbol.space != "word" or symbol.name not in MEANT):
            yield o.span.end


@pytest.mark.parametrize("path", GAMES, ids=lambda path: path.stem)
def test_a_game_with_other_names_still_compiles(path: Path) -> None:
    source = Source(path.as_posix(), renamed(path), path.parent, lambda other: renamed(other) if other in FILES else None)
    assert "_q" in source.text
    assert [f"{d.span.line}: {d.message}" for d in check(source) if d.severity == "error"] == []
