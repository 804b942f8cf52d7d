"""The studio without a server: files, the board and the language server, asked as a page asks them."""

import asyncio
import json
from pathlib import Path
from typing import Any
from urllib.request import url2pathname

import pytest

from sjdsl.studio.serverless import Serverless


@pytest.fixture
def alone(tmp_path: Path) -> Serverless:
    return Serverless(tmp_path / "folder")


def file(alone: Serverless, method: str, address: str, /, **given: Any) -> dict[str, Any]:
    return json.loads(alone.file(method, address, json.dumps(given) if given else ""))


def test_examples_are_opened_and_played(alone: Serverless) -> None:
    listed = file(alone, "GET", "/games?token=none")
    assert listed["games"] == []
    assert "example:clean_up.sj" in listed["examples"]
    found = file(alone, "GET", "/file?path=example%3Acoins.sj&token=none")
    text = found["text"]
    assert (
        Path(url2pathname(found["uri"].removeprefix("file://"))).read_text(encoding="utf-8") == text
    )
    opened = json.loads(
        alone.bench(
            json.dumps(
                {"do": "text", "id": 1, "version": 1, "path": "example:coins.sj", "text": text}
            )
        )
    )
    assert opened["compiles"]
    assert json.loads(alone.bench(json.dumps({"do": "step", "id": 2})))["at"] == 1
    trained = json.loads(alone.bench('{"do": "others", "policy": "RUN@best", "id": 4}'))["refused"]
    assert "take seats where sjdsl and JAX are installed" in trained
    assert "unknown" in json.loads(alone.bench('{"do": "nothing", "id": 3}'))["refused"]


def test_a_copy_is_written_with_what_it_needs_and_kept_by_another_worker(
    alone: Serverless, tmp_path: Path
) -> None:
    text = file(alone, "GET", "/file?path=example:clean_up.sj")["text"]
    copied = file(alone, "POST", "/copy", example="example:clean_up.sj", path="mine.sj", text=text)
    assert set(copied["written"]) == {"mine.sj", *copied["copied"]}
    other = Serverless(tmp_path / "other")
    for path, kept in copied["written"].items():
        other.keep(path, kept)
        other.keep(path, kept)
    assert file(other, "GET", "/games")["games"] == [
        "mine.sj",
        "meltingpot/shared/edges.sj",
        "meltingpot/shared/endings.sj",
    ]
    assert (
        file(other, "GET", "/file?path=mine.sj").items()
        >= {"text": text, "digest": copied["digest"]}.items()
    )
    assert (
        "already"
        in file(alone, "POST", "/copy", example="example:clean_up.sj", path="mine.sj", text=text)[
            "refused"
        ]
    )


@pytest.mark.parametrize("prepared", [False, True])
def test_the_language_server_answers(alone: Serverless, tmp_path: Path, prepared: bool) -> None:
    root = (tmp_path / "folder").resolve().as_uri()

    async def talk() -> list[dict[str, Any]]:
        heard: list[dict[str, Any]] = []

        def hear(text: str) -> None:
            heard.append(json.loads(text))

        def say(**message: Any) -> None:
            alone.language(json.dumps({"jsonrpc": "2.0", **message}), hear)

        if prepared:
            alone.prepare_language(hear)
            assert heard == [], "nobody has asked yet"
        say(
            id=1,
            method="initialize",
            params={"capabilities": {}, "rootUri": root, "processId": None},
        )
        say(method="initialized", params={})
        document = {
            "uri": root + "/a.sj",
            "languageId": "sj",
            "version": 1,
            "text": "sj 1\ngame a {\n  kind flor\n}\n",
        }
        say(method="textDocument/didOpen", params={"textDocument": document})
        async with asyncio.timeout(20):
            while not any(
                message.get("method") == "textDocument/publishDiagnostics" for message in heard
            ):
                await asyncio.sleep(0.01)
        return heard

    heard = asyncio.run(talk())
    assert (
        "completionProvider" in next(m for m in heard if m.get("id") == 1)["result"]["capabilities"]
    )
    assert any(
        m["params"]["diagnostics"]
        for m in heard
        if m.get("method") == "textDocument/publishDiagnostics"
    )
