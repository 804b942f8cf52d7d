"""Diagnostics as data: what is wrong, where, and what to write instead."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Literal

from sjdsl.compiler.diagnostics.source import Span
from sjdsl.near_names import nearest

Severity = Literal["error", "warning"]
MOST_LISTED = 20  # names in one help line


@dataclass(frozen=True)
class Code:
    """One kind of mistake. `message` and `hint` are templates over the facts of a diagnostic; of several hints the first that can be given is."""

    code: str
    title: str
    message: str
    hint: str | tuple[str, ...] = ""
    severity: Severity = "error"


@dataclass(frozen=True)
class Label:
    """A secondary place, with what there is to say about it."""

    span: Span
    text: str


@dataclass(frozen=True)
class Fix:
    """An edit that would repair the mistake: replace the characters of `span` by `text`."""

    span: Span
    text: str


@dataclass(frozen=True)
class Diagnostic:
    """One mistake of one file."""

    code: Code
    span: Span
    facts: Mapping[str, object] = field(default_factory=dict)
    labels: tuple[Label, ...] = ()
    fix: Fix | None = None

    @property
    def message(self) -> str:
        return self.code.message.format(**self.facts)

    @property
    def hint(self) -> str:
        """The help line: the first whose facts are all there (a near name, say); empty if there is none."""
        hints = (self.code.hint,) if isinstance(self.code.hint, str) else self.code.hint
        told = (hint for hint in hints if all(self.facts.get(name, "") != "" for name in _fields(hint)))
        return next(told, "").format(**self.facts)


def _fields(template: str) -> list[str]:
    import string

    return [name for _, name, _, _ in string.Formatter().parse(template) if name]


class CompileError(Exception):
    """Carries every diagnostic of the phase that failed; `diagnostics` holds errors and warnings in file order."""

    def __init__(self, diagnostics: Iterable[Diagnostic]):
        self.diagnostics = tuple(sorted(diagnostics, key=lambda d: (d.span.file, d.span.start, d.code.code)))
        super().__init__(self.diagnostics)

    def __str__(self) -> str:
        """Returns each diagnostic in a line, with what to write instead below it; made when it is shown, as some of that is tried first."""
        return "\n".join(map(_in_plain_text, self.diagnostics))


def _in_plain_text(d: Diagnostic) -> str:
    said = f"{d.span.file}:{d.span.line}:{d.span.column}: {d.code.severity}[{d.code.code}]: {d.message}"
    return f"{said}\n  help: {d.hint}" if d.hint else said


def near_or_all(name: str, candidates: Iterable[str], what: str) -> dict[str, str]:
    """Returns the facts of a message about a name that is none of the candidates: the `nearest` one, and all there are (`known`).

    `what`: what the candidates are, in the plural: "the actions".
    """
    known = list(dict.fromkeys(candidates))
    shown = ", ".join(f"`{k}`" for k in known[:MOST_LISTED])
    more = f" and {len(known) - MOST_LISTED} more" if len(known) > MOST_LISTED else ""
    return {"nearest": nearest(name, known), "known": f"{what} are {shown}{more}" if known else ""}
