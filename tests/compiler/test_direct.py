"""Reading straight to the AST: the same trees as by way of the grammar's own tree, and nothing from a text with a mistake."""

from pathlib import Path
from random import Random
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lark import Token, Tree, UnexpectedToken

from sjdsl.compiler import ast
from sjdsl.compiler.diagnostics.diagnostic import CompileError, Diagnostic
from sjdsl.compiler.diagnostics.limits import (
    CHAINS,
    MAX_DIGITS,
    MAX_INTEGER,
    MAX_STATEMENTS,
    MAX_TREE,
    STATEMENTS,
)
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.compiler.syntax import rules
from sjdsl.compiler.syntax.direct import EVERY, read_directly
from sjdsl.compiler.syntax.parse import mistakes, parse, parser, tree_of
from sjdsl.compiler.syntax.rules import Part, unquote
from sjdsl.compiler.syntax.soft_words import SOFT
from sjdsl.compiler.syntax.tokens import scan
from tests.damage import edits
from tests.format.damage import damaged

FOLDER = Path(__file__).parents[2] / "games"
GAMES = [
    *edits.GAMES,
    "allelopathic_harvest",
    "meltingpot/chemistry",
    "meltingpot/predator_prey_open",
    "meltingpot/collaborative_cooking",
]
SMALL = [path.read_text("utf-8") for path in sorted((FOLDER.parent / "tests/cases").glob("*.sj"))]


def with_care(text: str) -> ast.File | None:
    """Returns the tree by way of Lark's own, None if there is a mistake."""
    source = Source("game.sj", text)
    found = scan(source, parser())
    if found.problems:
        return None
    try:
        tree = tree_of(found.tokens)[1]
    except UnexpectedToken:
        return None
    fits = (
        depth(tree) <= MAX_TREE
        and sum(node.data in STATEMENTS for node in tree.iter_subtrees()) <= MAX_STATEMENTS
    )
    return built(tree) if fits else None


def depth(tree: Tree[Token]) -> int:
    """Returns how deep a tree is; each operator of a chain counts, and `and` and `or` leave no token."""
    chained = sum(isinstance(child, Token) for child in tree.children) or len(tree.children) - 1
    below = max((depth(child) for child in tree.children if isinstance(child, Tree)), default=0)
    return below + (chained if tree.data in CHAINS else 1)


def built(tree: Tree[Token]) -> Any:
    items = [
        built(child) if isinstance(child, Tree) else leaf(child)
        for child in tree.children
        if child is not None
    ]
    if tree.data in {*rules.CLAUSES, "names"}:
        return Part(
            tree.data, tuple(items) if tree.data == "names" else items[0] if items else None
        )
    span = Span("game.sj", tree.meta.start_pos, tree.meta.end_pos, tree.meta.line, tree.meta.column)
    return rules.RULES[tree.data](span, *items)


def leaf(token: Token) -> ast.Name | ast.String | str:
    span = Span(
        "game.sj", token.start_pos or 0, token.end_pos or 0, token.line or 0, token.column or 0
    )
    if token.type == "STRING":
        return ast.String(span, unquote(token))
    return str(token) if token.type in rules.AS_WRITTEN else ast.Name(span, str(token))


def directly(text: str) -> ast.File | None:
    found = read_directly(Source("game.sj", text), parser())
    return found if isinstance(found, ast.File) else None


@pytest.mark.parametrize("name", GAMES)
def test_bundled_games_are_read_directly(name: str) -> None:
    text = (FOLDER / f"{name}.sj").read_text("utf-8")
    found = directly(text)
    assert found is not None
    assert found == with_care(text)


@settings(max_examples=12, deadline=None)
@given(damaged(SMALL))
def test_other_spaces_and_comments(text: str) -> None:
    found = directly(text)
    assert found is not None
    assert found == with_care(text)


@settings(max_examples=12, deadline=None)
@given(
    st.sampled_from(edits.GAMES),
    st.sampled_from([kind for kind in edits.KINDS if kind != "row"]),
    st.integers(0, 2**32),
)
def test_edited_words(game: str, kind: str, seed: int) -> None:
    """A text with a mistake is left to the careful reading; one that is still a game is read as that reads it."""
    edited = edits.edit(game, kind, Random(seed)).text
    assert directly(edited) == with_care(edited)


def game(inside: str) -> str:
    return f'sj 1\ngame small "Small" {{ {inside} }}'


@pytest.mark.parametrize(
    "mistake", ["set agent.bag += 1", "set any.at = (1 + 2 + 3 + 4 + 5 end", "} }"]
)
def test_mistakes_are_those_found_from_the_beginning(mistake: str) -> None:
    """The search for mistakes begins a little before the first, with a stack that the direct reading hands over."""
    for before in range(EVERY - 20, EVERY + 4):
        source = Source("game.sj", game(f"phase p {{ {'end ' * before} {mistake} }}"))
        so_far = read_directly(source, parser())
        assert not isinstance(so_far, ast.File | Diagnostic) and so_far is not None
        assert mistakes(source, None, so_far) == mistakes(source, None, None)


@pytest.mark.parametrize("word", sorted(kind.lower() for kind in SOFT))
def test_soft_words_as_names(word: str) -> None:
    text = game(
        f"size {word} : cells = 3 in 1 .. 4 phase p {{ each agent as a {{ when {word} > 1 {{ set a.{word} = {word} }} }} }}"
    )
    found = directly(text)
    assert found is not None
    assert found == with_care(text)


@pytest.mark.parametrize(
    "inside",
    [
        f"size a : cells = {MAX_INTEGER}",
        f"size a : cells = {MAX_INTEGER + 1}",
        f"size a : cells = {'0' * 20}1",
        f"param a : fraction = 0.{'1' * MAX_DIGITS}",
        *(f"define d(x) = {'(' * n}x{')' * n}" for n in (10, 60, 61, 62, 63, 64, 65)),
        *(f"define d(x) = {' + '.join(['x'] * n)}" for n in (2, 150, 157, 158, 159, 160, 170)),
        *(f"define d(x) = {' and '.join(['x'] * n)}" for n in (2, 155, 156, 157, 158, 159, 160)),
        *(f"define d(x) = {'-' * n}x" for n in (1, 30, 63, 64)),
        "phase p { " + "end\n" * (MAX_STATEMENTS - 1) + "}",
        "phase p { " + "end\n" * MAX_STATEMENTS + "}",
        'cite "\\"# no remark \\\\" # a remark',
        'cite "no end',
        "size a : cells = 3 §",
        "size a : cells = 1 // 2",
        "size Big = 3",
        "",
    ],
)
def test_near_the_limits(inside: str) -> None:
    """What is read directly is what the careful reading gives, which refuses what is beyond a limit, and says why."""
    found = directly(game(inside))
    assert found == with_care(game(inside))
    if found is None:
        with pytest.raises(CompileError):
            parse(Source("game.sj", game(inside)))


@pytest.mark.parametrize(
    "text",
    [
        game("size a : cells = 3\x07"),
        game("# \u200b"),
        "sj 9\n" + game("")[5:],
        "game small {}",
        "",
        "# nothing",
    ],
)
def test_what_is_wrong_with_characters_and_versions_is_still_said(text: str) -> None:
    with pytest.raises(CompileError):
        parse(Source("game.sj", text))


def test_positions_count_lines_as_editors_do() -> None:
    text = 'sj 1\r\n\r\n# remark\r\ngame small "S" {\r\n\tsize a : cells = (1 +\r\n 2) * 3 }'
    found = directly(text)
    assert found is not None
    assert found == with_care(text)
    size = found.game.sections[0]
    assert isinstance(size, ast.Constant)
    assert (size.span.line, size.span.column, text[size.span.start : size.span.end]) == (
        5,
        2,
        "size a : cells = (1 +\r\n 2) * 3",
    )
