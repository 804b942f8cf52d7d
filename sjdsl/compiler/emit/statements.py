"""Statements, functions and their comments as lines of Python text of at most 120 columns."""

import textwrap
from pathlib import PurePosixPath

from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.emit.escaping import remark
from sjdsl.compiler.emit.expressions import Bracketed, Chain, Piece, flat, pieces
from sjdsl.compiler.emit.layout import INDENT, WIDTH, layout
from sjdsl.compiler.program import Function
from sjdsl.compiler.program.expressions import Assign, Expression, Return, Statement


def function_lines(function: Function) -> list[str]:
    """Returns the lines of a function."""
    parameters = tuple(f"{name}: {type_}" for name, type_ in function.parameters)
    call = Chain((f"def {function.name}", Bracketed("(", parameters, ")")))
    head = layout(call, 0, 0, len(f" -> {function.returns}:"))
    lines = f"{head} -> {function.returns}:".split("\n") + _docstring(function.doc)
    last_comment = ""
    for statement in function.body:
        comment = origin(statement.origin)
        lines += statement_lines(statement, comment if comment != last_comment else "")
        last_comment = comment or last_comment
    return lines


def statement_lines(statement: Statement, comment: str = "", indent: int = INDENT) -> list[str]:
    """Returns the lines of a statement, with a comment."""
    match statement:
        case Assign(names=names, value=value):
            return assignment(f"{', '.join(names)} = ", pieces(value), comment, indent)
        case Return(values=(value,)):
            return assignment("return ", pieces(value), comment, indent)
        case Return(values=values):
            several = tuple(map(pieces, values))
            on_one_line = "return " + ", ".join(map(flat, several))
            if indent + len(on_one_line) <= WIDTH:
                return [" " * indent + on_one_line]
            return assignment("return ", Chain((Bracketed("(", several, ")"),)), "", indent)


def assignment(head: str, value: Piece, comment: str, indent: int = 0) -> list[str]:
    """Returns the lines of `head` and a value.

    The comment is behind the first line, or above it if there is no room.
    """
    spaces = " " * indent
    behind = f"  # {comment}" if comment else ""
    line = f"{spaces}{head}{flat(value)}{behind}"
    if len(line) <= WIDTH:
        return [line]
    first, *rest = (spaces + head + layout(value, indent + len(head), indent, 0)).split("\n")
    if len(first + behind) <= WIDTH:
        return [first + behind, *rest]
    return [*comment_lines(comment, indent), first, *rest]


def constant_lines(name: str, value: Expression, comment: str) -> list[str]:
    """Returns the lines of a module's constant."""
    return assignment(f"{name} = ", pieces(value), remark(comment))


def comment_lines(comment: str, indent: int = 0) -> list[str]:
    """Returns a comment on lines of its own."""
    start = " " * indent + "# "
    return textwrap.wrap(comment, WIDTH, initial_indent=start, subsequent_indent=start)


def origin(span: Span | None) -> str:
    """Returns where a statement comes from, such as `clean_up.sj:57`."""
    return "" if span is None else remark(f"{PurePosixPath(span.file).name}:{span.line}")


def _docstring(doc: str) -> list[str]:
    """Returns the lines of a docstring; what is too long for a line goes on farther in."""
    spaces = " " * INDENT
    lines = [remark(line.replace('"', "'")) for line in doc.splitlines() or [""]]
    if len(lines) == 1 and len(lines[0]) + INDENT + 6 <= WIDTH:
        return [f'{spaces}"""{lines[0]}"""']
    wrapped: list[str] = []
    for line in lines:
        inner = " " * (len(line) - len(line.lstrip()) + INDENT)
        wrapped += textwrap.wrap(line, WIDTH - INDENT - 3, subsequent_indent=inner) or [""]
    first, *rest = wrapped
    return [f'{spaces}"""{first}', *((spaces + line).rstrip() for line in rest), f'{spaces}"""']
