"""Symbols, layout and colours of a text."""

from sjdsl.compiler.diagnostics.source import Source
from sjdsl.editor.colours import coloured
from sjdsl.format import format_source
from tests.editor.asked import ORCHARD, opened


def test_the_outline_has_what_is_declared_inside_what_declares_it() -> None:
    session, uri = opened()
    (game,) = session.symbols(uri)
    names = {symbol.name: [child.name for child in symbol.children or []] for symbol in game.children or []}
    assert game.name == "orchard"
    assert names["tree"] == ["fruit", "owner"]
    assert names["agents"] == ["turn_left", "turn_right", "forward", "stay", "share", "zap", "bag", "sore"]
    assert names["metrics"] == ["eaten", "hits", "given", "ripe_trees"]
    assert {"apple", "beam", "ready", "eat", "rich", "eater_first", "schedule", "map"} <= set(names)
    for symbol in game.children or []:
        inner, outer = symbol.selection_range, symbol.range
        assert (outer.start.line, outer.start.character) <= (inner.start.line, inner.start.character)
        assert (inner.end.line, inner.end.character) <= (outer.end.line, outer.end.character)


def test_layout_changes_only_lines_that_differ() -> None:
    session, uri = opened(ORCHARD.replace("  episode 20", "episode   20").replace("phase walk {", "phase walk{"))
    document = session.documents.get(uri)
    assert document is not None
    text, edits = document.text, session.formatting(uri)
    for edit in reversed(edits):
        start, end = document.lines.offset(edit.range.start), document.lines.offset(edit.range.end)
        text = text[:start] + edit.new_text + text[end:]
    assert text == format_source(Source("x.sj", ORCHARD))
    assert {edit.range.start.line for edit in edits} >= {5, 23}
    assert len(edits) < 8
    session.open(uri, text, 2)
    assert session.formatting(uri) == []
    session.open(uri, text + "}", 3)
    assert session.formatting(uri) == []


def test_words_are_coloured_by_what_they_mean() -> None:
    session, uri = opened()
    analysis = session.analyses.of(uri)
    assert analysis is not None
    found = {}
    for start, end, sort, modifiers in coloured(analysis, analysis.names):
        found.setdefault(ORCHARD[start:end], []).append((sort, modifiers))
    assert found["apple"][0] == ("parameter", ("declaration", "readonly"))
    assert found["apple"][1] == ("parameter", ("readonly",))
    assert found["eater"][0] == ("variable", ("declaration",))
    assert {sort for sort, _ in found["tree"]} == {"class"}
    assert {sort for sort, _ in found["fruit"]} == {"property"}
    assert {sort for sort, _ in found["ripe"]} == {"enumMember"}
    assert {sort for sort, _ in found["eat"]} == {"method"}
    assert found["each"][0] == ("keyword", ())
    assert found["probability"] == [("type", ("defaultLibrary",))]


def test_colours_are_counted_from_one_word_to_the_next() -> None:
    session, uri = opened('sj 1\ngame g "😀" {  episode 5 }')
    data = list(session.semantic_tokens(uri).data)
    steps = [tuple(data[i : i + 3]) for i in range(0, len(data), 5)]
    assert steps == [(0, 0, 2), (0, 3, 1), (1, 0, 4), (0, 5, 1), (0, 2, 4), (0, 8, 7), (0, 8, 1)]
