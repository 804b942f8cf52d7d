"""The studio without a server: the same requests and answers, for a page that runs Python itself (Pyodide)."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

from sjdsl.studio import files as requested
from sjdsl.studio import tour
from sjdsl.studio.bench import Bench
from sjdsl.studio.folder import Changed, FileRefused, Folder
from sjdsl.studio.worker import answered

Send = Callable[[str], object]


class Serverless:
    """What the page's server does, for one worker of the page. `folder`: of the games that somebody has saved, in the worker's memory.

    Whoever runs the worker ends it when something takes too long, and gives the next one the saved files by `keep`.
    """

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._folder = Folder(folder.resolve())
        self._bench = Bench(self._folder.root)
        self._language: Any = None

    def bench(self, request: str) -> str:
        """Returns the answer to a request of the board or of a panel, both as JSON."""
        return json.dumps(answered(self._bench, request))

    def prepare_language(self, send: Send) -> None:
        """Loads the language server and reads a first request, so that the page's own is answered soon. `send`: as for `language`."""
        from sjdsl.editor.server import make_server  # a bench needs none

        self._language = make_server()
        self._language.protocol.set_writer(_Writer(send), include_headers=False)
        self._language.protocol.structure_message({"jsonrpc": "2.0", "id": 0, "method": "initialize", "params": {"capabilities": {}}})

    def language(self, message: str, send: Send) -> None:
        """Gives the language server a message; what it says, now or later, is sent. Wants a running event loop."""
        if self._language is None:
            self.prepare_language(send)
        protocol = self._language.protocol
        protocol.handle_message(protocol.structure_message(json.loads(message)))

    def file(self, method: str, path: str, body: str = "") -> str:
        """Answers a request about files as the server does, as JSON; `written` has the files that are new, with their texts."""
        try:
            return json.dumps(self._file(method, urlsplit(path).path, parse_qs(urlsplit(path).query), json.loads(body or "{}")))
        except Changed as reason:
            return json.dumps({"refused": str(reason), "changed": True})
        except (FileRefused, KeyError, TypeError, ValueError) as reason:
            return json.dumps({"refused": str(reason)})

    def keep(self, path: str, text: str) -> None:
        """Writes a file as somebody has saved it before, or in another worker of the page. Raises FileRefused."""
        (self._folder.root / path).parent.mkdir(parents=True, exist_ok=True)
        try:
            before = self._folder.read(path)[1]
        except FileRefused:
            before = None
        self._folder.write(path, text, before)

    def _file(self, method: str, address: str, query: dict[str, list[str]], given: dict[str, Any]) -> dict[str, Any]:
        folder = self._folder
        match method, address:
            case "GET", "/games":
                return requested.listed(folder)
            case "GET", "/tour":
                return {"steps": tour.steps()}
            case "GET", "/policies":
                return {"policies": []}  # trained policies want JAX
            case "GET", "/file":
                return requested.read(folder, query["path"][0])
            case "PUT", "/file":
                return {**requested.write(folder, given), "written": {str(given["path"]): str(given["text"])}}
            case "POST", "/copy":
                done = requested.copy(folder, given)
                return {**done, "written": {name: folder.read(name)[0] for name in (*done["copied"], str(given["path"]))}}
            case _:
                raise FileRefused(f"there is no `{address}`")


class _Writer:
    """Sends what the language server writes."""

    def __init__(self, send: Send) -> None:
        self._send = send

    def write(self, data: bytes) -> None:
        self._send(data.decode("utf-8"))

    def close(self) -> None:
        """There is nothing to close."""
