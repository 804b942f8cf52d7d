"""Prints an AST as stable text, for `dump` and goldens."""

from collections.abc import Iterator
from dataclasses import fields, is_dataclass

from sjdsl.compiler import ast
from sjdsl.compiler.diagnostics.source import Span


def lines(file: ast.File) -> Iterator[str]:
    """Yields the tree one node a line, children indented.

    Names and numbers stand on their node's line.
    """
    yield from _lines("file", file, 0)


def _lines(label: str, value: object, depth: int) -> Iterator[str]:
    """Yields the lines of a value: of a node its type, and its fields below it."""
    pad = "  " * depth
    if isinstance(value, ast.Name | ast.String):
        yield f"{pad}{label}: {value.text!r}"
    elif is_dataclass(value) and not isinstance(value, Span | type):
        yield f"{pad}{label}: {type(value).__name__}"
        for field in fields(value):
            if field.name != "span":
                yield from _lines(field.name, getattr(value, field.name), depth + 1)
    elif isinstance(value, tuple):
        for item in value:
            yield from _lines(label, item, depth)
    elif value is not None:
        yield f"{pad}{label}: {value!r}"
