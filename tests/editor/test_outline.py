"""Symbols and layout of a text."""

from sjdsl.compiler.diagnostics.source import Source
from sjdsl.format import format_source
from tests.editor.asked import ORCHARD, edited, opened


def test_the_outline_has_what_is_declared_inside_what_declares_it() -> None:
    session, uri = opened()
    (game,) = session.symbols(uri)
    names = {
        symbol.name: [child.name for child in symbol.children or []]
        for symbol in game.children or []
    }
    assert game.name == "orchard"
    assert names["tree"] == ["fruit", "owner"]
    assert names["agents"] == [
        "turn_left",
        "turn_right",
        "forward",
        "stay",
        "share",
        "zap",
        "bag",
        "sore",
    ]
    assert names["metrics"] == ["eaten", "hits", "given", "ripe_trees"]
    assert {"apple", "beam", "ready", "eat", "rich", "eater_first", "schedule", "map"} <= set(names)
    for symbol in game.children or []:
        inner, outer = symbol.selection_range, symbol.range
        assert (outer.start.line, outer.start.character) <= (
            inner.start.line,
            inner.start.character,
        )
        assert (inner.end.line, inner.end.character) <= (outer.end.line, outer.end.character)


def test_layout_changes_only_lines_that_differ() -> None:
    session, uri = opened(
        ORCHARD.replace("  episode 20", "episode   20").replace("phase walk {", "phase walk{")
    )
    edits = session.formatting(uri)
    text = edited(session, uri, edits)
    assert text == format_source(Source("x.sj", ORCHARD))
    assert {edit.range.start.line for edit in edits} >= {5, 23}
    assert len(edits) < 8
    session.open(uri, text, 2)
    assert session.formatting(uri) == []
    session.open(uri, text + "}", 3)
    assert session.formatting(uri) == []


def test_formatting_keeps_the_line_ends_of_windows() -> None:
    laid_out = format_source(Source("", ORCHARD)).replace("\n", "\r\n")
    ugly = laid_out.replace("  episode 20", "  episode   20")
    session, uri = opened(ugly)
    (edit,) = session.formatting(uri)
    assert edit.range.start.line + 1 == edit.range.end.line
    assert edited(session, uri, [edit]) == laid_out
