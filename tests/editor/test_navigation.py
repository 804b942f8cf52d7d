"""Definitions, references and new names, through the games that one extends."""

from pathlib import Path

import pytest
from lsprotocol import types

from sjdsl.editor.navigation import Refused
from tests.editor.asked import ORCHARD, edited, opened, place, texts

SMALL = """sj 1
game small "A smaller one" extends "orchard.sj" {
  set apple = 3
  map { "GTG" }
  phase eat { each agent as eater on tree where tree.fruit is ripe { give apple to eater  set tree.fruit = none } }
}
"""


@pytest.mark.parametrize(
    ("before", "line", "name"),
    [
        ("give app", 4, "apple"),
        ("chance regr", 5, "regrow"),
        ("beam of zap", 31, "zapper"),
        ("in be", 19, "beam"),
        ("chose za", 14, "zap"),
        ("ready(za", 31, "zapper"),
        ("and read", 20, "ready"),
        ("who.b", 16, "bag"),
        ("-> wal", 24, "walk"),
        ("tally hi", 37, "hits"),
        ("tree.own", 8, "owner"),
    ],
)
def test_a_name_leads_to_its_declaration(before: str, line: int, name: str) -> None:
    session, uri = opened()
    assert [
        (at, text)
        for _, at, text in texts(session, session.definition(uri, place(session, uri, before)))
    ] == [(line, name)]


def test_a_field_of_a_group_is_declared_by_each_kind() -> None:
    session, uri = opened()
    found = texts(session, session.definition(uri, place(session, uri, "where plants.fru")))
    assert [(line, name) for _, line, name in found] == [(8, "fruit"), (9, "fruit")]


def test_references_cross_games_that_extend_one_another(tmp_path: Path) -> None:
    (tmp_path / "small.sj").write_text(SMALL)
    (tmp_path / "other.sj").write_text(
        SMALL.replace('extends "orchard.sj"', "").replace("small", "other")
    )
    (tmp_path / "orchard.sj").write_text(ORCHARD)
    session, uri = opened(ORCHARD, tmp_path)
    found = texts(session, session.references(uri, place(session, uri, "param app")))
    assert found == [
        *(("orchard.sj", line, "apple") for line in (4, 27, 40)),
        *(("small.sj", line, "apple") for line in (3, 5)),
    ]
    without = session.references(uri, place(session, uri, "param app"), declared=False)
    assert len(without) == 4
    small = (tmp_path / "small.sj").as_uri()
    assert texts(session, session.definition(small, place(session, small, "give ap"))) == [
        ("orchard.sj", 4, "apple")
    ]
    assert texts(session, session.definition(small, place(session, small, "phase ea"))) == [
        ("orchard.sj", 25, "eat")
    ]
    assert [
        location.uri
        for location in session.definition(small, place(session, small, 'extends "orch'))
    ] == [uri]


LIT = (
    ORCHARD.replace('kind grass "."', 'kind grass "." { field lit : 0 .. 1 = 0 }')
    .replace('kind gate  "G"', 'kind gate  "G" { field lit : 0 .. 1 = 0 }')
    .replace("  define ready", "  define glows(place) = place.lit > 0\n  define ready")
    .replace("checks { ", "checks { always not any(gate where glows(gate))  ")
)


def test_a_define_means_what_games_that_stand_on_its_own_make_of_it(tmp_path: Path) -> None:
    """The base asks gates alone whether they glow; once another game asks the grass too, its field has the same name in the define."""

    def lines() -> list[int]:
        session, uri = opened(LIT, tmp_path)
        found = texts(session, session.references(uri, place(session, uri, '"." { field li')))
        return [line for file, line, _ in found if file == "orchard.sj"]

    (tmp_path / "orchard.sj").write_text(LIT)
    assert lines() == [7]
    (tmp_path / "small.sj").write_text(
        SMALL.replace("set apple = 3", "checks { always not any(grass where glows(grass)) }")
    )
    assert lines() == [7, 10, 20]


def test_a_local_name_stays_in_its_scope() -> None:
    session, uri = opened()
    found = texts(session, session.references(uri, place(session, uri, "agent as eat")))
    assert [line for _, line, _ in found] == [26, 27, 27, 27, 27]


def test_names_are_found_where_the_text_is_broken_further_on() -> None:
    session, uri = opened()
    session.symbols(uri)
    session.open(uri, ORCHARD.replace("param regrow", "param  =\n  param regrow"), 2)
    found = texts(session, session.definition(uri, place(session, uri, "give app")))
    assert [(line, text) for _, line, text in found] == [(4, "apple")]
    found = texts(session, session.definition(uri, place(session, uri, "-> wal")))
    assert [(line, text) for _, line, text in found] == [(25, "walk")]


def test_a_new_name_reaches_every_file(tmp_path: Path) -> None:
    (tmp_path / "small.sj").write_text(SMALL)
    (tmp_path / "orchard.sj").write_text("stale")
    session, uri = opened(ORCHARD, tmp_path)
    edit = session.rename(uri, place(session, uri, "give app"), "reward_of_apple")
    assert edit.document_changes is not None
    after = {}
    for change in edit.document_changes:
        assert isinstance(change, types.TextDocumentEdit)
        uri = change.text_document.uri
        after[Path(uri).name] = (edited(session, uri, change.edits), change.text_document.version)  # type: ignore[arg-type]
    assert after["orchard.sj"] == (
        ORCHARD.replace("param apple ", "param reward_of_apple ")
        .replace("give apple", "give reward_of_apple")
        .replace("set apple", "set reward_of_apple"),
        1,
    )
    assert after["small.sj"] == (SMALL.replace("apple", "reward_of_apple"), None)


@pytest.mark.parametrize(
    ("before", "new", "reason"),
    [
        ("give app", "regrow", "already stands in"),
        ("give app", "Apple", "small letters"),
        ("give app", "2nd", "begin with a letter"),
        ("give app", "each", "is a word of the language"),
        ("give app", "step", "means something of its own"),
        ("give app", "ripe", "already stands in"),
        ("agent as hi", "zapper", "already stands in"),
        ("phase start", "begin", "is a name of the language"),
        ("turn_le", "left", "is a name of the language"),
        ("each", "every", "there is no name here"),
        ("field b", "row", "means something of its own"),
    ],
)
def test_a_new_name_that_cannot_be_is_refused(before: str, new: str, reason: str) -> None:
    session, uri = opened()
    with pytest.raises(Refused) as refused:
        session.rename(uri, place(session, uri, before), new)
    assert reason in str(refused.value)


def test_a_new_name_that_another_game_on_the_file_has_is_refused(tmp_path: Path) -> None:
    """Otherwise its number would replace the one of its base without a word."""
    (tmp_path / "small.sj").write_text(
        'sj 1\ngame small "S" extends "orchard.sj" { param pear : reward = 2 }\n'
    )
    session, uri = opened(ORCHARD, tmp_path)
    with pytest.raises(Refused, match=r"`pear` already stands in small\.sj"):
        session.rename(uri, place(session, uri, "give app"), "pear")


def test_a_broken_text_gets_no_new_names() -> None:
    session, uri = opened()
    session.symbols(uri)
    session.open(uri, ORCHARD + "}", 2)
    with pytest.raises(Refused, match="syntax errors"):
        session.rename(uri, place(session, uri, "give app"), "pear")
