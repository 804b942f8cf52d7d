"""A worker process that hangs or dies is ended and begun again; the page is told."""

import asyncio
import json
from pathlib import Path
from unittest.mock import AsyncMock

import pytest

from sjdsl.studio import child
from sjdsl.studio.access import Access
from sjdsl.studio.child import Child
from sjdsl.studio.server import make_app


def test_what_takes_too_long_is_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(child, "ANY", 0.0)

    async def both() -> tuple[dict, dict]:
        worker = Child(tmp_path)
        first = json.loads(await worker.ask('{"id": 5, "do": "go", "to": 0}'))
        monkeypatch.setattr(child, "ANY", 60.0)
        second = json.loads(await worker.ask('{"id": 6, "do": "go", "to": 0}'))
        await worker.stop()
        return first, second

    first, second = asyncio.run(both())
    assert (first["id"], first["lost"]) == (5, True)
    assert "was stopped" in first["refused"]
    assert second["id"] == 6
    assert "lost" not in second


def test_a_process_that_dies_is_replaced(tmp_path: Path) -> None:
    async def three() -> list[dict]:
        worker = Child(tmp_path)
        answers = [json.loads(await worker.ask('{"id": 1, "do": "step"}'))]
        worker._process.kill()
        await worker._process.wait()
        answers += [
            json.loads(await worker.ask('{"id": 2, "do": "step"}')),
            json.loads(await worker.ask('{"id": 3, "do": "step"}')),
        ]
        await worker.stop()
        return answers

    before, during, after = asyncio.run(three())
    assert "lost" not in before
    assert during["lost"]
    assert "lost" not in after


def test_a_text_reaches_the_process_whatever_the_encoding(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONIOENCODING", "latin-1")

    async def ask() -> dict:
        worker = Child(tmp_path)
        answer = json.loads(await worker.ask('{"id": 1, "do": "ガ"}'))
        await worker.stop()
        return answer

    assert "ガ" in asyncio.run(ask())["refused"]


def test_processes_wait_for_a_page_and_end_with_the_server(tmp_path: Path) -> None:
    async def one() -> tuple[int, str, list[int | None]]:
        spares = child.Spares(tmp_path, 1)
        async with spares.kept():
            await asyncio.gather(*spares._filling)
            waiting = spares._waiting[0]._process
            taken = spares.take()
            answer = await taken.ask('{"id": 1, "do": "step"}')
            assert taken._process is waiting, "the one that had been started"
            left = Child(tmp_path)
            await left.begin()
            spares._waiting.append(left)
            other = left._process
        await taken.stop()
        return len(spares._filling), answer, [waiting.returncode, other.returncode]

    filling, answer, codes = asyncio.run(one())
    assert json.loads(answer)["id"] == 1
    assert None not in codes, "none is left behind"
    assert filling <= 1


def test_a_page_that_is_closed_stops_what_it_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A request that would go on for long does not keep its process when nobody waits for the answer any more."""
    said: list[str] = []

    class Endless(Child):
        async def ask(self, request: str) -> str:
            said.append(request)
            await asyncio.sleep(3600)
            return request

        async def stop(self) -> None:
            said.append("stopped")

    monkeypatch.setattr(child.Spares, "take", lambda _: Endless(tmp_path))
    headers = [(b"host", b"127.0.0.1:8123")]
    scope = {
        "type": "websocket",
        "path": "/bench",
        "query_string": b"token=secret",
        "headers": headers,
        "subprotocols": [],
    }

    async def visit() -> None:
        heard = asyncio.Queue[dict[str, object]]()
        for message in (
            {"type": "websocket.connect"},
            {"type": "websocket.receive", "text": "checks"},
        ):
            heard.put_nowait(message)
        page = asyncio.create_task(
            make_app(tmp_path, Access(8123, "secret"))(scope, heard.get, AsyncMock())
        )
        while not said:
            await asyncio.sleep(0.01)
        heard.put_nowait({"type": "websocket.receive", "text": "step"})
        heard.put_nowait({"type": "websocket.disconnect", "code": 1001})
        await asyncio.wait([page], timeout=5)
        assert page.done()

    asyncio.run(visit())
    assert said == ["checks", "stopped"]
