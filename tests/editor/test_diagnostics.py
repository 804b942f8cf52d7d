"""Messages: of all variants, with codes, links, further places, and tags for what has no effect."""

from pathlib import Path
from urllib.parse import urlsplit

from lsprotocol import types

from sjdsl.compiler import check_variants
from sjdsl.compiler.diagnostics.source import Source
from tests.editor.asked import ORCHARD, opened

LEVELS = {"error": types.DiagnosticSeverity.Error, "warning": types.DiagnosticSeverity.Warning}


def told(text: str, folder: Path | None = None) -> list[types.Diagnostic]:
    session, uri = opened(text, folder)
    return session.diagnostics(uri)


def test_a_game_without_mistakes_has_no_messages() -> None:
    assert told(ORCHARD) == []


def test_a_message_has_a_place_a_code_and_a_link_to_its_explanation() -> None:
    (found,) = told("# é😀\n" + ORCHARD.replace("give apple", "give appel"))
    assert found.range == types.Range(types.Position(27, 78), types.Position(27, 83))
    assert (found.code, found.severity, found.source) == (
        "SJ101",
        types.DiagnosticSeverity.Error,
        "sjdsl",
    )
    assert found.message == "`appel` is not known here\nhelp: did you mean `apple`?"
    assert found.code_description is not None
    assert Path(urlsplit(found.code_description.href).path).read_text("utf-8").startswith("# SJ101")


def test_characters_before_a_place_count_as_code_units() -> None:
    (found,) = told(ORCHARD.replace('"An orchard" {', '"😀" {  episodes'))
    line = 'game orchard "😀" {  episodes'
    assert found.range.start == types.Position(
        1, len(line.encode("utf-16-le")) // 2 - len("episodes")
    )


def test_a_mistake_of_some_variants_names_them() -> None:
    text = ORCHARD.replace(
        "variant rich",
        'variant poor "less" { set appel = 1 }\n  variant poorer "less" { drop walk  set appel = 1 }\n  variant rich',
    )
    found = {d.message.partition("\n")[0]: d.range.start.line for d in told(text)}
    assert "in variant `poor`: this changes `appel`, which the game does not have" in found
    assert not [message for message in found if "rich" in message]


def test_messages_are_those_of_check_in_all_variants() -> None:
    text = ORCHARD.replace("set apple = 2", "set apple = 2  schedule tick -> walk").replace(
        "field bag", "field idle : 0 .. 3 = 0  field bag"
    )
    session, uri = opened(text)
    wanted = {
        (d.code, d.span.line, d.severity)
        for _, found in check_variants(Source(uri, text))
        for d in found
    }
    assert {
        (d.code, d.range.start.line + 1, s)
        for d in session.diagnostics(uri)
        for s in LEVELS
        if LEVELS[s] == d.severity
    } == wanted
    assert len(wanted) > 2


def test_what_is_never_used_is_shown_as_such() -> None:
    (found,) = told(ORCHARD.replace("  episode 20", "  param pear : reward = 1\n  episode 20"))
    assert (found.code, found.severity, found.tags) == (
        "SJ505",
        types.DiagnosticSeverity.Warning,
        [types.DiagnosticTag.Unnecessary],
    )


def test_other_places_come_along() -> None:
    (found,) = told(ORCHARD.replace("chose share", "chose shaer"))
    assert [(r.message, r.location.range.start.line) for r in found.related_information or []] == [
        ("`share` is declared here", 13)
    ]


def test_a_mistake_in_another_file_stands_where_that_is_named(tmp_path: Path) -> None:
    (tmp_path / "orchard.sj").write_text(ORCHARD.replace("give apple", "give appel"))
    (tmp_path / "map.txt").write_text("G..G\n.TB?\n")
    small = 'sj 1\ngame small "S" extends "orchard.sj" { map "map.txt" }\n'
    session, uri = opened(small, tmp_path, "small.sj")
    by_start = {d.range.start.character: d for d in session.diagnostics(uri)}
    base, map_ = (
        by_start[small.splitlines()[1].index('"orchard.sj"')],
        by_start[small.splitlines()[1].index('"map.txt"')],
    )
    assert base.message.startswith("orchard.sj:27: `appel` is not known here")
    assert map_.message.startswith("map.txt:2: glyph `?`")
    assert map_.related_information is not None
    assert map_.related_information[0].location.uri == (tmp_path / "map.txt").as_uri()
    assert map_.related_information[0].location.range.start.line == 1


def test_open_texts_stand_in_place_of_files(tmp_path: Path) -> None:
    (tmp_path / "orchard.sj").write_text("not a game")
    (tmp_path / "map.txt").write_text("")
    small = 'sj 1\ngame small "S" extends "orchard.sj" { map "map.txt" }\n'
    session, uri = opened(small, tmp_path, "small.sj")
    assert session.diagnostics(uri) != []
    base, map_ = ((tmp_path / name).as_uri() for name in ("orchard.sj", "map.txt"))
    session.open(base, ORCHARD, 1)
    session.open(map_, "G..G\n.TB.\n", 1)
    assert session.affected_by(base) == [uri, base]
    assert session.diagnostics(uri) == []
    assert session.affected_by(map_) == [uri]
    session.open(base, ORCHARD.replace("episode 20", ""), 2)
    assert [d.code for d in session.diagnostics(uri)] == ["SJ114"]
    session.close(base)
    assert "SJ012" in [d.code for d in session.diagnostics(uri)]
    (tmp_path / "orchard.sj").write_text(ORCHARD)
    assert session.diagnostics(uri) == []
