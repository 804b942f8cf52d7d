"""Passes messages of the Language Server Protocol between the page and the process `sjdsl lsp`."""

import asyncio
import contextlib
import os
import sys
from asyncio.subprocess import PIPE, Process
from pathlib import Path

from starlette.websockets import WebSocket, WebSocketDisconnect

from sjdsl.library.games_folder import games_folder
from sjdsl.studio.tour import tour_folder

HEADER = b"Content-Length: "
END = b"\r\n"
NICE = 5  # how far its priority is below that of the board, which has to answer first


async def serve_language(socket: WebSocket, folder: Path) -> None:
    """Starts a language server for a socket, and ends it with the socket.

    It reads what the studio may read: see SECURITY.md.
    """
    await socket.accept()
    readable = [f"--inside={path}" for path in (folder, games_folder(), tour_folder())]
    command = [sys.executable, "-m", "sjdsl", "lsp", *readable]
    process = await asyncio.create_subprocess_exec(*command, cwd=folder, stdin=PIPE, stdout=PIPE)
    answers = asyncio.create_task(_from_server(process, socket))
    try:
        while True:
            message = (await socket.receive_text()).encode("utf-8")
            assert process.stdin is not None
            process.stdin.write(HEADER + str(len(message)).encode() + END + END + message)
            await process.stdin.drain()
    except (WebSocketDisconnect, ConnectionError, asyncio.CancelledError):
        pass
    except KeyError:  # bytes in place of text
        pass
    finally:
        answers.cancel()
        with contextlib.suppress(ProcessLookupError):
            process.kill()
        await process.wait()


async def _from_server(process: Process, socket: WebSocket) -> None:
    """Sends each message of the language server to the socket, then closes the socket."""
    assert process.stdout is not None
    length = 0
    while line := await process.stdout.readline():
        if line.startswith(HEADER):
            length = int(line[len(HEADER) :])
        elif line == END and length:
            message = await process.stdout.readexactly(length)
            await socket.send_text(message.decode("utf-8"))
            length = 0
            _lower_priority(process)
    with contextlib.suppress(RuntimeError):
        await socket.close()


def _lower_priority(process: Process) -> None:
    """Lets the board go first where processors are scarce. The language server has started."""
    with contextlib.suppress(AttributeError, OSError):  # not every system has priorities
        priority = os.getpriority(os.PRIO_PROCESS, 0) + NICE
        if os.getpriority(os.PRIO_PROCESS, process.pid) < priority:
            os.setpriority(os.PRIO_PROCESS, process.pid, priority)
