"""What the compiler refuses in a text."""

from sjdsl.compiler import build
from sjdsl.compiler.diagnostics.diagnostic import CompileError, Diagnostic
from sjdsl.compiler.diagnostics.source import Source


def errors_in(text: str) -> list[Diagnostic]:
    """Returns the errors of a game, in the order of its text; none if it is accepted."""
    try:
        build(Source("game.sj", text))
    except CompileError as error:
        return [d for d in error.diagnostics if d.severity == "error"]
    return []


def codes_in(text: str) -> set[str]:
    """Returns the codes of the errors of a game."""
    return {d.code for d in errors_in(text)}
