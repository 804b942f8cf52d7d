"""Texts that are in no file: not saved yet, or of an earlier version; and those that may not be read."""

from pathlib import Path

import pytest

from sjdsl.editor.session import Session
from tests.editor.asked import ORCHARD

MAPPED = ORCHARD.replace('map { "G..G" ".TB." }', 'map "maps/orchard.txt"')


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "maps").mkdir()
    (tmp_path / "maps" / "orchard.txt").write_text("G..G\n.TB.\n")
    (tmp_path / "orchard.sj").write_text(MAPPED)
    return tmp_path


def errors(session: Session, uri: str) -> list[str]:
    return [d.message for d in session.diagnostics(uri) if d.severity == 1]


@pytest.mark.parametrize(
    "text",
    [MAPPED, MAPPED.replace("orchard.txt", "old.txt"), 'sj 1\ngame a extends "gone.sj" { }\n'],
)
@pytest.mark.parametrize(
    "uri",
    [
        "git:{}/orchard.sj?%7B%22ref%22%3A%22~%22%7D",
        "untitled:Untitled-1",
        "untitled:{}/new.sj",
        "gitlens://x{}/orchard.sj",
    ],
)
def test_files_are_not_missed_where_they_are_not_known(uri: str, text: str, folder: Path) -> None:
    session = Session()
    uri = uri.format(folder)
    session.open(uri, text, 1)
    assert errors(session, uri) == []


def test_an_earlier_version_has_the_maps_beside_its_file(folder: Path) -> None:
    session = Session()
    uri = f"git:{folder}/orchard.sj?ref"
    session.open(uri, MAPPED.replace("set apple = 2", "set aple = 2"), 1)
    assert ["`aple`" in message for message in errors(session, uri)] == [True]
    session.open(uri, MAPPED, 2)
    assert session.analyses.of(uri).build is not None


def test_an_earlier_version_does_not_stand_for_the_file(folder: Path) -> None:
    session = Session()
    file, earlier = (folder / "orchard.sj").as_uri(), f"git:{folder}/orchard.sj?ref"
    session.open(earlier, "sj 1\ngame broken {", 1)
    child = (folder / "child.sj").as_uri()
    session.open(child, 'sj 1\ngame child extends "orchard.sj" { }\n', 1)
    assert errors(session, child) == []
    assert session.documents.get(file).text == MAPPED


def test_only_files_inside_are_read(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    outside = tmp_path_factory.mktemp("outside")
    (outside / "other.sj").write_text(MAPPED)
    (folder / "link.sj").symlink_to(outside / "other.sj")
    session = Session(allowed=[folder])
    read = [
        session.documents.get(path.as_uri()) is not None
        for path in (folder / "orchard.sj", outside / "other.sj", folder / "link.sj")
    ]
    assert read == [True, False, False]
    for uri in ((outside / "new.sj").as_uri(), f"git:{outside}/new.sj"):
        session.open(uri, 'sj 1\ngame new extends "other.sj" { }\n', 1)
        assert session.analyses.of(uri).composition is None


def test_files_behind_a_link_out_of_the_folder_are_not_offered(
    folder: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    outside = tmp_path_factory.mktemp("outside")
    (outside / "secret.txt").write_text("..\n")
    (folder / "elsewhere").symlink_to(outside)
    session = Session()
    uri = (folder / "orchard.sj").as_uri()
    text = MAPPED[: MAPPED.index("maps/orchard.txt")]
    session.open(uri, text, 1)
    end = session.documents.get(uri).lines.position(len(text))
    assert [offer.label for offer in session.completion(uri, end)] == ["maps/orchard.txt"]
