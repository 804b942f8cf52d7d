"""Games of installed packages in the studio: listed under their release, read only, copied with their maps."""

from pathlib import Path

import pytest
from starlette.testclient import TestClient

from sjdsl.cli.studio import _inside
from sjdsl.studio.access import Access
from sjdsl.studio.bench import Bench
from sjdsl.studio.examples import example_of, place_of
from sjdsl.studio.folder import FileRefused
from sjdsl.studio.requests import READ
from sjdsl.studio.server import make_app
from tests.cli.installed_packages import game, install

TOKEN = "?token=secret"
RIVER = game("river").replace('map { "..." }', 'map "maps/river.txt"')


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of an installed package with two games and a map."""
    place = tmp_path / "site"
    place.mkdir()
    monkeypatch.syspath_prepend(place)
    return install(place, "river_games", {"river.sj": RIVER, "lake.sj": game("lake"), "maps/river.txt": "...\n"}, "0.3")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "mine").mkdir()
    return tmp_path / "mine"


@pytest.fixture
def client(home: Path, folder: Path) -> TestClient:
    assert home.is_dir()
    return TestClient(make_app(folder, Access(8123, "secret")), headers={"host": "127.0.0.1:8123"})


def test_they_are_listed_under_their_release(client: TestClient) -> None:
    listed = client.get("/games" + TOKEN).json()
    assert listed["packages"] == [
        {"release": "river-games 0.3", "games": ["package:river_games/lake.sj", "package:river_games/river.sj"]},
    ]
    assert not any("river" in path for path in (*listed["games"], *listed["examples"], *listed["tour"]))


def test_they_are_read_with_their_maps_and_play(client: TestClient, home: Path, folder: Path) -> None:
    found = client.get("/file", params={"token": "secret", "path": "package:river_games/river.sj"}).json()
    assert (found["text"], found["uri"]) == (RIVER, (home / "river.sj").resolve().as_uri())
    text = READ.validate_python({"do": "text", "id": 1, "version": 1, "path": "package:river_games/river.sj", "text": found["text"]})
    assert Bench(folder).answer(text)["game"]["width"] == 3


def test_a_copy_has_its_map_and_the_package_stays(client: TestClient, home: Path, folder: Path) -> None:
    given = {"example": "package:river_games/river.sj", "path": "mine.sj", "text": RIVER + "# mine\n"}
    assert client.post("/copy" + TOKEN, json=given).json()["copied"] == ["maps/river.txt"]
    assert (folder / "mine.sj").read_text(encoding="utf-8") == RIVER + "# mine\n"
    assert (folder / "maps/river.txt").read_text(encoding="utf-8") == "...\n"
    written = {"path": "package:river_games/river.sj", "text": "x", "digest": None}
    client.put("/file" + TOKEN, json=written)
    assert (home / "river.sj").read_text(encoding="utf-8") == RIVER


@pytest.mark.parametrize(
    "path", ["package:gone_games/river.sj", "package:river_games/../../secret.sj", "package:river_games", "package:/x.sj"]
)
def test_nothing_else_is_read(client: TestClient, path: str, tmp_path: Path) -> None:
    (tmp_path / "secret.sj").write_text("not yours", encoding="utf-8")
    answer = client.get("/file", params={"token": "secret", "path": path})
    assert answer.status_code == 404
    assert "not yours" not in answer.text


def test_the_command_opens_one_by_its_name(home: Path, folder: Path) -> None:
    assert _inside("river_games:lake", folder) == "package:river_games/lake.sj"
    assert _inside("river", folder) == "package:river_games/river.sj"
    assert _inside("coins", folder) == "example:coins.sj"
    assert example_of(folder / "mine.sj") is None
    assert place_of("package:river_games/maps/river.txt", folder) == (home.resolve(), "maps/river.txt")
    with pytest.raises(FileRefused, match="no installed package `gone`"):
        place_of("package:gone/river.sj", folder)
