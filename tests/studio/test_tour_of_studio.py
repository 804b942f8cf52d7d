"""The tour inside the studio is the page of the documents, and each of its games is what that page has built by then."""

import re
from pathlib import Path
from textwrap import indent

import pytest

from sjdsl.compiler import check
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.read import read_source
from sjdsl.doc import differences, read_written, report
from sjdsl.studio.tour import PREFIX, steps, tour_folder
from tests.manual.blocks import BESIDE, blocks, frames

PAGE = BESIDE[0]
FRAMES = ("walk", "eat", "grow", "zap", "whole", "berries")
GAMES = [step["game"].removeprefix(PREFIX) for step in steps()[1:]]


def test_the_page_is_that_of_the_documents() -> None:
    assert (tour_folder() / "tour.md").read_text(encoding="utf-8") == PAGE.read_text(
        encoding="utf-8"
    ), "copy docs/tour.md there again"


def test_there_are_six_steps_to_read() -> None:
    assert [step["title"][:2] for step in steps()] == ["A ", "1.", "2.", "3.", "4.", "5.", "6."]
    assert all((tour_folder() / name).is_file() for name in GAMES)
    for step in steps():
        assert "](" not in step["text"], "a link would lead out of the page"
        assert "frame=" not in step["text"]
        assert step["text"].count("```") % 2 == 0


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


def put_in(block: str, text: str) -> str:
    """Returns a game with the declarations of a block where the page tells a reader to put them."""
    for declaration in re.split(r"\n(?=\w)", block.strip()):
        keyword, name = re.findall(r"\w+", declaration)[:2]
        words = (
            keyword
            if keyword in ("schedule", "metrics", "observe", "checks")
            else f"{keyword} {name}"
        )
        new = indent(declaration, "  ") + "\n"
        text, replaced = re.subn(
            rf"^  {words}\b.*?\n(?=\n*(?:  \w|\}}))",
            lambda _, new=new: new,
            text,
            flags=re.MULTILINE | re.DOTALL,
        )
        assert replaced <= 1
        if not replaced:
            text = text.rstrip().removesuffix("}") + new + "}\n"
    return text


def test_a_reader_who_follows_the_page_gets_these_games() -> None:
    text = ""
    for block, name in zip((b for b in blocks(PAGE) if "frame" in b.info), GAMES, strict=True):
        text = put_in(block.text, text) if text else block.text
        source, mine = Source(name, text, tour_folder()), read_source(tour_folder() / name)
        assert not check(source)
        for variant, _ in read_written(mine).variants or [("", "")]:
            chosen = (variant,) if variant else ()
            assert differences(read_written(source, chosen), read_written(mine, chosen)) == {}, name
