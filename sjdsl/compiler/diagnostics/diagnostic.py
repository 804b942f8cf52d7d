"""A diagnostic as data: what is wrong, where, and what to write instead; see `errors`."""

from collections.abc import Iterable
from dataclasses import field
from operator import attrgetter
from string import Formatter
from typing import Any, ClassVar, Literal, dataclass_transform

from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.near_names import either, nearest

Severity = Literal["error", "warning"]
MOST_LISTED = 20  # names in one help line


class Label(Record):
    """A secondary place, with what there is to say about it."""

    span: Span
    text: str


class Fix(Record):
    """An edit that would repair the mistake: replace the characters of `span` by `text`."""

    span: Span
    text: str


class Suggestion(Record):
    """A change that a message suggests: how it is named, and the edits it takes."""

    says: str
    edits: tuple[Fix, ...]


@dataclass_transform(frozen_default=True, kw_only_default=True, field_specifiers=(field,))
class Facts(Record):
    """A class of facts by name: a subclass declares its fields."""


class Diagnostic(Facts):
    """One mistake of one file. A subclass is one kind of mistake: code, message, and its facts.

    says, hints: templates over fields and properties. `{name}` is text, `{cells:cell}` is "1 cell"
      or "3 cells"; a tuple of names is written as alternatives, and a float without needless
      digits. The first hint is shown that has no empty fact; `help` replaces all.
    instead: for each hint a template of what it proposes in place of the span, empty for none; for
      a tuple of names each is proposed.
    A subclass of a subclass is another message of the same code.
    """

    code: ClassVar[str] = ""
    title: ClassVar[str] = ""
    severity: ClassVar[Severity] = "error"
    says: ClassVar[str]
    hints: ClassVar[tuple[str, ...]] = ()
    instead: ClassVar[tuple[str, ...]] = ()

    span: Span = field(kw_only=False)
    labels: tuple[Label, ...] = ()
    fix: Fix | None = None
    help: str = ""

    def __init_subclass__(
        cls, code: str = "", title: str = "", severity: Severity = "error"
    ) -> None:
        super().__init_subclass__()
        if code:
            cls.code = code
            cls.title = title
            cls.severity = severity

    @property
    def message(self) -> str:
        return "".join(self._parts(self.says))

    @property
    def hint(self) -> str:
        """The help line, empty if there is none."""
        if self.help:
            return self.help
        hint, _ = self._chosen_hint()
        return hint

    def _chosen_hint(self) -> tuple[str, str]:
        """Returns the hint that is shown, and the template of what it proposes."""
        for number, hint in enumerate(self.hints):
            parts = self._parts(hint)
            if all(parts):
                instead = self.instead[number] if number < len(self.instead) else ""
                return "".join(parts), instead
        return "", ""

    @property
    def suggestions(self) -> tuple[Suggestion, ...]:
        """The changes that the message suggests, as edits."""
        suggestions = []
        if self.fix is not None:
            suggestions.append(Suggestion(_fix_text(self.fix), (self.fix,)))
        if not self.help:
            _, instead = self._chosen_hint()
            for text in self._proposed(instead):
                if text:
                    suggestions.append(Suggestion(f"write `{text}`", (Fix(self.span, text),)))
        return tuple(suggestions)

    def _proposed(self, template: str) -> list[str]:
        """Returns the texts of a template, one for each name of a tuple."""
        texts = [""]
        for literal, fact, _, _ in Formatter().parse(template):
            value = "" if fact is None else attrgetter(fact)(self)
            values = value if isinstance(value, tuple) else (value,)
            texts = [f"{text}{literal}{one}" for text in texts for one in values]
        return texts

    def _parts(self, template: str) -> list[str]:
        """Returns a template in parts: each of its texts, and each fact as it is shown."""
        parts = []
        for literal, fact, noun, _ in Formatter().parse(template):
            if literal:
                parts.append(literal)
            if fact is not None:
                parts.append(_shown(attrgetter(fact)(self), noun or ""))
        return parts


def _shown(value: Any, noun: str) -> str:
    """Returns a fact as messages show it."""
    if isinstance(value, tuple):
        shown = either(value)
    else:
        shown = format(value, "g" if isinstance(value, float) else "")
    if not noun:
        return shown
    return f"{shown} {noun}" if value == 1 else f"{shown} {noun}s"


def _fix_text(fix: Fix) -> str:
    """Returns how an edit is named."""
    text = " ".join(fix.text.split())
    if text:
        return f"write `{text}`"
    return "put a space" if fix.text else "delete it"


class AboutName(Diagnostic):
    """A mistake about one name."""

    name: str


class CompileError(Exception):
    """Carries the errors and warnings of the phase that failed, as `diagnostics`, in file order."""

    def __init__(self, diagnostics: Iterable[Diagnostic]):
        self.diagnostics = tuple(
            sorted(diagnostics, key=lambda d: (d.span.file, d.span.start, d.code))
        )
        super().__init__(self.diagnostics)

    def __str__(self) -> str:
        """Returns each diagnostic in a line, with what to write instead below it."""
        lines = []
        for d in self.diagnostics:
            place = f"{d.span.file}:{d.span.line}:{d.span.column}"
            lines.append(f"{place}: {d.severity}[{d.code}]: {d.message}")
            if d.hint:
                lines.append(f"  help: {d.hint}")
        return "\n".join(lines)


class Near(Record):
    """The known names nearest to an unknown one, and a sentence that lists all known ones."""

    nearest: tuple[str, ...] = ()
    listed: str = ""


def near(name: str, candidates: Iterable[str], description: str = "") -> Near:
    """Returns the candidates that are nearest to a name.

    description: of the candidates, in the plural, "the actions"; with one they are listed too.
    """
    known = list(dict.fromkeys(candidates))
    listed = ""
    if known and description:
        listed = f"{description} are {', '.join(f'`{k}`' for k in known[:MOST_LISTED])}"
        if len(known) > MOST_LISTED:
            listed = f"{listed} and {len(known) - MOST_LISTED} more"
    return Near(nearest(name, known), listed)
