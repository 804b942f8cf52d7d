"""Who gets in: the studio's own page with its token; nobody else's page, no other name of this machine, no file outside the folder."""

import json
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from urllib.parse import quote

import pytest
from click import ClickException
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect

from sjdsl.cli.studio import _path_in_page
from sjdsl.compiler import check
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.parse import parse
from sjdsl.compiler.syntax.read import read_source
from sjdsl.files import write_whole
from sjdsl.library.games_folder import games_folder
from sjdsl.studio.access import Access, kept_token
from sjdsl.studio.server import FirstGame, make_app

ACCESS = Access(8123, "secret")
OWN = {"host": "127.0.0.1:8123"}
TOKEN = "?token=secret"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    inside = tmp_path / "inside"
    (inside / "maps").mkdir(parents=True)
    (inside / "yard.sj").write_text("sj 1\n", encoding="utf-8")
    (inside / "maps" / "yard.txt").write_text("..\n", encoding="utf-8")
    (inside / "notes.md").write_text("mine\n", encoding="utf-8")
    (tmp_path / "outside.sj").write_text("not yours\n", encoding="utf-8")
    (inside / "link.sj").symlink_to(tmp_path / "outside.sj")
    return inside


@pytest.fixture
def client(folder: Path) -> TestClient:
    return TestClient(make_app(folder, ACCESS, FirstGame("yard.sj", "rich+dry", 3)), headers=OWN)


def test_the_page_wants_the_token(client: TestClient) -> None:
    assert client.get("/").status_code == 403
    assert client.get("/?token=guess").status_code == 403
    page = client.get("/" + TOKEN)
    assert page.status_code == 200
    for name, content in (("opened", "yard.sj"), ("variant", "rich+dry"), ("agents", "3")):
        assert f'<meta name="{name}" content="{content}">' in page.text
    assert "default-src 'none'" in page.headers["content-security-policy"]


@pytest.mark.parametrize("path", ["/games", "/file?path=yard.sj", "/"])
@pytest.mark.parametrize(
    "headers",
    [
        {"host": "evil.example:8123"},
        {"host": "127.0.0.1:9999"},
        {"origin": "https://evil.example"},
        {"origin": "http://127.0.0.1:9999"},
        {"origin": "null"},
    ],
    ids=str,
)
def test_other_hosts_and_origins_are_refused_whatever_they_know(
    client: TestClient, path: str, headers: dict[str, str]
) -> None:
    token = ("&" if "?" in path else "?") + "token=secret"
    assert client.get(path + token, headers=headers).status_code == 403
    assert client.get(path + token, headers={"origin": "http://127.0.0.1:8123"}).status_code == 200


def test_every_game_that_can_be_opened_has_its_title_and_a_picture(client: TestClient) -> None:
    listed = client.get("/games" + TOKEN).json()
    bases = ("edges", "endings")  # of other games, without a map
    for path in (*listed["examples"], *listed["tour"]):
        text = client.get("/file", params={"path": path, "token": "secret"}).json()["text"]
        title = parse(Source(path, text)).game.title
        assert title is not None
        assert listed["titles"][path] == title.text
        stem = path.removeprefix("tour:").removesuffix(".sj").split("/")[-1].split(":")[-1]
        wanted = 404 if stem in bases else 200
        assert client.get(f"/assets/thumbnails/{stem}.png").status_code == wanted
    assert client.get("/assets/thumbnails/..%2Fpage%2Fstudio.css").status_code == 404


@pytest.mark.parametrize("path", ["/bench", "/language"])
@pytest.mark.parametrize(
    "wrong",
    [("", {}), (TOKEN, {"origin": "https://evil.example"}), (TOKEN, {"host": "evil.example"})],
    ids=str,
)
def test_sockets_are_refused_alike(
    client: TestClient, path: str, wrong: tuple[str, dict[str, str]]
) -> None:
    query, headers = wrong
    with (
        pytest.raises(WebSocketDisconnect) as closed,
        client.websocket_connect(path + query, headers=OWN | headers),
    ):
        pass
    assert closed.value.code == 4403


@pytest.mark.parametrize(
    "path",
    [
        "../outside.sj",
        "/etc/passwd",
        "link.sj",
        "notes.md",
        "maps/../../outside.sj",
        ".",
        "",
        "gone.sj",
    ],
)
def test_only_games_and_maps_inside_the_folder_are_read(client: TestClient, path: str) -> None:
    answer = client.get("/file", params={"token": "secret", "path": path})
    assert answer.status_code == 404
    assert "not yours" not in answer.text
    assert "mine" not in answer.text


def test_the_command_opens_bundled_games_as_examples_and_others_in_its_folder(folder: Path) -> None:
    assert _path_in_page("coins", folder) == "example:coins.sj"
    assert _path_in_page(str(folder / "yard.sj"), folder) == "yard.sj"
    with pytest.raises(ClickException, match="is outside this folder"):
        _path_in_page(str(folder.parent / "outside.sj"), folder)


@pytest.mark.parametrize("path", ["../new.sj", "/tmp/new.sj", "new.py", "link.sj"])
def test_nothing_else_is_written(client: TestClient, folder: Path, path: str) -> None:
    answer = client.put("/file" + TOKEN, json={"path": path, "text": "mine now", "digest": None})
    assert answer.status_code == 400
    assert "mine now" not in (folder.parent / "outside.sj").read_text(encoding="utf-8")
    assert not (folder.parent / "new.sj").exists()


def test_a_file_that_somebody_else_changed_is_not_written_over(
    client: TestClient, folder: Path
) -> None:
    first = client.get("/file", params={"token": "secret", "path": "yard.sj"}).json()
    (folder / "yard.sj").write_text("theirs\n", encoding="utf-8")
    answer = client.put(
        "/file" + TOKEN, json={"path": "yard.sj", "text": "mine\n", "digest": first["digest"]}
    )
    assert answer.status_code == 409
    assert (folder / "yard.sj").read_text(encoding="utf-8") == "theirs\n"
    now = client.get("/file", params={"token": "secret", "path": "yard.sj"}).json()
    saved = client.put(
        "/file" + TOKEN, json={"path": "yard.sj", "text": "mine\n", "digest": now["digest"]}
    )
    assert saved.status_code == 200
    assert (folder / "yard.sj").read_text(encoding="utf-8") == "mine\n"
    assert (
        client.put(
            "/file" + TOKEN, json={"path": "yard.sj", "text": "x", "digest": saved.json()["digest"]}
        ).status_code
        == 200
    )


def test_an_example_is_copied_with_its_maps_and_bases(client: TestClient, folder: Path) -> None:
    text = client.get(
        "/file", params={"token": "secret", "path": "example:harvest_closed.sj"}
    ).json()["text"]
    assert text.startswith("sj 1")
    asked = {
        "example": "example:harvest_closed.sj",
        "path": "mine.sj",
        "text": text.replace("sj 1", "sj 1\n# mine", 1),
    }
    assert client.post("/copy" + TOKEN, json=asked).status_code == 200
    assert "# mine" in (folder / "mine.sj").read_text(encoding="utf-8")
    assert not check(read_source(folder / "mine.sj"))
    assert (folder / "harvest_open.sj").is_file()
    again = client.post("/copy" + TOKEN, json=asked)
    assert again.status_code == 400
    assert "already" in again.json()["refused"]
    assert (
        client.post("/copy" + TOKEN, json=asked | {"path": "../outside_too.sj"}).status_code == 400
    )


@pytest.mark.parametrize(
    ("like", "map_"),
    [("", "new_game.txt"), ("example:harvest_closed.sj", "maps/harvest_closed.txt")],
)
def test_a_new_game_has_its_map_and_its_name(
    client: TestClient, folder: Path, like: str, map_: str
) -> None:
    made = client.post("/new" + TOKEN, json={"path": "new_game.sj", "like": like}).json()
    assert {"new_game.sj", map_} <= set(made["copied"])
    assert "game new_game " in (folder / "new_game.sj").read_text(encoding="utf-8")
    assert not [d for d in check(read_source(folder / "new_game.sj")) if d.severity == "error"]
    for path, reason in (
        ("new_game.sj", "already"),
        ("New Game.sj", "cannot name a game"),
        ("../new.sj", "outside"),
    ):
        assert (
            reason
            in client.post("/new" + TOKEN, json={"path": path, "like": like}).json()["refused"]
        )


def test_a_message_of_nonsense_is_answered_in_words(client: TestClient) -> None:
    with client.websocket_connect("/bench" + TOKEN, headers=OWN) as socket:
        for message in (
            "{",
            "[]",
            '{"do": "explode"}',
            json.dumps({"do": "begin", "seed": 10**12}),
            json.dumps({"do": "step", "actions": {"x": 0}}),
            json.dumps({"do": "panel", "panel": "differences"}),
            json.dumps({"do": "text", "text": "x" * 500_000}),
        ):
            socket.send_text(message)
            assert "something unknown" in json.loads(socket.receive_text())["refused"]
        socket.send_text(json.dumps({"id": 8, "do": "explode"}))
        assert json.loads(socket.receive_text())["id"] == 8, "the page knows which request it was"
        socket.send_text(json.dumps({"id": 3, "do": "step"}))
        assert "compiled yet" in json.loads(socket.receive_text())["refused"]


def test_the_token_of_a_user_is_kept_and_read_by_nobody_else(tmp_path: Path) -> None:
    token = kept_token(tmp_path / "cache")
    path = tmp_path / "cache" / "studio_token"
    assert len(token) >= 32
    assert kept_token(tmp_path / "cache") == token
    assert path.stat().st_mode & 0o077 == 0
    path.chmod(0o644)
    assert kept_token(tmp_path / "cache") != token, "somebody may have read it"


@pytest.mark.parametrize(
    "path", ["\0", "x" * 5000 + ".sj", "a/" * 3000 + "x.sj", "\ud800.sj", "maps"]
)
def test_a_name_that_no_file_can_have_is_refused(client: TestClient, path: str) -> None:
    for answer in (
        client.get("/file?token=secret&path=" + quote(path.encode("utf-8", "surrogatepass"))),
        client.put(
            "/file" + TOKEN, content=json.dumps({"path": path, "text": "x", "digest": None})
        ),
        client.post(
            "/copy" + TOKEN,
            content=json.dumps({"example": "example:coins.sj", "path": path, "text": "x"}),
        ),
    ):
        assert answer.status_code in (400, 404)
        assert answer.json()["refused"]


@pytest.mark.parametrize(
    "body",
    [
        "",
        "[]",
        '"x"',
        "null",
        "[" * 100_000,
        "{}",
        '{"path": "yard.sj"}',
        '{"path": 1, "text": {}}',
    ],
    ids=lambda b: b[:12],
)
def test_a_request_of_nonsense_is_refused_in_words(
    client: TestClient, folder: Path, body: str
) -> None:
    before = (folder / "yard.sj").read_text(encoding="utf-8")
    for answer in (
        client.put("/file" + TOKEN, content=body),
        client.post("/copy" + TOKEN, content=body),
    ):
        assert answer.status_code in (400, 409)
        assert answer.json()["refused"].startswith(("the request", "`", "there is"))
    assert (folder / "yard.sj").read_text(encoding="utf-8") == before


def test_a_large_file_is_not_read_whole(client: TestClient, folder: Path) -> None:
    with open(folder / "huge.sj", "wb") as file:
        file.truncate(2**40)  # of holes
    assert "has more than" in client.get("/file?token=secret&path=huge.sj").json()["refused"]


def test_a_socket_outlives_messages_that_break_readers(client: TestClient) -> None:
    with client.websocket_connect("/bench" + TOKEN, headers=OWN) as socket:
        for message in (
            '{"id": Infinity, "do": "step"}',
            "[" * 100_000,
            '{"id": "٣", "do": 7}',
            '{"id": 1, "do": "text", "text": "\\ud800"}',
        ):
            socket.send_text(message)
            assert "unknown" in json.loads(socket.receive_text())["refused"]
        socket.send_bytes(b"\xff\x00")
        with pytest.raises(WebSocketDisconnect) as closed:
            socket.receive_text()
    assert closed.value.code == 1003


def language(client: TestClient, *messages: tuple[str, dict]) -> list[dict]:
    """Returns what the language server of the studio says to each message, in its order."""
    answers = []
    with client.websocket_connect("/language" + TOKEN, headers=OWN) as socket:
        for number, (method, params) in enumerate(
            (("initialize", {"capabilities": {}}), *messages)
        ):
            is_question = method != "textDocument/didOpen"
            socket.send_text(
                json.dumps(
                    {"jsonrpc": "2.0", "method": method, "params": params}
                    | ({"id": number} if is_question else {})
                )
            )
            while is_question:
                told = json.loads(socket.receive_text())
                if told.get("id") == number:
                    answers.append(told)
                    break
    return answers[1:]


def test_the_language_server_reads_no_other_folder(client: TestClient, folder: Path) -> None:
    game = "sj 1\ngame  odd { param apple : reward = 1 }\n"
    (folder / "yard.sj").write_text(game, encoding="utf-8")
    (folder.parent / "outside.sj").write_text(game, encoding="utf-8")
    places = [folder / "yard.sj", folder.parent / "outside.sj", folder / "link.sj"]
    example = games_folder() / "coins.sj"
    at = {"line": 1, "character": 20}
    hovers = [
        ("textDocument/hover", {"textDocument": {"uri": path.as_uri()}, "position": at})
        for path in places
    ]
    format_ = {"options": {"tabSize": 2, "insertSpaces": True}}
    formats = [
        ("textDocument/formatting", {"textDocument": {"uri": path.as_uri()}, **format_})
        for path in places
    ]
    outlines = [
        ("textDocument/documentSymbol", {"textDocument": {"uri": path.as_uri()}})
        for path in (*places, example)
    ]
    answers = [answer["result"] for answer in language(client, *hovers, *formats, *outlines)]
    assert [bool(answer) for answer in answers] == [
        True,
        False,
        False,
        True,
        False,
        False,
        True,
        False,
        False,
        True,
    ]


def test_a_text_put_outside_reads_nothing_beside_it(client: TestClient, folder: Path) -> None:
    (folder.parent / "outside.sj").write_text(
        "sj 1\ngame base { param secret : reward = 1 }\n", encoding="utf-8"
    )
    uri = (folder.parent / "put.sj").as_uri()
    text = 'sj 1\ngame put extends "outside.sj" { set secret = 2 }\n'
    opened = {"uri": uri, "languageId": "sj", "version": 1, "text": text}
    for line, character in ((1, 25), (1, 42)):
        question = {
            "textDocument": {"uri": uri},
            "position": {"line": line, "character": character},
        }
        (answer,) = language(
            client,
            ("textDocument/didOpen", {"textDocument": opened}),
            ("textDocument/definition", question),
        )
        assert not answer["result"]


def test_of_several_who_save_at_once_one_does(
    client: TestClient, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def slowly(path: Path, data: bytes) -> None:
        time.sleep(0.05)
        write_whole(path, data)

    monkeypatch.setattr("sjdsl.studio.folder.write_whole", slowly)
    first = client.get("/file", params={"token": "secret", "path": "yard.sj"}).json()["digest"]
    for path, before in (("yard.sj", first), ("new.sj", None)):
        texts = [f"sj 1\n# {number}\n" for number in range(6)]
        with ThreadPoolExecutor(6) as pool:
            asked = [{"path": path, "text": text, "digest": before} for text in texts]
            answers = list(
                pool.map(lambda given: client.put("/file" + TOKEN, json=given).status_code, asked)
            )
        assert sorted(answers) == [200, *[409] * 5]
        assert (folder / path).read_text(encoding="utf-8") == texts[answers.index(200)]


ODD = [
    "%C3%A9",
    "%FF%FE",
    "%00",
    "%ED%A0%80",
    "%",
    "%zz",
    "&token=",
    "%F0%9F%8D%92",
    "+",
    "a" * 10_000,
]


@pytest.mark.parametrize("token", ODD)
@pytest.mark.parametrize("path", ["/", "/games", "/file"])
def test_any_token_is_refused_in_words(client: TestClient, path: str, token: str) -> None:
    answer = client.get(f"{path}?token={token}")
    assert (answer.status_code, "token" in answer.text) == (403, True)


@pytest.mark.parametrize("token", ODD)
@pytest.mark.parametrize("path", ["/bench", "/language"])
def test_a_socket_with_any_token_is_refused(client: TestClient, path: str, token: str) -> None:
    with (
        pytest.raises(WebSocketDisconnect) as closed,
        client.websocket_connect(f"{path}?token={token}", headers=OWN),
    ):
        pass
    assert closed.value.code == 4403


@pytest.mark.parametrize(
    "name", [b"host", b"origin", b"cookie", b"content-type", b"content-length", b"x"]
)
@pytest.mark.parametrize("value", [b"\xc3\xa9", b"\xff", b"", b"127.0.0.1:8123\xe9"])
def test_any_header_is_answered(client: TestClient, name: bytes, value: bytes) -> None:
    headers = [(b"host", b"127.0.0.1:8123")] * (name != b"host") + [(name, value)]
    assert client.request("GET", "/games" + TOKEN, headers=headers).status_code == (
        403 if name in (b"host", b"origin") else 200
    )


@pytest.mark.parametrize(
    "query",
    [
        "path=%FF",
        "path=%00",
        "path=%ED%A0%80.sj",
        "path",
        "",
        "path=%C3%A9.sj",
        "path=a.sj&path=%FF",
        "%FF=%FF",
    ],
)
@pytest.mark.parametrize(
    "address", ["/file", "/games", "/tour", "/copy", "/new", "/assets/%FF", "/%C3%A9"]
)
@pytest.mark.parametrize("method", ["GET", "PUT", "POST", "DELETE"])
def test_any_query_is_answered(client: TestClient, method: str, address: str, query: str) -> None:
    answer = client.request(method, f"{address}{TOKEN}&{query}", content=b"\xff")
    assert answer.status_code < 500


def test_a_page_keeps_the_line_ends_of_a_file(client: TestClient, folder: Path) -> None:
    """The text of a page has none of Windows."""
    (folder / "yard.sj").write_bytes(b"sj 1\r\n# before\r\n")
    digest = client.get("/file", params={"token": "secret", "path": "yard.sj"}).json()["digest"]
    for text in ("sj 1\n# after\n", "sj 1\n# at last\n"):
        saved = client.put(
            "/file" + TOKEN, json={"path": "yard.sj", "text": text, "digest": digest}
        )
        digest = saved.json()["digest"]
        assert (folder / "yard.sj").read_bytes() == text.replace("\n", "\r\n").encode()
