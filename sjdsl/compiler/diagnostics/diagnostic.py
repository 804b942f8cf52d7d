"""A diagnostic as data: what is wrong, where, and what to write instead. `errors` declares them all."""

from collections.abc import Iterable
from dataclasses import MISSING, Field, dataclass, field, fields
from operator import attrgetter
from string import Formatter
from typing import Any, ClassVar, Literal, dataclass_transform

from sjdsl.compiler.diagnostics.frozen import Frozen, Record
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
class Facts(Frozen):
    """A subclass declares its fields, and is a dataclass once there is one of it: in most processes nothing is wrong."""

    def __init__(self, span: Span, **given: Any) -> None:
        declared = _fields(type(self))
        facts = {name: f.default for name, f in declared.items()} | given | {"span": span}
        wrong = [name for name, value in facts.items() if name not in declared or value is MISSING]
        if wrong:
            raise TypeError(
                f"{type(self).__name__} lacks, or does not have, the facts {', '.join(wrong)}"
            )
        self.__dict__.update(facts)


def _fields(kind: type[Any]) -> dict[str, Field[Any]]:
    """Returns the fields of a kind of diagnostic, by name."""
    if "__dataclass_fields__" not in vars(kind):
        if kind.__base__ is not Facts:
            _fields(kind.__base__)  # type: ignore[arg-type]
        dataclass(init=False, eq=False, repr=False)(kind)
    return {f.name: f for f in fields(kind)}


class Diagnostic(Facts):
    """One mistake of one file. A subclass is one kind of mistake: a code, a message, and the facts it tells as fields.

    `says` and `hints` are templates over fields and properties: `{name}` is text, `{cells:cell}` is "1 cell" or "3 cells", a tuple of
    names is told as alternatives, floats have no needless digits. Of several hints the first is given that tells no empty fact; `help`, if
    given, goes before all. `instead` has for each hint the text that it proposes in place of the span, a template too, empty for none; of
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
        if code:
            cls.code, cls.title, cls.severity = code, title, severity

    @property
    def message(self) -> str:
        return "".join(self._parts(self.says))

    @property
    def hint(self) -> str:
        """The help line, empty if there is none."""
        return self.help or self._chosen()[0]

    def _chosen(self) -> tuple[str, str]:
        """Returns the hint that is given, and the template of what it proposes in place of the span."""
        for number, hint in enumerate(self.hints):
            parts = self._parts(hint)
            if all(parts):
                return "".join(parts), self.instead[number] if number < len(self.instead) else ""
        return "", ""

    @property
    def suggestions(self) -> tuple[Suggestion, ...]:
        """The changes that the message suggests, as edits."""
        instead = "" if self.help else self._chosen()[1]
        found = []
        if self.fix is not None:
            text = " ".join(self.fix.text.split())
            found.append(
                Suggestion(
                    f"write `{text}`" if text else "put a space" if self.fix.text else "delete it",
                    (self.fix,),
                )
            )
        found += [
            Suggestion(f"write `{proposed}`", (Fix(self.span, proposed),))
            for proposed in self._proposed(instead)
            if proposed
        ]
        return tuple(found)

    def _proposed(self, template: str) -> list[str]:
        """Returns a template as it is with each name of a tuple."""
        texts = [""]
        for text, fact, _, _ in Formatter().parse(template):
            value = "" if fact is None else attrgetter(fact)(self)
            values = value if isinstance(value, tuple) else (value,)
            texts = [f"{before}{text}{one}" for before in texts for one in values]
        return texts

    def _parts(self, template: str) -> list[str]:
        """Returns a template in parts: each of its texts, and each fact as it is shown."""
        parts = []
        for text, fact, noun, _ in Formatter().parse(template):
            parts += [text] if text else []
            if fact is not None:
                value = attrgetter(fact)(self)
                shown = (
                    either(value)
                    if isinstance(value, tuple)
                    else format(value, "g" if isinstance(value, float) else "")
                )
                parts.append(f"{shown} {noun}{'s' * (value != 1)}" if noun else shown)
        return parts


class AboutName(Diagnostic):
    """A mistake about one name."""

    name: str


class CompileError(Exception):
    """Carries every diagnostic of the phase that failed; `diagnostics` holds errors and warnings in file order."""

    def __init__(self, diagnostics: Iterable[Diagnostic]):
        self.diagnostics = tuple(
            sorted(diagnostics, key=lambda d: (d.span.file, d.span.start, d.code))
        )
        super().__init__(self.diagnostics)

    def __str__(self) -> str:
        """Returns each diagnostic in a line, with what to write instead below it."""
        lines = []
        for d in self.diagnostics:
            lines.append(
                f"{d.span.file}:{d.span.line}:{d.span.column}: {d.severity}[{d.code}]: {d.message}"
            )
            lines += [f"  help: {d.hint}"] if d.hint else []
        return "\n".join(lines)


class Near(Record):
    """What a name that is not known may have been meant for: the nearest known ones, and a statement that lists all."""

    nearest: tuple[str, ...] = ()
    listed: str = ""


def near(name: str, candidates: Iterable[str], what: str = "") -> Near:
    """Returns the candidates that are nearest to a name; all of them too, if `what` says what they are, in the plural: "the actions"."""
    known = list(dict.fromkeys(candidates))
    shown = ", ".join(f"`{k}`" for k in known[:MOST_LISTED])
    more = f" and {len(known) - MOST_LISTED} more" if len(known) > MOST_LISTED else ""
    return Near(nearest(name, known), f"{what} are {shown}{more}" if known and what else "")
