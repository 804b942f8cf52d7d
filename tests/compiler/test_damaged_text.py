"""Texts with one token left out, doubled or swapped, and texts cut short: refused near the damage, in one message."""

from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path

import pytest
from lark import Token

from sjdsl.compiler.syntax.parse import parser
from tests.compiler.test_parse import problems

GAMES = sorted((Path(__file__).parents[2] / "games").glob("*.sj"))
COINS = next(path for path in GAMES if path.stem == "coins").read_text("utf-8")


def mutants(
    tokens: list[Token], change: Callable[[str, Token, Token], str]
) -> Iterator[tuple[Token, str]]:
    for token, following in pairwise(tokens):
        yield token, change(COINS, token, following)


def without(text: str, token: Token, _: Token) -> str:
    return f"{text[: token.start_pos]} {text[token.end_pos :]}"


def twice(text: str, token: Token, _: Token) -> str:
    return f"{text[: token.end_pos]} {token} {text[token.end_pos :]}"


def swapped(text: str, token: Token, following: Token) -> str:
    between = text[token.end_pos : following.start_pos]
    return f"{text[: token.start_pos]} {following}{between}{token} {text[following.end_pos :]}"


@pytest.mark.thorough
@pytest.mark.parametrize(
    "change",
    [without, *(pytest.param(change, marks=pytest.mark.slow) for change in (twice, swapped))],
)
def test_mutants_of_coins_are_refused_in_place(change: Callable[[str, Token, Token], str]) -> None:
    """One change, one message, within a line; braces may be missed further away."""
    tokens = list(parser().lex(COINS))
    counts, near = [], 0
    for token, text in mutants(tokens, change):
        found = problems(text)
        counts.append(len(found))
        lines = [d.span.line for d in found] + [
            label.span.line for d in found for label in d.labels
        ]
        near += any(abs(line - (token.line or 0)) <= 1 for line in lines)
    refused = sum(count > 0 for count in counts)
    assert refused >= 0.95 * len(
        counts
    )  # a text, a word of a list or a slot less is another game, not a mistake
    assert near >= 0.97 * refused
    assert sum(count == 1 for count in counts) >= 0.93 * refused
    assert max(counts) <= 4


@pytest.mark.thorough
@pytest.mark.parametrize(
    "path",
    [p if n % 2 else pytest.param(p, marks=pytest.mark.slow) for n, p in enumerate(GAMES)],
    ids=lambda path: path.stem,
)
def test_truncated_games_give_one_message(path: Path) -> None:
    text = path.read_text("utf-8")
    for token in list(parser().lex(text))[::4]:
        assert len(problems(text[: token.end_pos])) <= 1
