"""`sjdsl lsp`: serves editors over the Language Server Protocol, on standard input and output."""

import gc
import os
import signal
import sys
from pathlib import Path

import click

from sjdsl.extras import require

# Objects between two garbage collections: a server lives long, and each text leaves some garbage.
COLLECTION_THRESHOLD = 50_000


@click.command("lsp")
@click.option(
    "--inside",
    "folders",
    multiple=True,
    metavar="DIR",
    help="Read no files outside this folder; may be repeated.",
)
def command(folders: tuple[str, ...]) -> int:
    """Starts the language server. Editors do this themselves: docs/editors.md says how. It needs
    the extra `sjdsl[editor]`.

    The exit status follows the protocol: 0, or 1 if the editor ends the session without a shutdown
    request.
    """
    require("editor", "pygls")
    from sjdsl.editor.server import make_server

    gc.set_threshold(COLLECTION_THRESHOLD, 20, 20)  # older objects less often than by default (10)
    # The server has no work to keep, and pygls would wait for the editor's next message.
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    server = make_server([Path(folder) for folder in folders] or None)
    # pygls closes the stream that it writes to, and standard output is needed after that.
    with os.fdopen(os.dup(sys.stdout.fileno()), "wb") as answers:
        server.start_io(stdout=answers)
    return int(server.ended_early)
