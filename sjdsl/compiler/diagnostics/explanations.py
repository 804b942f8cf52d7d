"""The long explanation of an error code: its meaning, a wrong example, the repaired one, why."""

from pathlib import Path

from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import Diagnostic
from sjdsl.near_names import either, nearest

FOLDER = Path(__file__).parent / "explain"


def kinds() -> list[type[Diagnostic]]:
    """Returns every kind of mistake, in the order of the codes."""
    classes = {
        value
        for value in vars(errors).values()
        if isinstance(value, type) and issubclass(value, Diagnostic) and value.code
    }
    return sorted(classes, key=lambda kind: (kind.code, kind.__name__))


def all_codes() -> dict[str, type[Diagnostic]]:
    """Returns every code of the compiler with a kind of mistake that has it, in order."""
    return {kind.code: kind for kind in kinds()}


def explain(code: str) -> str:
    """Returns the text about a code such as `SJ204` or `204`. Raises ValueError for others."""
    known = all_codes()
    wanted = code.strip().upper()
    if wanted not in known:
        wanted = f"SJ{wanted.removeprefix('SJ').zfill(3)}"
    if wanted not in known:
        message = f"there is no code `{code[:20]}`"
        near = nearest(wanted, known)
        if near:
            message = f"{message}; did you mean {either(near)}?"
        raise ValueError(message)
    return (FOLDER / f"{wanted}.md").read_text("utf-8")
