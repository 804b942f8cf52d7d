"""The texts of the games: how long they are, and that each number says where it is from."""

import re
from collections.abc import Iterator
from dataclasses import dataclass

import pytest

from sjdsl.compiler import ast
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.compiler.syntax.parse import parse
from sjdsl.compiler.syntax.read import read_source
from sjdsl.library.games_folder import find_game, main_games

MOST_LINES = 80  # a game is read aloud: non-blank lines of the rules, without comments, each of at most WIDTH columns
APART = (
    ast.Map,
    ast.Checks,
    ast.Variant,
    ast.Look,
    ast.ScriptedPolicy,
    ast.Scenario,
)  # what is no rule
WIDTH = 140
SOURCE = re.compile(r"\b(paper|released code|Melting Pot)\b|\bours: \S")
STRING = re.compile(r'"[^"\n]*"')
NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d+)?")
SELF_EVIDENT = {"0", "1"}  # outside of `size`, `param` and `set`: nothing, one, the next


@dataclass(frozen=True)
class Line:
    """One line without its texts in quotes: what it says, and its comment."""

    number: int
    code: str
    comment: str


def lines_of(text: str) -> list[Line]:
    """Returns the lines of a game."""
    split = [STRING.sub('""', line).partition("#") for line in text.split("\n")]
    return [Line(number, code, comment) for number, (code, _, comment) in enumerate(split, 1)]


def counted_lines(source: Source) -> int:
    """Returns the number of lines by the rule of `MOST_LINES`."""
    apart = [s.span for s in parse(source).game.sections if isinstance(s, APART)]
    text = source.text
    for span in apart:
        text = (
            text[: span.start]
            + re.sub(r"[^\n]", " ", text[span.start : span.end])
            + text[span.end :]
        )
    return sum(bool(line.code.strip()) for line in lines_of(text))


def numbers_of(source: Source) -> Iterator[tuple[str, set[int]]]:
    """Yields each number of the game: what it is, and the lines of which one must name its source.

    Of `size`, `param` and `set`: whatever its value. Of all else outside of the checks, where checks choose their own
    numbers: what is neither 0 nor 1.
    """
    lines, sections = lines_of(source.text), list(all_sections(parse(source).game.sections))
    covered: set[int] = {1}  # `sj 1`
    for section in sections:
        rows = lines_within(source, section.span)
        match section:
            case ast.Constant():
                yield section.name.text, rows
                covered |= rows
            case ast.Override():
                yield f"set {section.path.name.text}", rows
                covered |= rows
            case ast.Checks() | ast.Look() | ast.Scenario():
                covered |= rows
            case ast.Observe() | ast.Shape():
                if NUMBER.search("".join(line.code for line in lines if line.number in rows)):
                    yield type(section).__name__.lower(), rows
                covered |= rows
    for line in lines:
        found = set(NUMBER.findall(line.code)) - SELF_EVIDENT
        if found and line.number not in covered:
            yield f"line {line.number}: {', '.join(sorted(found))}", {line.number}


def all_sections(
    sections: tuple[ast.Section, ...],
) -> Iterator[ast.Section | ast.Override | ast.Drop]:
    """Yields the sections of a game and of its variants."""
    for section in sections:
        yield section
        if isinstance(section, ast.Variant):
            yield from section.changes


def lines_within(source: Source, span: Span) -> set[int]:
    """Returns the numbers of the lines that a part of a text touches."""
    return set(range(span.line, source.span(span.end, span.end).line + 1))


def without_source(source: Source) -> list[str]:
    """Returns the numbers of a game of which no line says where they are from."""
    comments = {line.number: line.comment for line in lines_of(source.text)}
    return [
        name
        for name, rows in numbers_of(source)
        if not any(SOURCE.search(comments[row]) for row in rows)
    ]


@pytest.mark.parametrize("game", main_games())
def test_a_game_is_short(game: str) -> None:
    assert counted_lines(read_source(find_game(game))) <= MOST_LINES


@pytest.mark.parametrize("game", main_games())
def test_lines_are_not_wide(game: str) -> None:
    assert [
        n for n, line in enumerate(find_game(game).read_text().split("\n"), 1) if len(line) > WIDTH
    ] == []


@pytest.mark.parametrize("game", main_games())
def test_each_number_says_where_it_is_from(game: str) -> None:
    assert without_source(read_source(find_game(game))) == []


PLANTED = """sj 1
game planted "Nine lines, four of them numbers without a source" {
  size  a : count = 7 in 2 .. 9     # paper
  # a comment, and a blank line

  param b : count = 3               # as always
  param c : reward = {              # ours: a guess
    one: 5, two: 6 }
  kind soil "2"
  map { "222"
        "222" }
  agents a { acts stay }
  phase start { each agent { send agent to soil } }
  schedule rest
  phase rest { when step >= 50 { give 1 to all } }
  observe { window ahead 3 }        # ours:
  checks { expect b == 0 with random over 30 episodes }
  variant more { set a = 8          # Melting Pot
                 set b = 4 }
}
"""


def test_planted_faults_are_found() -> None:
    planted = Source("planted.sj", PLANTED)
    assert without_source(planted) == ["b", "observe", "set b", "line 15: 50"]
    assert counted_lines(planted) == 13
