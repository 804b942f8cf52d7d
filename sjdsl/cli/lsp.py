"""`sjdsl lsp`: serves editors over the Language Server Protocol, on standard input and output or on a port."""

import gc
import os
import sys

import click

from sjdsl.extras import require

HOST = "127.0.0.1"
MANY = 50_000  # objects between two garbage collections: a server lives long, and each text makes some


@click.command("lsp")
@click.option("--tcp", "port", type=click.IntRange(min=0, max=65535), metavar="PORT", help=f"Listen on this port of {HOST} instead.")
def command(port: int | None) -> int:
    """Starts the language server. Editors do this themselves: docs/editors.md says how. It needs the extra `sjdsl[editor]`.

    The exit status follows the protocol: 0, or 1 if the editor ends the session without a shutdown request.
    """
    require("editor", "pygls")
    from sjdsl.editor.server import make_server

    gc.set_threshold(MANY, 20, 20)
    server = make_server()
    if port is None:
        with os.fdopen(os.dup(sys.stdout.fileno()), "wb") as answers:  # pygls closes what it writes to, and our own is still needed
            server.start_io(stdout=answers)
    else:
        click.echo(f"listening on {HOST}:{port}", err=True)
        server.start_tcp(HOST, port)
    return int(server.ended_early)
