"""Collects the diagnostics of a stage, each once; `Poisoned` skips what can't be built."""

from collections.abc import Callable, Hashable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Protocol, TypeVar

from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import Diagnostic, Fix, near
from sjdsl.compiler.diagnostics.slips import slip
from sjdsl.compiler.diagnostics.source import Span

K = TypeVar("K", bound=Hashable)
S = TypeVar("S")
T = TypeVar("T")


class Named(Protocol):
    """A name in a text: what it is, and where it stands."""

    @property
    def text(self) -> str: ...

    @property
    def span(self) -> Span: ...


class Poisoned(Exception):
    """An expression or statement could not be built; the reason has been reported."""


@dataclass
class Problems:
    """Collects diagnostics, by `add`, each mistake once.

    suppressed: kinds of diagnostic that are not recorded.
    _messages: of the diagnostics recorded, by kind and place.
    """

    diagnostics: list[Diagnostic] = field(default_factory=list)
    suppressed: tuple[type[Diagnostic], ...] = ()
    _messages: dict[tuple[type[Diagnostic], Span], set[str]] = field(
        default_factory=dict, repr=False
    )

    @property
    def failed(self) -> bool:
        """Whether there are errors, and not only warnings."""
        return any(d.severity == "error" for d in self.diagnostics)

    def add(self, diagnostic: Diagnostic) -> None:
        """Records one diagnostic."""
        if isinstance(diagnostic, self.suppressed):
            return
        messages = self._messages.setdefault((type(diagnostic), diagnostic.span), set())
        if diagnostic.message not in messages:
            messages.add(diagnostic.message)
            self.diagnostics.append(diagnostic)

    def fail(self, diagnostic: Diagnostic) -> Poisoned:
        """Records one diagnostic and returns what to raise: `raise problems.fail(...)`."""
        self.add(diagnostic)
        return Poisoned()

    def unknown(
        self, name: Named, candidates: Iterable[str], description: str, help_: str = ""
    ) -> Poisoned:
        """Records that a name is none of the candidates.

        description: of the candidates, in the plural: "the actions".
        """
        known = list(candidates)
        hint, word = slip(name.text, known)
        return self.fail(
            errors.UnknownName(
                name.span,
                name=name.text,
                help=help_ or hint,
                fix=Fix(name.span, word) if word else None,
                near=near(name.text, known, description),
            )
        )

    @contextmanager
    def skip_if_broken(self, broken: set[K] | None = None, key: K | None = None) -> Iterator[None]:
        """Skips the rest of the block, without an error, once something in it could not be built.

        The key of what was to be built joins `broken`, so that uses of it are not reported too.
        """
        try:
            yield
        except Poisoned:
            if broken is not None and key is not None:
                broken.add(key)

    def each(self, parts: Iterable[S], build: Callable[[S], T]) -> list[T]:
        """Returns what is built of each part, without those that could not be built."""
        built: list[T] = []
        for part in parts:
            with self.skip_if_broken():
                built.append(build(part))
        return built
