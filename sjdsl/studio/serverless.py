"""The studio without a server: the same requests and answers, for a page that runs Python itself (Pyodide)."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

from sjdsl.studio import files
from sjdsl.studio.bench import Bench
from sjdsl.studio.folder import FileRefused, Folder
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
        self._language.protocol.structure_message(
            {"jsonrpc": "2.0", "id": 0, "method": "initialize", "params": {"capabilities": {}}}
        )

    def language(self, message: str, send: Send) -> None:
        """Gives the language server a message; what it says, now or later, is sent. Wants a running event loop."""
        if self._language is None:
            self.prepare_language(send)
        protocol = self._language.protocol
        protocol.handle_message(protocol.structure_message(json.loads(message)))

    def file(self, method: str, path: str, body: str = "") -> str:
        """Answers a request about files as the server does, as JSON; `written` has the files that are new, with their texts."""
        at = urlsplit(path)
        query = {name: values[0] for name, values in parse_qs(at.query).items()}
        status, found = files.answered(self._folder, method, at.path, query, body)
        if method != "GET" and status == 200:
            names = (*found.get("copied", ()), json.loads(body)["path"])
            found["written"] = {name: self._folder.read(name)[0] for name in names}
        return json.dumps(found)

    def keep(self, path: str, text: str) -> None:
        """Writes a file as somebody has saved it before, or in another worker of the page. Raises FileRefused."""
        (self._folder.root / path).parent.mkdir(parents=True, exist_ok=True)
        try:
            before = self._folder.read(path)[1]
        except FileRefused:
            before = None
        self._folder.write(path, text, before)


class _Writer:
    """Sends what the language server writes."""

    def __init__(self, send: Send) -> None:
        self._send = send

    def write(self, data: bytes) -> None:
        self._send(data.decode("utf-8"))

    def close(self) -> None:
        """There is nothing to close."""
