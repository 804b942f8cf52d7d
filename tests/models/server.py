"""A server of chat completions on this machine, with faults by script."""

import json
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

Reply = Callable[[dict[str, Any]], str]


@dataclass
class Server:
    """What it was asked, and how it answers.

    faults: of the first requests, in order: a status, `cut` (half a body), `slow`, `empty` (no
    choices), `ok`, or fields of the completion. reply: the text for a request. model: what it calls its model.
    """

    reply: Reply
    faults: list[int | str | dict[str, Any]] = field(default_factory=list)
    model: str = "luna-2026"
    requests: list[dict[str, Any]] = field(default_factory=list)
    keys: list[str] = field(default_factory=list)
    headers: list[str] = field(default_factory=list)  # names and values of all requests
    elsewhere: str = ""  # where a 307 leads
    url: str = ""


def completion(server: Server, body: dict[str, Any]) -> dict[str, Any]:
    said = {"role": "assistant", "content": server.reply(body), "reasoning_content": "thinking"}
    return {
        "id": "1",
        "object": "chat.completion",
        "created": 0,
        "model": server.model,
        "choices": [{"index": 0, "message": said, "finish_reason": "stop"}],
        "usage": {
            "prompt_tokens": 100,
            "completion_tokens": 10,
            "total_tokens": 110,
            "prompt_tokens_details": {"cached_tokens": 60},
        },
    }


@contextmanager
def serving(server: Server) -> Iterator[Server]:
    """Answers until the block ends."""

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            body = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
            server.requests.append(body)
            server.headers.extend(f"{name}: {value}" for name, value in self.headers.items())
            server.keys.append(self.headers["Authorization"].removeprefix("Bearer "))
            fault = server.faults.pop(0) if server.faults else "ok"
            status = fault if isinstance(fault, int) else 200
            content: dict[str, Any] = completion(server, body)
            if status != 200:
                # As servers do, it says what it was sent.
                content = {"error": {"message": f"no: {self.headers['Authorization']}"}}
            elif fault == "empty":
                content = {"object": "error"}
            elif isinstance(fault, dict):
                content |= fault
            data = json.dumps(content).encode()
            if fault == "slow":
                time.sleep(0.6)
            self.send_response(status)
            self.send_header("Content-Type", "application/json")
            self.send_header("Content-Length", str(len(data)))
            self.send_header("retry-after-ms", "1")
            if status == 307:
                self.send_header("Location", server.elsewhere)
            self.end_headers()
            self.wfile.write(data[: len(data) // 2] if fault == "cut" else data)
            if fault == "cut":
                self.close_connection = True

        def log_message(self, *_: Any) -> None:
            pass

    http = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    http.daemon_threads = True
    server.url = f"http://127.0.0.1:{http.server_address[1]}/v1"
    threading.Thread(target=http.serve_forever, daemon=True).start()
    try:
        yield server
    finally:
        http.shutdown()
        http.server_close()
