"""The studio without a server, for a page that runs Python itself (Pyodide)."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

from sjdsl.studio import files
from sjdsl.studio.bench import Bench
from sjdsl.studio.folder import FileRefused, Folder
from sjdsl.studio.worker import answer_line

Send = Callable[[str], object]


class Serverless:
    """The server's part, for one worker of the page.

    The page ends a worker that takes too long, and passes the saved files to the next by `keep`.
    folder: of the saved games, in the worker's memory.
    """

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._folder = Folder(folder.resolve())
        self._bench = Bench(self._folder.root)
        self._language: Any = None

    def bench(self, request: str) -> str:
        """Returns the answer to a request of the board or of a panel, both as JSON."""
        return json.dumps(answer_line(self._bench, request))

    def prepare_language(self, send: Send) -> None:
        """Loads the language server, and what it needs to read a request, ahead of the first one.

        Args:
          send: takes each message of the language server.
        """
        from sjdsl.editor.server import make_server  # here because a bench doesn't need it

        self._language = make_server()
        self._language.protocol.set_writer(_Writer(send), include_headers=False)
        self._language.protocol.structure_message(
            {"jsonrpc": "2.0", "id": 0, "method": "initialize", "params": {"capabilities": {}}}
        )

    def language(self, message: str, send: Send) -> None:
        """Passes a message to the language server, inside a running event loop.

        Args:
          send: takes each message of the language server, now or later.
        """
        if self._language is None:
            self.prepare_language(send)
        protocol = self._language.protocol
        protocol.handle_message(protocol.structure_message(json.loads(message)))

    def file(self, method: str, path: str, body: str = "") -> str:
        """Returns the server's answer to a request about files, as JSON.

        After a change, `written` has the texts of the new files.
        """
        url = urlsplit(path)
        query = {name: values[0] for name, values in parse_qs(url.query).items()}
        status, answer = files.answer_request(self._folder, method, url.path, query, body)
        if method != "GET" and status == 200:
            names = (*answer.get("copied", ()), json.loads(body)["path"])
            answer["written"] = {name: self._folder.read(name).text for name in names}
        return json.dumps(answer)

    def keep(self, path: str, text: str) -> None:
        """Writes a file that was saved before or in another worker. Raises FileRefused."""
        (self._folder.root / path).parent.mkdir(parents=True, exist_ok=True)
        try:
            before = self._folder.read(path).digest
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
