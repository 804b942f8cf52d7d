"""The studio's server: its page, the files of one folder, and sockets to the processes that play games and look at texts."""

import asyncio
import contextlib
import json
from collections.abc import Callable, Coroutine
from functools import partial
from importlib.resources import files
from pathlib import Path
from typing import Any

import jinja2
from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from sjdsl.studio import files as requested
from sjdsl.studio import tour
from sjdsl.studio.access import Access
from sjdsl.studio.child import Spares
from sjdsl.studio.folder import LARGEST, Changed, FileRefused, Folder
from sjdsl.studio.language import serve_language
from sjdsl.studio.runs import stored_policies

ASSETS = {
    "studio.js": ("sjdsl.studio", "page/studio.js", "text/javascript"),
    "studio.css": ("sjdsl.studio", "page/studio.css", "text/css"),
    "board.js": ("sjdsl.render", "page/board.js", "text/javascript"),
}
Handler = Callable[[Request], Coroutine[Any, Any, Response]]
REFUSED = 4403  # close code of a socket that may not be opened
UNREADABLE = 1003  # of one that has sent something other than text
MOST_WAITING = 100  # requests of a socket that wait for their turn; a page sends few at a time
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
HEADERS = {
    "content-security-policy": POLICY,
    "referrer-policy": "no-referrer",
    "x-content-type-options": "nosniff",
    "cache-control": "no-store",
}


def make_app(folder: Path, access: Access, opened: str | None = None) -> Starlette:
    """Returns the server of a folder. `opened`: the game that the page opens first, by its path inside."""
    inside = Folder(folder.resolve())
    spares = Spares(inside.root)
    routes = [
        Route("/", _page(opened)),
        Route("/assets/{name}", _asset),
        Route("/games", _games(inside)),
        Route("/tour", lambda _request: JSONResponse({"steps": tour.steps()}, headers=HEADERS)),
        Route("/policies", _policies(inside)),
        Route("/file", _read(inside), methods=["GET"]),
        Route("/file", _changing(partial(requested.write, inside)), methods=["PUT"]),
        Route("/copy", _changing(partial(requested.copy, inside)), methods=["POST"]),
        WebSocketRoute("/bench", _bench(spares)),
        WebSocketRoute("/language", lambda socket: serve_language(socket, inside.root)),
    ]
    return Starlette(routes=routes, middleware=[Middleware(Guard, access=access)], lifespan=lambda _app: spares.kept())


class Guard:
    """Lets only requests through that `Access` allows, and limits their size; see there."""

    def __init__(self, app: ASGIApp, access: Access) -> None:
        self._app, self._access = app, access

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        request = Request(scope) if scope["type"] == "http" else WebSocket(scope, receive, send)
        needs_token = not scope["path"].startswith("/assets/")
        reason = self._access.refusal(request.headers, request.query_params.get("token"), needs_token)
        if reason is None:
            await self._app(scope, receive, send)
        elif isinstance(request, WebSocket):
            await request.close(REFUSED, reason)
        else:
            await PlainTextResponse(reason + "\n", 403)(scope, receive, send)


def _page(opened: str | None) -> Callable[[Request], Response]:
    def page(request: Request) -> Response:
        environment = jinja2.Environment(undefined=jinja2.StrictUndefined, autoescape=True)
        text = environment.from_string(_text("sjdsl.studio", "page/studio.html"))
        return HTMLResponse(text.render(token=request.query_params["token"], opened=opened or ""), headers=HEADERS)

    return page


def _asset(request: Request) -> Response:
    name = request.path_params["name"]
    if name not in ASSETS:
        raise HTTPException(404)
    package, path, sort = ASSETS[name]
    return Response(_text(package, path), media_type=sort, headers=HEADERS)


def _text(package: str, path: str) -> str:
    return files(package).joinpath(path).read_text(encoding="utf-8")


def _games(folder: Folder) -> Callable[[Request], Response]:
    return lambda _request: JSONResponse(requested.listed(folder), headers=HEADERS)


def _policies(folder: Folder) -> Callable[[Request], Response]:
    return lambda _request: JSONResponse({"policies": [[p.name, p.game] for p in stored_policies(folder.root)]}, headers=HEADERS)


def _read(folder: Folder) -> Callable[[Request], Response]:
    def read(request: Request) -> Response:
        try:
            return JSONResponse(requested.read(folder, request.query_params.get("path", "")), headers=HEADERS)
        except FileRefused as reason:
            return JSONResponse({"refused": str(reason)}, 404, HEADERS)

    return read


def _changing(change: Callable[[dict[str, Any]], dict[str, Any]]) -> Handler:
    """Answers a request with JSON that changes files; what cannot be done is refused with the reason."""

    async def answer(request: Request) -> Response:
        body = b""
        async for part in request.stream():
            body += part
            if len(body) > 2 * LARGEST:
                return JSONResponse({"refused": "the text is too large"}, 413, HEADERS)
        try:
            return JSONResponse(change(_fields(body)), headers=HEADERS)
        except Changed as reason:
            return JSONResponse({"refused": str(reason), "changed": True}, 409, HEADERS)
        except FileRefused as reason:
            return JSONResponse({"refused": str(reason)}, 400, HEADERS)
        except KeyError as missing:
            return JSONResponse({"refused": f"the request has no {missing}"}, 400, HEADERS)
        except UnicodeEncodeError:
            return JSONResponse({"refused": "the text has a character that no file can hold"}, 400, HEADERS)

    return answer


def _fields(body: bytes) -> dict[str, Any]:
    """Returns the fields of a request. Raises FileRefused if it is no object of JSON."""
    try:
        given = json.loads(body)
    except (ValueError, RecursionError):
        given = None
    if not isinstance(given, dict):
        raise FileRefused("the request is no object of JSON")
    return given


def _bench(spares: Spares) -> Callable[[WebSocket], Coroutine[Any, Any, None]]:
    async def bench(socket: WebSocket) -> None:
        """Answers each request of a socket by a worker process of its own, one after the other; the process ends with the socket at once."""
        await socket.accept()
        child, waiting = spares.take(), asyncio.Queue[str](MOST_WAITING)

        async def listen() -> None:
            while True:
                await waiting.put(await socket.receive_text())

        async def answer() -> None:
            while True:
                await socket.send_text(await child.ask(await waiting.get()))

        tasks = [asyncio.create_task(listen()), asyncio.create_task(answer())]
        try:
            for ended in (await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED))[0]:
                ended.result()
        except (WebSocketDisconnect, RuntimeError, asyncio.CancelledError):  # RuntimeError: it is closed where an answer is sent
            pass
        except KeyError:  # bytes in place of text
            await socket.close(UNREADABLE)
        finally:
            for task in tasks:
                task.cancel()
            with contextlib.suppress(ProcessLookupError):
                await child.stop()

    return bench
