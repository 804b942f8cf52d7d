"""Parsing: the trees of games and expressions, and every mistake of wrong texts at once."""

from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from pathlib import Path

import pytest

from sjdsl.compiler import ast
from sjdsl.compiler.diagnostics.diagnostic import CompileError, Diagnostic
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.compiler.syntax.parse import parse
from sjdsl.compiler.syntax.read import read_source

GAMES = sorted((Path(__file__).parents[2] / "games").glob("*.sj"))


def problems(text: str) -> list[Diagnostic]:
    """Returns what is wrong with a text; parsing raises nothing but CompileError."""
    try:
        parse(Source("game.sj", text))
    except CompileError as error:
        return list(error.diagnostics)
    return []


def codes(text: str) -> list[str]:
    return [d.code for d in problems(text)]


def in_phase(statements: str) -> str:
    return f"sj 1\ngame x {{\n  phase p {{\n    {statements}\n  }}\n}}\n"


def statements(text: str) -> tuple[ast.Stmt, ...]:
    (phase,) = parse(Source("game.sj", in_phase(text))).game.sections
    assert isinstance(phase, ast.Phase)
    return phase.block.statements


def plain(node: object) -> str:
    """Returns a tree without its spans: `Class(field, ...)`, names as they are, lists in square brackets, `-` for nothing."""
    match node:
        case ast.Name():
            return node.text
        case ast.String():
            return f'"{node.text}"'
        case ast.Path(steps=()):
            return node.name.text
        case ast.Int() | ast.Decimal():
            return str(node.value)
        case ast.Binary():
            return f"({plain(node.left)} {node.op} {plain(node.right)})"
        case ast.Unary():
            return f"({node.op} {plain(node.operand)})"
        case tuple():
            return f"[{', '.join(map(plain, node))}]"
        case None:
            return "-"
    if not is_dataclass(node):
        return str(node)
    return f"{type(node).__name__}({', '.join(plain(getattr(node, field.name)) for field in fields(node)[1:])})"


def nodes(node: object) -> Iterator[object]:
    if is_dataclass(node) and not isinstance(node, Span):
        yield node
        for field in fields(node):
            yield from nodes(getattr(node, field.name))
    elif isinstance(node, tuple):
        for item in node:
            yield from nodes(item)


# ---- right texts


@pytest.mark.parametrize("path", GAMES, ids=lambda path: path.stem)
def test_games_parse_and_every_node_knows_its_text(path: Path) -> None:
    source = read_source(path)
    for node in nodes(parse(source)):
        span: Span = node.span  # type: ignore[attr-defined]
        assert source.span(span.start, span.end) == span
        text = source.text[span.start : span.end]
        assert text == text.strip() != ""
        if isinstance(node, ast.Name):
            assert text == node.text
        if isinstance(node, ast.String):
            assert text == f'"{node.text}"'


@pytest.mark.parametrize(
    ("text", "tree"),
    [
        ("a + b - c", "((a + b) - c)"),
        ("a - b * c / d", "(a - ((b * c) / d))"),
        ("-a * b", "((- a) * b)"),
        ("a - -b", "(a - (- b))"),
        ("- - a", "(- (- a))"),
        ("(a + b) * c", "((a + b) * c)"),
        ("a + 1 < 2 * b", "((a + 1) < (2 * b))"),
        ("not a and b or c", "(((not a) and b) or c)"),
        ("not not a is b", "(not (not (a is b)))"),
        ("a is not b and c in { x, y }", "((a is not b) and Within(c, Words([x, y]), -))"),
        ("a in 1 .. b + 1 or a in s", "(Within(a, 1, (b + 1)) or Within(a, s, -))"),
        (
            "a chose zap and nobody on soil",
            "(Chose(a, Chosen(zap, -)) and Standing(Nobody(), soil))",
        ),
        ("1.50 % 007", "(1.5 % 7)"),
        (
            "a.bag[b[raw]].team",
            "Path(a, [Member(bag), Index(Path(b, [Index(raw)])), Member(team)])",
        ),
        ("f() + g(a, 1)", "(Call(f, []) + Call(g, [a, 1]))"),
        ("sum(a) / count(b on c)", "(Total(a, -) / Count(Domain(b, -, On(c, -), -, -)))"),
        ("sum(a.x over b)", "Total(Path(a, [Member(x)]), Domain(b, -, -, -, -))"),
        (
            "case n { 0: 1, 1 .. 2: 3, 4..: 5, red: 6, otherwise: 7 }",
            "Case(n, [Arm(0, 0, False, -, 1), Arm(1, 2, False, -, 3), Arm(4, -, True, -, 5),"
            " Arm(-, -, False, red, 6), Arm(-, -, False, -, 7)])",
        ),
    ],
)
def test_expressions(text: str, tree: str) -> None:
    (let,) = statements(f"let a = {text}")
    assert plain(let) == f"Let(a, {tree})"


# ---- wrong texts


@pytest.mark.parametrize(
    ("wrong", "right"),
    [("eech", "each"), ("givee", "give"), ("tlly", "tally"), ("chanc", "chance"), ("if", "when")],
)
def test_a_misspelt_keyword_is_repaired_so_that_errors_inside_are_seen(
    wrong: str, right: str
) -> None:
    heads = {"each": "agent", "give": "1 to a", "tally": "e", "chance": "0.5", "when": "a"}
    body = "{ set x = }" if right in ("each", "chance", "when") else ""
    found = problems(in_phase(f"{wrong} {heads[right]} {body}\n end"))
    assert f"`{right}`" in found[0].hint
    assert found[0].fix is not None
    assert found[0].fix.text == right
    assert len(found) == (2 if body else 1)


def test_a_reserved_word_is_reported_once_and_read_as_a_name() -> None:
    found = problems(
        "sj 1 game x { param end : reward = 1  phase p { give end to a  give end to b  sett c = 1 } }"
    )
    assert [(d.code, getattr(d, "word", "")) for d in found] == [("SJ003", "end"), ("SJ002", "")]


@pytest.mark.parametrize(
    "word", ["window", "first", "event", "size", "mark", "count", "sum", "nobody"]
)
def test_reserved_words_as_names(word: str) -> None:
    assert codes(f"sj 1 game x {{ define {word} = 3 }}") == ["SJ003"]
    assert set(codes(in_phase(f"let {word} = 3  give 1 to a"))) == {"SJ003"}


@pytest.mark.parametrize(
    "text",
    [
        "sj 2\n$$$",
        "sj 2 game",
        "# c\n\n  sj  2.1",
        "sj 01 game x { }",
        "sj 1.0",
        "sj 1.1",
    ],
)
def test_another_version_is_all_that_is_said(text: str) -> None:
    assert codes(text) == ["SJ001"]


@pytest.mark.parametrize(
    "text", ["", "\n\n", "# only\n# comments", "{}", "import os", "1", "Sj 1", '"sj 1"']
)
def test_no_version_line(text: str) -> None:
    assert codes(text) == ["SJ012"]


@pytest.mark.parametrize("start", ["", "Sj 1\n", "sj1\n", "1\n"])
def test_behind_a_missing_version_the_game_is_read(start: str) -> None:
    assert codes(f"{start}game x {{ phase p {{ sett a = 1 }} }}") == ["SJ012", "SJ002"]


def test_an_unclosed_block_is_found_by_its_indentation() -> None:
    text = (
        "sj 1\ngame x {\n  phase p {\n    each a {\n      end\n  }\n  phase q {\n    end\n  }\n}\n"
    )
    (found,) = problems(text)
    assert (found.code, found.span.line, found.labels[0].span.line) == ("SJ011", 4, 6)


def test_a_brace_too_many_is_pointed_at() -> None:
    (found,) = problems("sj 1\ngame x {\n  phase p { end } }\n  phase q { end }\n}\n")
    assert found.labels[0].span.line == 3


def test_fixes_repair() -> None:
    for wrong in ("give (1 + 2 to a", "eech a { }", "when a = b { }", "set A = b"):
        text = in_phase(wrong)
        while found := problems(text):
            assert found[0].fix is not None, (wrong, found)
            span = found[0].fix.span
            text = text[: span.start] + found[0].fix.text + text[span.end :]
