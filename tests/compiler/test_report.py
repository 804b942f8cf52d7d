"""What diagnostics look like: as text, and as data."""

import json
import pickle

import pytest

from sjdsl.compiler.diagnostics.diagnostic import CompileError, Diagnostic, Fix, Label
from sjdsl.compiler.diagnostics.report import WIDTH, render, to_json
from sjdsl.compiler.diagnostics.source import Source, Span


class Wrong(Diagnostic, code="SJ999", title="Wrong"):
    says = "`{name}` is wrong"
    hints = ("write `{better}`",)
    name: str
    better: str = ""


class Odd(Diagnostic, code="SJ998", title="Odd", severity="warning"):
    says = "this is odd"


def shown(text: str, *diagnostics: Diagnostic, colour: bool = False) -> str:
    return render(diagnostics, {"game.sj": Source("game.sj", text)}, colour)


def wrong(text: str, part: str, *labels: tuple[str, str], better: str = "") -> Diagnostic:
    """A diagnostic about `part` of a text, with labels for other parts."""
    source = Source("game.sj", text)

    def span(of: str) -> Span:
        return source.span(text.index(of), text.index(of) + len(of))

    told = tuple(Label(span(of), says) for of, says in labels)
    return Wrong(span(part), name=part.split("\n")[0].strip(), better=better, labels=told)


def test_one_line_with_help() -> None:
    text = "sj 1\ngame pond { fish }\n"
    assert shown(text, wrong(text, "fish", better="dish")) == (
        "error[SJ999] game.sj:2:13\n"
        "  `fish` is wrong\n"
        "    |\n"
        "  2 | game pond { fish }\n"
        "    |             ^^^^\n"
        "  help: write `dish`\n"
        "\n"
        "1 error"
    )


def test_an_exception_says_where_what_and_what_to_write_instead() -> None:
    text = "sj 1\ngame pond { fish }\n"
    odd = Odd(Source("game.sj", text).span(0, 2))
    error = CompileError([wrong(text, "fish", better="dish"), odd])
    said = "game.sj:1:1: warning[SJ998]: this is odd\ngame.sj:2:13: error[SJ999]: `fish` is wrong\n  help: write `dish`"
    assert str(error) == said
    assert str(pickle.loads(pickle.dumps(error))) == said, "as it comes from another process"


def test_labels_stand_in_the_order_of_the_file() -> None:
    lines = [f"line {n}" for n in range(1, 13)]
    text = "\n".join(lines)
    out = shown(text, wrong(text, "line 10", ("line 9", "near"), ("line 2", "far")))
    assert out.split("\n")[2:-2] == [
        "     |",
        "   2 | line 2",
        "     | ------ far",
        "  ...",
        "   9 | line 9",
        "     | ------ near",
        "  10 | line 10",
        "     | ^^^^^^^",
    ]


def test_a_label_in_the_same_line() -> None:
    text = "give (1 + 2 to agent"
    out = shown(text, wrong(text, "to", ("(", "opened here")))
    assert out.split("\n")[3:6] == [
        "  1 | give (1 + 2 to agent",
        "    |      - opened here",
        "    |             ^^",
    ]


def test_a_span_of_some_lines_and_of_many() -> None:
    text = 'map { "..."\n\n      "..." }\n'
    out = shown(text, wrong(text, text[:-1]))
    assert out.split("\n")[3:8] == [
        '  1 | map { "..."',
        "    | ^^^^^^^^^^^",
        "  ...",
        '  3 |       "..." }',
        "    |       ^^^^^^^",
    ]
    many = "\n".join(f"  row {n}" for n in range(9))
    out = shown(many, wrong(many, many[2:]))
    assert out.split("\n")[3:8] == [
        "  1 |   row 0",
        "    |   ^^^^^",
        "  ...",
        "  9 |   row 8",
        "    |   ^^^^^",
    ]


def test_the_end_of_the_file_has_a_caret() -> None:
    text = "game pond {\n"
    end = Source("game.sj", text).span(len(text), len(text))
    assert shown(text, Odd(end)).split("\n")[2:5] == ["    |", "  2 |", "    | ^"]


@pytest.mark.parametrize(
    ("line", "part", "excerpt", "carets"),
    [
        ("\tset x", "x", "    set x", "        ^"),
        ("a\tset x", "x", "a   set x", "        ^"),
        ("a \x1b[31m x", "x", "a \\x1b[31m x", "           ^"),
        ("a \u202e x", "x", "a \\u202e x", "         ^"),
    ],
)
def test_carets_stand_under_what_is_meant(line: str, part: str, excerpt: str, carets: str) -> None:
    lines = shown(line, wrong(line, part)).split("\n")
    assert lines[3] == f"  1 | {excerpt}"
    assert lines[4] == f"    | {carets}"


@pytest.mark.parametrize("place", [0, 40, 150, 1000, 4990, 5000 - 6])
def test_long_lines_are_cut_around_the_mark(place: int) -> None:
    line = "." * place + "target" + "." * (5000 - place - 6)
    excerpt, carets = (text[6:] for text in shown(line, wrong(line, "target")).split("\n")[3:5])
    assert len(excerpt) <= WIDTH
    at = carets.index("^")
    assert excerpt[at : at + len(carets.strip())] == "target"
    assert excerpt.startswith("…") == (place > WIDTH)
    assert excerpt.endswith("…") == (place < 4900)


def test_marks_wider_than_the_excerpt_end_with_it() -> None:
    line = "x" * 5000
    lines = shown(line, wrong(line, line)).split("\n")
    assert all(len(text) <= WIDTH + 6 for text in lines[3:5])


def test_windows_line_ends_do_not_show() -> None:
    text = "sj 1\r\ngame pond\r\n"
    assert shown(text, wrong(text, "pond")).split("\n")[3] == "  2 | game pond"


def test_other_files_and_files_without_text() -> None:
    own, base = Source("game.sj", "abc"), Source("base.sj", "first\nsecond\n")
    labels = (
        Label(base.span(6, 12), "declared here"),
        Label(Span("gone.sj", 0, 1, 7, 1), "and here"),
    )
    out = render([Odd(own.span(0, 3), labels=labels)], {"game.sj": own, "base.sj": base}, False)
    assert out.split("\n")[2:] == [
        "    |",
        "  1 | abc",
        "    | ^^^",
        "   --> base.sj:2:1",
        "    |",
        "  2 | second",
        "    | ------ declared here",
        "  gone.sj:7: and here",
        "",
        "1 warning",
    ]
    assert (
        render([Odd(own.span(0, 3))], {}, False)
        == "warning[SJ998] game.sj:1:1\n  this is odd\n\n1 warning"
    )


def test_the_last_line_counts() -> None:
    text = "a b"
    out = shown(text, wrong(text, "a"), wrong(text, "b"), Odd(Source("game.sj", text).span(0, 1)))
    assert out.endswith("\n2 errors, 1 warning")
    assert shown(text) == ""


def test_colours_only_add_to_the_text() -> None:
    text = "sj 1\ngame pond { fish }\n"
    problem = wrong(text, "fish", ("pond", "of this"), better="dish")
    plain, coloured = shown(text, problem), shown(text, problem, colour=True)
    assert "\x1b[" in coloured
    assert "\x1b" not in plain
    for code in ("31", "34", "1", "0"):
        coloured = coloured.replace(f"\x1b[{code}m", "")
    assert coloured == plain


def test_messages_cannot_carry_terminal_codes() -> None:
    source = Source("game\x1b.sj", "abc")
    out = render(
        [Wrong(source.span(0, 1), name="\x1b[2J", better="\x07")], {source.name: source}, False
    )
    assert "\x1b" not in out
    assert "\x07" not in out


def test_as_data() -> None:
    source = Source("game.sj", "one\ntwo three\nfour\n")
    fix = Fix(source.span(8, 13), "3")
    problem = Wrong(
        source.span(4, 18),
        name="two",
        better="2",
        labels=(Label(source.span(0, 3), "first"),),
        fix=fix,
    )
    (data,) = to_json([problem], {"game.sj": source})
    assert data == {
        "code": "SJ999",
        "severity": "error",
        "message": "`two` is wrong",
        "hint": "write `2`",
        "file": "game.sj",
        "line": 2,
        "column": 1,
        "end_line": 3,
        "end_column": 5,
        "labels": [
            {
                "text": "first",
                "file": "game.sj",
                "line": 1,
                "column": 1,
                "end_line": 1,
                "end_column": 4,
            }
        ],
        "fix": {
            "text": "3",
            "file": "game.sj",
            "line": 2,
            "column": 5,
            "end_line": 2,
            "end_column": 10,
        },
    }
    json.dumps(data)


def test_as_data_without_the_text() -> None:
    (data,) = to_json([Odd(Span("game.sj", 4, 7, 2, 1))])
    assert (data["end_line"], data["end_column"], data["fix"], data["labels"]) == (2, 4, None, [])
