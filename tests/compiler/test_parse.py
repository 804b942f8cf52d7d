"""Parsing: the tree of right texts, and every mistake of wrong ones at once."""

from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from pathlib import Path

import pytest

from sjdsl.compiler import ast
from sjdsl.compiler.diagnostics.diagnostic import CompileError, Diagnostic
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.compiler.syntax import rules
from sjdsl.compiler.syntax.parse import parse, parser
from sjdsl.compiler.syntax.read import read_source
from sjdsl.compiler.syntax.recovery.repair import ENTRIES, SECTIONS, STATEMENTS

GAMES = sorted((Path(__file__).parents[2] / "games").glob("*.sj"))
COINS = next(path for path in GAMES if path.stem == "coins").read_text("utf-8")


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


def test_spans_of_chains_and_brackets() -> None:
    text = in_phase("let a = (a + b) * c - 1")
    (let,) = statements("let a = (a + b) * c - 1")
    assert isinstance(let, ast.Let)
    assert isinstance(let.value, ast.Binary)
    whole, left = let.value.span, let.value.left.span
    assert text[whole.start : whole.end] == "(a + b) * c - 1"
    assert text[left.start : left.end] == "(a + b) * c"


@pytest.mark.parametrize(
    ("text", "tree"),
    [
        (
            "each agent as a on soil as s in beam of z where b { }",
            "Each(Domain(agent, a, On(soil, s), Near(ShapeRef(beam, -), z), b), Block([]))",
        ),
        (
            "each agent in disc(2, centre) of z { }",
            "Each(Domain(agent, -, -, Near(ShapeRef(disc, [2, centre]), z), -), Block([]))",
        ),
        ("each agent in { a, b } { }", "Each(Domain(agent, -, -, Members([a, b]), -), Block([]))"),
        (
            "each agent in rock.miners { }",
            "Each(Domain(agent, -, -, Path(rock, [Member(miners)]), -), Block([]))",
        ),
        (
            "pick 2 a { } otherwise { end }",
            "Pick(2, Domain(a, -, -, -, -), Block([]), Block([End()]))",
        ),
        ("first a in s of b { }", "First(Domain(a, -, -, Near(ShapeRef(s, -), b), -), Block([]))"),
        (
            "match a with first b { }",
            "Match(Domain(a, -, -, -, -), True, Domain(b, -, -, -, -), Block([]))",
        ),
        (
            "when a { } otherwise when b { } otherwise chance 0.5 { } otherwise { end }",
            "When(a, Block([]), When(b, Block([]), Chance(0.5, Block([]), Block([End()]))))",
        ),
        ("draw a from 1 .. 3", "Draw(a, 1, 3)"),
        ("draw a from { b, c }", "Draw(a, Words([b, c]), -)"),
        ("draw a from { b: 0.5, c: 0.5 }", "Draw(a, Table([Entry(b, 0.5), Entry(c, 0.5)]), -)"),
        ("set a.b = c", "Set(Path(a, [Member(b)]), c, -)"),
        ("add -1 to a", "Add((- 1), a)"),
        ("give 1 to a", "Give(1, a)"),
        ("give 1 to all", "Give(1, All(-))"),
        ("give 1 to all but a", "Give(1, All(a))"),
        ("tally e", "Tally(e, -, -)"),
        ("tally e for a", "Tally(e, -, a)"),
        ("tally e[w] by n for a", "Tally(Path(e, [Index(w)]), n, a)"),
        ("send a to b", "Send(a, Domain(b, -, -, -, -), -, -, -)"),
        (
            "send a to b after c facing north otherwise stay",
            "Send(a, Domain(b, -, -, -, -), c, north, stay)",
        ),
        ("remove a", "Remove(a)"),
        ("move each a", "Move(Domain(a, -, -, -, -), -)"),
        ("move each a ahead", "Move(Domain(a, -, -, -, -), Ahead())"),
        (
            "move each a where b along c.d",
            "Move(Domain(a, -, -, -, b), Along(Path(c, [Member(d)])))",
        ),
        (
            "move each a at random avoiding b",
            "Move(Domain(a, -, -, -, -), AtRandom(Domain(b, -, -, -, -)))",
        ),
        ("move each a toward b", "Move(Domain(a, -, -, -, -), Toward(Domain(b, -, -, -, -), -))"),
        (
            "move each a away from b",
            "Move(Domain(a, -, -, -, -), AwayFrom(Domain(b, -, -, -, -), -))",
        ),
        ("mark disc(2) of a", "Mark(ShapeRef(disc, [2]), a)"),
    ],
)
def test_statements(text: str, tree: str) -> None:
    (statement,) = statements(text)
    assert plain(statement) == tree


@pytest.mark.parametrize(
    ("text", "tree"),
    [
        ("size n : count = 2 in 1 .. 3", "Constant(True, n, -, count, 2, 1, 3)"),
        (
            "param p : reward = { a: { b: 1 }, c: -2 }",
            "Constant(False, p, -, reward, Table([Entry(a, Table([Entry(b, 1)])), Entry(c, (- 2))]), -, -)",
        ),
        (
            "param p by agent : reward = { 0: 1, 1 .. 3: 2, 4 ..: 0, otherwise: 5 }",
            "Constant(False, p, agent, reward, Table([Entry(0, 1), Entry(1 .. 3, 2), Entry(4 .., 0), Entry(otherwise, 5)]), -, -)",
        ),
        ("field f by { a, b } : { c, d } = c", "Field(f, Words([a, b]), Words([c, d]), c)"),
        ("field f by agent : agent", "Field(f, agent, NamedType(False, agent), -)"),
        ("field f by 0 .. n - 1 : { c, d } = c", "Field(f, Numbers(0, (n - 1)), Words([c, d]), c)"),
        ("field f : set of agent", "Field(f, -, NamedType(True, agent), -)"),
        ("field f : agent = nobody", "Field(f, -, NamedType(False, agent), Nobody())"),
        ("field f : 0 .. 3 capped = 1", "Field(f, -, Range(0, 3, True), 1)"),
        ("timer t", "Timer(t)"),
        ('kind a "A"', 'Kind(a, "A", [])'),
        (
            'kind a "A" { blocks agents, beam when b  glyph "B" with c = d with e = 1 }',
            'Kind(a, "A", [Blocks([agents, beam], b), Glyph("B", [[c, d], [e, 1]])])',
        ),
        ("group g = a, b", "Group(g, [a, b])"),
        ('map "a.txt"', 'Map("a.txt", [], -)'),
        ('map { "a" }', 'Map(-, ["a"], -)'),
        ('map wraps { "a" }', 'Map(-, ["a"], joined)'),
        ('shape s { "x" "^" }', 'Shape(s, ["x", "^"], -)'),
        ("shape s = line(2)", "Shape(s, [], Call(line, [2]))"),
        ("define f = a", "Define(f, [], a)"),
        ("define f(a, b) = a", "Define(f, [a, b], a)"),
        (
            "agents 3 { acts stay, zap  moves relative  forbid all when a  forbid b, c when d }",
            "Agents(3, [Acts([Action(stay, []), Action(zap, [])]), Moves(relative), Forbid([], a), Forbid([Chosen(b, -), Chosen(c, -)], d)])",
        ),
        ("agents { moves compass }", "Agents(-, [Moves(compass)])"),
        ("schedule a -> b(red, 1)", "Schedule([Turn(a, []), Turn(b, [red, 1])])"),
        ("phase p(a) { }", "Phase(p, [a], Block([]))"),
        (
            "observe { window ahead 2, left 1  show a  show b as { c where d, e }  hide f when g  hide m on agents when h }",
            "Observe([Window([[ahead, 2], [left, 1]], -), Show(a, [], -), Show(b, [Relabel(c, d), Relabel(e, -)], -), Hide(f, -, g), Hide(m, agents, h)])",
        ),
        (
            "metrics { event a by { b }  mean c = 1  final d = 2 }",
            "Metrics([Event(a, Words([b])), Measure(True, c, 1), Measure(False, d, 2)])",
        ),
        (
            "checks { require a  always b  once c always d  conserved e  monotone f falling in g  symmetric agents }",
            "Checks(-, [Require(a), Always(b), Once(c, d), Conserved(e), Monotone(f, falling, g), Symmetric(agents)])",
        ),
        (
            "checks dear { expect a with random, never(b), seek c over 3 episodes }",
            "Checks(dear, [Expect(a, [Policy(random, [], -), Policy(never, [b], -), Policy(seek, [], Domain(c, -, -, -, -))], 3)])",
        ),
        (
            'variant v "V" { set a[b] = 1  drop c  episode 2 }',
            'Variant(v, "V", [Override(Path(a, [Index(b)]), 1), Drop(c), Episode(2)])',
        ),
        (r'cite "a \"b\" \\ c\n"', r'Cite("a "b" \ c\n")'),
    ],
)
def test_declarations(text: str, tree: str) -> None:
    (section,) = parse(Source("game.sj", f"sj 1 game x {{ {text} }}")).game.sections
    assert plain(section) == tree


@pytest.mark.parametrize(
    ("head", "tree"),
    [
        ("x", "Game(x, -, -, [])"),
        ('x "T"', 'Game(x, "T", -, [])'),
        ('x extends "b.sj"', 'Game(x, -, "b.sj", [])'),
        ('x "T" extends "b.sj"', 'Game(x, "T", "b.sj", [])'),
    ],
)
def test_heads(head: str, tree: str) -> None:
    assert plain(parse(Source("game.sj", f"sj 1 game {head} {{ }}"))) == f"File(1, {tree})"


def test_every_rule_has_a_builder() -> None:
    all_rules = {
        str(rule.alias or rule.origin.name)
        for rule in parser().rules
        if rule.alias or not rule.options.expand1
    }
    named = {name for name in all_rules if not name.startswith("_")}
    assert named <= {*rules.RULES, *rules.CLAUSES, "names"} | single_children()


def single_children() -> set[str]:
    """Rules that always stand for their only child (`?stmt: let | draw | ...`) leave no node."""
    rules = [rule for rule in parser().rules if not rule.alias]
    return {str(r.origin.name) for r in rules} - {
        str(r.origin.name) for r in rules if len(r.expansion) != 1
    }


def test_statement_keywords_of_the_repair_are_words_of_the_language() -> None:
    words = {terminal.name for terminal in parser().terminals}
    assert words >= STATEMENTS | SECTIONS | ENTRIES


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


def test_independent_mistakes_are_reported_together() -> None:
    wrong = (
        COINS.replace("chance 2", "chanse 2")
        .replace("schedule grow", "schedule -> grow")
        .replace("give harm to", "give harm")
    )
    wrong = wrong.replace("episode length", "episode").replace("hide agent", "hyde agent")
    found = problems(wrong)
    changed = [i for i, (a, b) in enumerate(zip(wrong.split("\n"), COINS.split("\n")), 1) if a != b]
    assert [d.span.line for d in found] == [
        changed[0] + 2,
        *changed[1:],
    ]  # the missing number shows at the next word


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


@pytest.mark.parametrize(
    ("statements", "help_"),
    [
        ("when a = b { }", "`==` compares numbers, and `is` compares words"),
        ('kind b "c"', "a declaration stands outside the phases"),
        ("wehn", "did you mean `when`?"),
    ],
)
def test_help(statements: str, help_: str) -> None:
    (found,) = problems(in_phase(statements))
    assert found.hint == help_


def test_fixes_repair() -> None:
    for wrong in ("give (1 + 2 to a", "eech a { }", "when a = b { }", "set A = b"):
        text = in_phase(wrong)
        while found := problems(text):
            assert found[0].fix is not None, (wrong, found)
            span = found[0].fix.span
            text = text[: span.start] + found[0].fix.text + text[span.end :]
