"""Prints diagnostics with the text they point to, in colour on a terminal."""

import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import click

from sjdsl.cli.pointer import add_codes
from sjdsl.compiler.diagnostics.diagnostic import CompileError, Diagnostic
from sjdsl.compiler.diagnostics.report import render
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.read import read_source


def print_diagnostics(
    diagnostics: Sequence[Diagnostic],
    sources: Mapping[str, Source] | None = None,
    err: bool = False,
) -> None:
    """Prints diagnostics for people, to standard error if `err`.

    sources: the texts that they point to, by name; what it lacks is read from the files.
    """
    if not diagnostics:
        return
    add_codes((diagnostic.code for diagnostic in diagnostics), err)
    stream = sys.stderr if err else sys.stdout
    colour = stream.isatty() and not os.environ.get("NO_COLOR")
    texts = {**texts_of(diagnostics), **(sources or {})}
    width = None
    if stream.isatty():
        width = os.get_terminal_size(stream.fileno()).columns or None  # some terminals say 0
    click.echo(render(diagnostics, texts, colour, width), err=err, color=colour)


def texts_of(diagnostics: Sequence[Diagnostic]) -> dict[str, Source]:
    """Returns the files that diagnostics point to, by name, as far as they can be read."""
    names = {diagnostic.span.file for diagnostic in diagnostics}
    for diagnostic in diagnostics:
        names |= {label.span.file for label in diagnostic.labels}
    texts = {}
    for name in names:
        try:
            texts[name] = read_source(Path(name))
        except CompileError:
            continue  # the diagnostic itself says that the file cannot be read
    return texts
