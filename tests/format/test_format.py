"""The formatter: the same words and comments, the same tree, short lines; and nothing left to do the second time."""

from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings

from sjdsl.compiler.ast import printer
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.parse import parse
from sjdsl.format import format_source
from sjdsl.format.lines import WIDTH
from tests.format.damage import comments_of, damaged, words_of
from tests.manual.blocks import examples

HERE = Path(__file__).parent
REPOSITORY = HERE.parents[1]
FOLDERS = (
    "games",
    "tests/cases",
    "tests/differential/games",
    "tests/format",
    "tests/policies/games",
    "tests/runtime",
)
LAID_OUT = [path for folder in FOLDERS for path in sorted((REPOSITORY / folder).glob("*.sj"))]
SMALL = [path.read_text("utf-8") for path in sorted((REPOSITORY / "tests/cases").glob("*.sj"))]


def formatted(text: str) -> str:
    return format_source(Source("game.sj", text))


def check_whole(text: str) -> str:
    """Returns a text formatted, after all that holds for every text was checked."""
    result = formatted(text)
    assert list(printer.lines(parse(Source("game.sj", result)))) == list(
        printer.lines(parse(Source("game.sj", text)))
    )
    assert words_of(result) == words_of(text)
    assert comments_of(result) == comments_of(text)
    assert formatted(result) == result
    assert "\n\n\n" not in result
    assert "{\n\n" not in result
    assert all(line == line.rstrip() for line in result.split("\n"))
    assert result.endswith("\n")
    assert not result.endswith("\n\n")
    return result


@pytest.mark.parametrize("path", LAID_OUT, ids=lambda path: path.name)
def test_files_of_the_repository_are_formatted(path: Path) -> None:
    text = path.read_text("utf-8")
    assert text == check_whole(text), f"run `sjdsl fmt {path.relative_to(REPOSITORY)}`"
    assert all(len(line) <= WIDTH for line in text.split("\n"))


@pytest.mark.thorough
def test_texts_of_errors_and_of_the_manual() -> None:
    texts = [
        path.read_text("utf-8") for path in sorted((REPOSITORY / "tests/errors").glob("*.sj"))
    ] + [e.source for e in examples()]
    checked = 0
    for text in texts:
        try:
            parse(Source("game.sj", text))
        except CompileError:
            continue
        check_whole(text)
        checked += 1
    assert checked > 100


@settings(max_examples=60, deadline=None)
@given(damaged(SMALL))
def test_any_spaces_line_ends_and_comments(text: str) -> None:
    result = check_whole(text)
    for line in result.split("\n"):
        assert len(line) <= WIDTH or max(len(word) for word in line.split()) > 100, line


def test_a_file_that_nobody_laid_out(golden: Callable[[Path, str], None]) -> None:
    golden(HERE / "ugly_formatted.sj", check_whole((HERE / "ugly.txt").read_text("utf-8")))


def test_a_text_with_mistakes_is_refused() -> None:
    with pytest.raises(CompileError, match="SJ002"):
        formatted("sj 1\ngame a { kind }\n")
