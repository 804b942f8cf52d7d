"""`sjdsl lsp`: serves editors over the Language Server Protocol, on standard input and output."""

import gc
import os
import signal
import sys
from pathlib import Path

import click

from sjdsl.extras import require

MANY = (
    50_000  # objects between two garbage collections: a server lives long, and each text makes some
)


@click.command("lsp")
@click.option(
    "--inside",
    multiple=True,
    metavar="DIR",
    help="Read no files outside this folder; may be repeated.",
)
def command(inside: tuple[str, ...]) -> int:
    """Starts the language server. Editors do this themselves: docs/editors.md says how. It needs the extra `sjdsl[editor]`.

    The exit status follows the protocol: 0, or 1 if the editor ends the session without a shutdown request.
    """
    require("editor", "pygls")
    from sjdsl.editor.server import make_server

    gc.set_threshold(MANY, 20, 20)
    signal.signal(
        signal.SIGTERM, signal.SIG_DFL
    )  # it has no work to keep, and pygls would wait for the editor's next message
    server = make_server([*map(Path, inside)] or None)
    with os.fdopen(
        os.dup(sys.stdout.fileno()), "wb"
    ) as answers:  # pygls closes what it writes to, and our own is still needed
        server.start_io(stdout=answers)
    return int(server.ended_early)
