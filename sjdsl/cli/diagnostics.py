"""Prints diagnostics with the text they point to, in colour on a terminal."""

import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import click

from sjdsl.cli.pointer import remember
from sjdsl.compiler.diagnostics.diagnostic import CompileError, Diagnostic
from sjdsl.compiler.diagnostics.report import render
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.read import read_source


def print_diagnostics(
    found: Sequence[Diagnostic], sources: Mapping[str, Source] | None = None, err: bool = False
) -> None:
    """Prints diagnostics for people; texts that `sources` lacks are read from their files."""
    if not found:
        return

    remember((d.code for d in found), err)
    stream = sys.stderr if err else sys.stdout
    colour = stream.isatty() and not os.environ.get("NO_COLOR")
    click.echo(render(found, {**texts_of(found), **(sources or {})}, colour), err=err, color=colour)


def texts_of(found: Sequence[Diagnostic]) -> dict[str, Source]:
    """Returns the files that diagnostics point to, by name, as far as they can be read."""
    names = {d.span.file for d in found} | {label.span.file for d in found for label in d.labels}
    texts = {}
    for name in names:
        try:
            texts[name] = read_source(Path(name))
        except CompileError:
            continue  # that it cannot be read is what the diagnostic says
    return texts
