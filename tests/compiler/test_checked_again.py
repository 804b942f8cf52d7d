"""A text that is checked again after an edit: what was lowered before is not lowered again, and nothing is overlooked for it."""

from pathlib import Path
from random import Random

import pytest

import sjdsl.compiler as compiler
from sjdsl.compiler import check
from sjdsl.compiler.diagnostics.source import Source
from tests.damage import edits


@pytest.mark.parametrize("game", ["coins", "pd_arena"])
def test_an_edited_game_has_the_messages_of_one_that_is_new(game: str) -> None:
    folder = Path(edits.FOLDER)
    source = Source(f"{game}.sj", (folder / f"{game}.sj").read_text("utf-8"), folder)
    check(source)
    for seed, kind in enumerate(("number", "swap", "duplicate")):
        edited = Source(source.name, edits.edit(game, kind, Random(seed)).text, folder)
        found = check(edited)
        compiler._lowered.cache_clear()
        assert check(edited) == found


def test_what_cannot_be_lowered_is_said_again_where_it_is_then() -> None:
    text = (Path(__file__).parents[1] / "errors/SJ601_not_supported.sj").read_text("utf-8")
    first = check(Source("game.sj", text))
    second = check(Source("game.sj", text.replace("game ", "\n\ngame ", 1)))
    assert [d.code for d in second] == [d.code for d in first] == ["SJ601"]
    assert second[0].span.line == first[0].span.line + 2
