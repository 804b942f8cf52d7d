"""The studio's server: its page, the files of one folder, and sockets to other processes.

These are a worker that plays games, and the language server.
"""

import asyncio
import contextlib
import json
from collections.abc import Callable, Coroutine
from dataclasses import dataclass
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
from sjdsl.studio.files import answer_request
from sjdsl.studio.folder import LARGEST, Folder
from sjdsl.studio.language import serve_language
from sjdsl.studio.seats import Seats

ASSETS = {
    "studio.js": ("sjdsl.studio", "text/javascript"),
    "studio.css": ("sjdsl.studio", "text/css"),
    "board.js": ("sjdsl.render", "text/javascript"),
}
Handler = Callable[[Request], Coroutine[Any, Any, Response]]
# Close codes of a socket that isn't allowed, and of one that has sent something other than text.
REFUSED = 4403
UNREADABLE = 1003
MAX_WAITING = 100  # requests of a socket that wait for their turn; a page sends few at a time
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data:; connect-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'"
)
HEADERS = {
    "content-security-policy": POLICY,
    "referrer-policy": "no-referrer",
    "x-content-type-options": "nosniff",
    "cache-control": "no-store",
}


@dataclass(frozen=True)
class FirstGame:
    """The game that the page opens first.

    path: in the page, empty without one; variant: `a+b`, or empty; agents: how many, None for as
    many as the file says. Both hold whenever the page opens this game.
    """

    path: str = ""
    variant: str = ""
    agents: int | None = None


def make_app(
    folder: Path, access: Access, first: FirstGame | None = None, seats: Seats | None = None
) -> Starlette:
    """Returns the server of a folder. seats: who plays the game that the page opens first."""
    root = folder.resolve()
    answer_files = _make_file_handler(Folder(root))
    spares = Spares(root, seats=seats)
    routes = [
        Route("/", _make_page_handler(first or FirstGame())),
        Route("/assets/{name}", _answer_asset),
        Route("/assets/thumbnails/{name}", _answer_thumbnail),
        Route("/games", answer_files),
        Route("/tour", answer_files),
        Route("/file", answer_files, methods=["GET", "PUT"]),
        Route("/copy", answer_files, methods=["POST"]),
        Route("/new", answer_files, methods=["POST"]),
        WebSocketRoute("/bench", _make_bench_handler(spares)),
        WebSocketRoute("/language", lambda socket: serve_language(socket, root)),
    ]
    return Starlette(
        routes=routes,
        middleware=[Middleware(Guard, access=access)],
        lifespan=lambda _app: spares.kept(),
    )


class Guard:
    """Passes on only requests that `Access` allows."""

    def __init__(self, app: ASGIApp, access: Access) -> None:
        self._app = app
        self._access = access

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Refuses requests without access, and passes the others on."""
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


def _make_page_handler(first: FirstGame) -> Callable[[Request], Response]:
    """Returns what answers a request for the page, which contains the token of the request."""
    environment = jinja2.Environment(undefined=jinja2.StrictUndefined, autoescape=True)
    html = files("sjdsl.studio").joinpath("page/studio.html").read_text(encoding="utf-8")
    page = environment.from_string(html)
    variables = {"first": first, "patterns": json.dumps(patterns())}
    return lambda request: HTMLResponse(
        page.render(token=request.query_params["token"], **variables), headers=HEADERS
    )


def _answer_asset(request: Request) -> Response:
    """Answers a request for one of ASSETS."""
    name = request.path_params["name"]
    if name not in ASSETS:
        raise HTTPException(404)
    package, media_type = ASSETS[name]
    text = files(package).joinpath(f"page/{name}").read_text(encoding="utf-8")
    return Response(text, media_type=media_type, headers=HEADERS)


def _answer_thumbnail(request: Request) -> Response:
    """Answers a request for the small picture of a bundled game."""
    for picture in files("sjdsl.studio").joinpath("thumbnails").iterdir():
        if picture.name == request.path_params["name"]:
            return Response(picture.read_bytes(), media_type="image/png", headers=HEADERS)
    raise HTTPException(404)


def _make_file_handler(folder: Folder) -> Handler:
    """Returns what answers requests about files, in a thread, as a large folder takes a while."""

    async def answer(request: Request) -> Response:
        """Answers one request, whose body is read up to a limit."""
        body = b""
        async for part in request.stream():
            body += part
            if len(body) > 2 * LARGEST:
                return JSONResponse({"refused": "the text is too large"}, 413, HEADERS)
        status, content = await run_in_threadpool(
            answer_request, folder, request.method, request.url.path, request.query_params, body
        )
        return JSONResponse(content, status, HEADERS)

    return answer


def _make_bench_handler(spares: Spares) -> Callable[[WebSocket], Coroutine[Any, Any, None]]:
    """Returns what answers the requests of a socket to a bench, in a process of its own."""

    async def answer_socket(socket: WebSocket) -> None:
        """Answers the requests of a socket in order, by a worker process that ends with it."""
        await socket.accept()
        child = spares.take()
        waiting = asyncio.Queue[str](MAX_WAITING)

        async def listen() -> None:
            while True:
                await waiting.put(await socket.receive_text())

        async def answer() -> None:
            while True:
                await socket.send_text(await child.ask(await waiting.get()))

        tasks = [asyncio.create_task(listen()), asyncio.create_task(answer())]
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                task.result()
        except (WebSocketDisconnect, asyncio.CancelledError):
            pass
        except RuntimeError:  # the socket was closed while an answer was sent
            pass
        except KeyError:  # bytes in place of text
            await socket.close(UNREADABLE)
        finally:
            for task in tasks:
                task.cancel()
            with contextlib.suppress(ProcessLookupError):
                await child.stop()

    return answer_socket
