"""The Pygments lexer colours every text of the language, loses nothing of it, and agrees with the TextMate grammar's patterns."""

import tomllib
from importlib import import_module
from itertools import groupby
from operator import itemgetter
from pathlib import Path

import pytest
from pygments.token import (
    Comment,
    Error,
    Keyword,
    Name,
    Number,
    Operator,
    Punctuation,
    String,
    Whitespace,
)

from sjdsl.editor.pygments_lexer import SjLexer
from sjdsl.library.games_folder import bundled, find_game

ROOT = Path(__file__).parents[2]


def coloured(text: str) -> list[tuple[object, str]]:
    """Returns the tokens without spaces, neighbours of one colour together."""
    found = groupby(SjLexer(ensurenl=False, stripnl=False).get_tokens(text), itemgetter(0))
    pieces = [(token, "".join(piece for _, piece in several)) for token, several in found]
    return [(token, piece) for token, piece in pieces if token is not Whitespace]


def test_each_part_of_a_line_has_its_colour() -> None:
    assert coloured('param regrow : probability = 0.05 # "slow"') == [
        (Keyword.Declaration, "param"),
        (Name.Class, "regrow"),
        (Punctuation, ":"),
        (Keyword.Type, "probability"),
        (Operator, "="),
        (Number, "0.05"),
        (Comment.Single, '# "slow"'),
    ]
    assert coloured('tree.fruit "a\\" b" x') == [
        (Name, "tree"),
        (Punctuation, "."),
        (Name.Attribute, "fruit"),
        (String.Double, '"a'),
        (String.Escape, '\\"'),
        (String.Double, ' b"'),
        (Name, "x"),
    ]
    assert coloured('"open\nwhen')[-1] == (Keyword, "when")


@pytest.mark.parametrize("name", bundled())
def test_bundled_games_are_coloured_without_a_gap(name: str) -> None:
    text = find_game(name).read_text("utf-8")
    pieces = list(SjLexer(ensurenl=False, stripnl=False).get_tokens(text))
    assert "".join(piece for _, piece in pieces) == text
    assert [piece for token, piece in pieces if token is Error] == []


def test_pygments_finds_it() -> None:
    points = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["entry-points"][
        "pygments.lexers"
    ]
    module, name = points["sj"].split(":")
    assert getattr(import_module(module), name) is SjLexer
    assert "sj" in SjLexer.aliases and "*.sj" in SjLexer.filenames
