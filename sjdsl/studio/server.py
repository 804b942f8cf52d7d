"""The studio's server: its page, the files of one folder, and sockets to the processes that play games and look at texts."""

import asyncio
import contextlib
import json
from collections.abc import Callable, Coroutine
from importlib.resources import files
from pathlib import Path
from typing import Any

import jinja2
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from sjdsl.editor.highlighting import patterns
from sjdsl.studio.access import Access
from sjdsl.studio.child import Spares
from sjdsl.studio.files import answered
from sjdsl.studio.folder import LARGEST, Folder
from sjdsl.studio.language import serve_language

ASSETS = {
    "studio.js": ("sjdsl.studio", "text/javascript"),
    "studio.css": ("sjdsl.studio", "text/css"),
    "board.js": ("sjdsl.render", "text/javascript"),
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
        *(Route(path, _files(inside)) for path in ("/games", "/tour")),
        Route("/file", _files(inside), methods=["GET", "PUT"]),
        *(Route(path, _files(inside), methods=["POST"]) for path in ("/copy", "/new")),
        WebSocketRoute("/bench", _bench(spares)),
        WebSocketRoute("/language", lambda socket: serve_language(socket, inside.root)),
    ]
    return Starlette(
        routes=routes,
        middleware=[Middleware(Guard, access=access)],
        lifespan=lambda _app: spares.kept(),
    )


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
        reason = self._access.refusal(
            request.headers, request.query_params.get("token"), needs_token
        )
        if reason is None:
            await self._app(scope, receive, send)
        elif isinstance(request, WebSocket):
            await request.close(REFUSED, reason)
        else:
            await PlainTextResponse(reason + "\n", 403)(scope, receive, send)


def _page(opened: str | None) -> Callable[[Request], Response]:
    environment = jinja2.Environment(undefined=jinja2.StrictUndefined, autoescape=True)
    page = environment.from_string(
        files("sjdsl.studio").joinpath("page/studio.html").read_text(encoding="utf-8")
    )
    given = {"opened": opened or "", "patterns": json.dumps(patterns())}
    return lambda request: HTMLResponse(
        page.render(token=request.query_params["token"], **given), headers=HEADERS
    )


def _asset(request: Request) -> Response:
    name = request.path_params["name"]
    if name not in ASSETS:
        raise HTTPException(404)
    package, sort = ASSETS[name]
    return Response(
        files(package).joinpath(f"page/{name}").read_text(encoding="utf-8"),
        media_type=sort,
        headers=HEADERS,
    )


def _files(folder: Folder) -> Handler:
    """Answers a request about files, beside the other requests: to list a large folder takes a while."""

    async def answer(request: Request) -> Response:
        body = b""
        async for part in request.stream():
            body += part
            if len(body) > 2 * LARGEST:
                return JSONResponse({"refused": "the text is too large"}, 413, HEADERS)
        status, found = await run_in_threadpool(
            answered, folder, request.method, request.url.path, request.query_params, body
        )
        return JSONResponse(found, status, HEADERS)

    return answer


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
        except (
            WebSocketDisconnect,
            RuntimeError,
            asyncio.CancelledError,
        ):  # RuntimeError: it is closed where an answer is sent
            pass
        except KeyError:  # bytes in place of text
            await socket.close(UNREADABLE)
        finally:
            for task in tasks:
                task.cancel()
            with contextlib.suppress(ProcessLookupError):
                await child.stop()

    return bench
