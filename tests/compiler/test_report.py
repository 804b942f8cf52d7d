"""What diagnostics look like: as text, and as data."""

import json

import pytest

from sjdsl.compiler.diagnostics.diagnostic import Diagnostic, Fix, Label
from sjdsl.compiler.diagnostics.report import TAB, WIDTH, render, to_json
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
        ("鱼塘 x", "x", "鱼塘 x", "     ^"),  # each is two columns wide
        ("a 鱼塘 x", "鱼塘", "a 鱼塘 x", "  ^^^^"),
        ("鱼\tx", "x", "鱼  x", "    ^"),
        ("🐟 x", "x", "🐟 x", "   ^"),
        ("e\u0301 x", "x", "e\u0301 x", "  ^"),  # an accent on the letter before it
        ("ｆ x", "x", "ｆ x", "   ^"),  # a full-width letter
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


def columns_of(text: str) -> int:
    """Returns how many columns a terminal needs for a text of `.`, `…`, `鱼` and letters."""
    return len(text) + text.count("鱼")


@pytest.mark.parametrize("width", [50, 61, 80, 133])
@pytest.mark.parametrize("filler", [".", "鱼", ".鱼", "\t"])
@pytest.mark.parametrize("before", [0, 10, 31, 60, 200])
def test_lines_are_cut_at_the_width_of_a_terminal(width: int, filler: str, before: int) -> None:
    line = filler * before + "target" + filler * 200
    source = Source("game.sj", line)
    shown_lines = render([wrong(line, "target")], {"game.sj": source}, False, width).split("\n")
    excerpt, carets = shown_lines[3:5]
    assert columns_of(excerpt) <= width
    assert columns_of(excerpt) > width - TAB, "no more is cut than a character"
    assert columns_of(excerpt[: excerpt.index("target")]) == carets.index("^")
    assert carets.strip(" |") == "^" * 6
    assert columns_of(carets) <= width


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
