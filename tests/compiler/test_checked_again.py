"""A text that is checked again after an edit: what was lowered before is not lowered again, and nothing is overlooked for it."""

from pathlib import Path
from random import Random

import pytest

import sjdsl.compiler as compiler
from sjdsl.compiler import check
from sjdsl.compiler.diagnostics.source import Source
from tests.damage import edits

COUNTED = """sj 1
game small "Small" {
  episode 10
  kind floor "."
  map { "..." }
  agents 2 { acts stay }
  phase start { each agent { send agent to floor } }
  schedule pay
  phase pay { each agent as a { give 1 to a } }
  variant dear { phase pay { each agent as a { give 2 to a } } }
}
"""


@pytest.fixture
def lowered(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The names of the games that are lowered from now on."""
    names: list[str] = []
    lower_build = compiler.lower_build
    monkeypatch.setattr(
        compiler,
        "lower_build",
        lambda made, source: names.append(made.game.name) or lower_build(made, source),
    )
    compiler._lowered.cache_clear()
    return names


def test_only_rules_that_changed_are_lowered_again(lowered: list[str]) -> None:
    for variant in ((), ("dear",)):
        assert not [d for d in check(Source("small.sj", COUNTED), variant) if d.severity == "error"]
    assert len(lowered) == 2
    for remark in ("# a\n", "# ab\n\n"):
        edited = COUNTED.replace("game small", remark + "game small").replace("give 2", "give 3")
        check(Source("small.sj", edited))
        check(Source("small.sj", edited), ("dear",))
    assert len(lowered) == 3  # the variant, once
    check(Source("small.sj", COUNTED.replace("give 1", "give 4")))
    assert len(lowered) == 4


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
