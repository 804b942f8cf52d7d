"""Building the AST from the grammar's tree: positions, soft words, and limits."""

import pytest

from sjdsl.compiler import ast
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.limits import MAX_STATEMENTS, MAX_TREE
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.parse import parse
from sjdsl.compiler.syntax.soft_words import SOFT


def game(inside: str) -> str:
    return f'sj 1\ngame small "Small" {{ {inside} }}'


def sections(inside: str) -> tuple[ast.Node, ...]:
    return parse(Source("game.sj", game(inside))).game.sections


def test_positions_count_lines_as_editors_do() -> None:
    text = 'sj 1\r\n\r\n# remark\r\ngame small "S" {\r\n\tsize a : cells = (1 +\r\n 2) * 3 }'
    (size,) = parse(Source("game.sj", text)).game.sections
    assert (size.span.line, size.span.column) == (5, 2)
    assert text[size.span.start : size.span.end] == "size a : cells = (1 +\r\n 2) * 3"


@pytest.mark.parametrize("word", sorted(kind.lower() for kind in SOFT))
def test_soft_words_as_names(word: str) -> None:
    used = f"when {word} > 1 {{ set a.{word} = {word} }}"
    size, _ = sections(
        f"size {word} : cells = 3 in 1 .. 4 phase p {{ each agent as a {{ {used} }} }}"
    )
    assert isinstance(size, ast.Constant)
    assert size.name.text == word


CHAIN = MAX_TREE - 3  # operands of one expression in a define


@pytest.mark.parametrize(
    ("fits", "beyond"),
    [
        (" + ".join(["x"] * CHAIN), " + ".join(["x"] * (CHAIN + 1))),
        (" and ".join(["x"] * CHAIN), " and ".join(["x"] * (CHAIN + 1))),
    ],
)
def test_chains_of_operators_are_deep(fits: str, beyond: str) -> None:
    sections(f"define d(x) = {fits}")
    with pytest.raises(CompileError) as error:
        sections(f"define d(x) = {beyond}")
    assert [each.code for each in error.value.diagnostics] == ["SJ006"]


def test_statements_are_counted() -> None:
    sections("phase p { " + "end\n" * (MAX_STATEMENTS - 1) + "}")
    with pytest.raises(CompileError, match="the file has more statements"):
        sections("phase p { " + "end\n" * MAX_STATEMENTS + "}")
