"""The tour inside the studio is the page of the documents, and each of its games is what that page has built by then."""

from pathlib import Path

import pytest

from sjdsl.compiler import check
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.read import read_source
from sjdsl.doc import differences, read_written, report
from sjdsl.studio.tour import PREFIX, steps, tour_folder
from tests.manual.blocks import BESIDE, frames

PAGE = BESIDE[0]
FRAMES = ("walk", "eat", "grow", "zap", "whole", "berries")
GAMES = [step["game"].removeprefix(PREFIX) for step in steps()[1:]]


def test_the_page_is_that_of_the_documents() -> None:
    assert (tour_folder() / "tour.md").read_text(encoding="utf-8") == PAGE.read_text(
        encoding="utf-8"
    ), "copy docs/tour.md there again"


@pytest.mark.parametrize(("name", "frame"), list(zip(GAMES, FRAMES, strict=True)))
def test_each_game_is_what_the_page_has_built(name: str, frame: str, tmp_path: Path) -> None:
    """`sjdsl diff` finds nothing between them but the name and what the last step is called."""
    assert not check(read_source(tour_folder() / name))
    for other, text in frames().items():
        (tmp_path / f"{other}.sj").write_text(text, encoding="utf-8")
    built = read_written(read_source(tmp_path / f"{frame}.sj"))
    mine = read_written(read_source(tour_folder() / name))
    changes = differences(built, mine)
    assert {line.partition(":")[0] for lines in changes.values() for line in lines} <= {
        "name",
        "title",
    }, report(built, mine)
    assert [variant for variant, _ in built.variants] == [variant for variant, _ in mine.variants]
    for variant, _ in built.variants:
        there, here = (
            read_written(Source(w.name, w.text, w.folder), (variant,))
            for w in (read_source(tmp_path / f"{frame}.sj"), read_source(tour_folder() / name))
        )
        assert differences(there, here) == changes
