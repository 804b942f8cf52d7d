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
from tests.format.damage import LONG, comments_of, damaged, words_of
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


def in_block(body: str) -> str:
    """Returns a formatted phase body of one game, without what is around it."""
    text = formatted(f"sj 1\ngame a {{\nphase p {{\n{body}\n}}\n}}\n")
    start, end = "sj 1\ngame a {\n  phase p {\n", "  }\n}\n"
    assert text.startswith(start)
    assert text.endswith(end)
    return text[len(start) : -len(end)]


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


def test_sentences_stay_on_one_line_as_long_as_they_fit() -> None:
    short = "set a = 1  give 2 to b\n"
    assert in_block("set a=1 give 2 to b") == f"    {short}"
    long = " ".join(f"set some_field = {number}" for number in range(100, 106))
    assert in_block(long).startswith("    set some_field = 100  set some_field = 101  ")
    assert in_block(f"{long} set b = 1").split("\n")[:2] == [
        "    set some_field = 100",
        "    set some_field = 101",
    ]


def test_a_block_is_on_one_line_or_open() -> None:
    assert (
        in_block("each agent { each tree {\nend } }")
        == "    each agent {\n      each tree {\n        end\n      }\n    }\n"
    )
    assert in_block("each\nagent\n{ end }") == "    each agent { end }\n"


def test_branches_follow_an_open_block_and_stand_alone_behind_a_short_one() -> None:
    assert (
        in_block("when a { end }\notherwise { end }")
        == "    when a { end }\n    otherwise { end }\n"
    )
    assert (
        in_block("when a {\nend }\notherwise { end }")
        == "    when a {\n      end\n    } otherwise { end }\n"
    )
    assert (
        in_block("when a { end } otherwise {\nend }")
        == "    when a { end }\n    otherwise {\n      end\n    }\n"
    )


@pytest.mark.parametrize("more", range(16))
def test_a_long_condition_behind_the_brace_of_the_branch_before(more: int) -> None:
    """Whether its lists are opened depends on where it begins, behind that brace; at the lengths around the limit, too."""
    condition = f"case b {{ 0 .. 2: {'c' * (80 + more)}, 3..: 4 }} != 1"
    check_whole(
        f"sj 1\ngame a {{\nphase p {{\nwhen a {{\nend\n}} otherwise when {condition} {{\nend\n}}\n}}\n}}\n"
    )


@pytest.mark.parametrize(
    ("given_text", "wanted"),
    [
        ("let a=- 1-( 2+b[ c ] )", "let a = -1 - (2 + b[c])"),
        (
            "let a=not(b)or count ( agent on tree )>=max (1,2)",
            "let a = not (b) or count(agent on tree) >= max(1, 2)",
        ),
        (
            "let a=case b{0:1,1..2:3,4 ..:5,red:6}",
            "let a = case b { 0: 1, 1 .. 2: 3, 4..: 5, red: 6 }",
        ),
        ("when a in 1..3{end}", "when a in 1 .. 3 { end }"),
        ("draw a from{b:1,c:2}", "draw a from { b: 1, c: 2 }"),
        ("chance a{}otherwise{}", "chance a { } otherwise { }"),
        ("add-1 to a . b[ c ]", "add -1 to a.b[c]"),
    ],
)
def test_spaces(given_text: str, wanted: str) -> None:
    assert in_block(given_text) == f"    {wanted}\n"


def test_blank_lines_stay_between_sentences_one_at_most() -> None:
    assert (
        in_block("\n\nend\n\n\n\nend\n# a\n\n\n# b\nend\n\n")
        == "    end\n\n    end\n    # a\n\n    # b\n    end\n"
    )


def test_a_comment_too_long_for_its_line_stands_above_it_and_goes_on() -> None:
    lines = in_block(f"end\nend # {LONG}\nend").split("\n")
    assert lines[0] == "    end"
    assert lines[1].startswith("    # word0 word1")
    assert lines[2].startswith("    # word")
    assert lines[-3:] == ["    end", "    end", ""]
    assert " ".join(line.removeprefix("    # ") for line in lines[1:-3]) == LONG


def test_comments_share_a_column_where_their_lines_are_about_as_long() -> None:
    far = f"let a = {' + '.join(['b'] * 12)}"
    text = in_block(f"end # 1\nset a = 1\nset a = b # 2\n{far} # 3\n{far} + c # 4\n\nend # 5")
    at = [line.index("#") for line in text.split("\n") if "#" in line]
    first, second = len("    set a = b  "), len(f"    {far} + c  ")
    assert at == [first, first, second, second, len("    end  ")]


def test_columns_of_declarations() -> None:
    text = formatted(
        'sj 1 game a {\nsize n : count = 1\nparam long : probability = 0.5\nkind x "x"\nkind long_one "y" {\ntimer t }\n}'
    )
    assert text.split("\n")[2:6] == [
        "  size  n    : count       = 1",
        "  param long : probability = 0.5",
        '  kind x        "x"',
        '  kind long_one "y" {',
    ]


def test_rules_of_policies_and_slots_of_scenarios_are_sentences() -> None:
    rules = "seek a avoiding b when c choose d\naim e at f avoiding g choose h"
    text = formatted(
        f'sj 1 game a {{ policy p "x"{{ {rules} }} scenario s{{slots 1 focal slots n-1 policy p}} }}'
    )
    assert text.split("\n")[2:7] == [
        '  policy p "x" {',
        "    seek a avoiding b  when c choose d",
        "    aim e at f avoiding g choose h",
        "  }",
        "  scenario s { slots 1 focal  slots n - 1 policy p }",
    ]


def test_no_columns_where_they_would_make_a_line_too_long() -> None:
    long = "x" * 60
    text = formatted(
        f"sj 1 game a {{\nparam b : count = {' + '.join(['c'] * 20)}\nparam {long} : count = 1\n}}"
    )
    assert "  param b : count = c + " in text
    assert f"  param {long} : count = 1" in text


def test_ranges_keep_their_spaces_in_tables_and_rows() -> None:
    text = "sj 1\ngame a {\n  param gift by 0 .. 3 : reward = { 0: 0, 1 .. 2: 1, 3..: 2 }\n  param long : steps = 1\n}\n"
    assert check_whole(text) == text
