"""The analysis of one text: its tokens, its tree, its bases and its mistakes.

It is kept until the text or a file that it was read from changes.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

from lark import Token

from sjdsl.compiler import Build, ast, build, check_composition
from sjdsl.compiler.ast.names import Names, Occurrence, Symbol, names_of, occurrences
from sjdsl.compiler.compose import Composition, bases, compose
from sjdsl.compiler.diagnostics.diagnostic import CompileError, Diagnostic
from sjdsl.compiler.diagnostics.limits import check_text
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.compiler.syntax.parse import as_read, parse, parser
from sjdsl.compiler.syntax.tokens import scan
from sjdsl.editor.documents import Document, Documents

Stamp = tuple[object, ...]


class Checked(NamedTuple):
    """A game in a variant, None if it can't be composed, and its errors and warnings."""

    composition: Composition | None
    problems: tuple[Diagnostic, ...]


class Analysis:
    """One text with its bases and maps. Each part is computed when it is first needed."""

    def __init__(self, document: Document, documents: Documents):
        self.document = document
        self._documents = documents
        self._stamps: dict[Path, Stamp] = {}  # of the files that were read
        self._checked: dict[tuple[str, ...], Checked] = {}  # by the variants
        self.source = Source(
            document.name, document.text, document.folder, self._open_text, document.path
        )

    def _open_text(self, path: Path) -> str | None:
        """Returns the text of a file if it is open, else None; notes that the file was read."""
        self._stamps[path] = _stamp(path, self._documents)
        return self._documents.text_over(path)

    def depends_on(self, path: Path) -> bool:
        """Returns whether a file was read, or looked for."""
        return path in self._stamps

    def is_current(self) -> bool:
        """Returns whether the files that were read haven't changed."""
        return all(_stamp(path, self._documents) == stamp for path, stamp in self._stamps.items())

    @cached_property
    def tokens(self) -> tuple[Token, ...]:
        """The tokens of the text, even of one with mistakes; soft keywords may be names."""
        if check_text(self.source):
            return ()
        return tuple(as_read(scan(self.source, parser()).tokens))

    @cached_property
    def file(self) -> ast.File | None:
        """The tree of the text, None if it has syntax errors."""
        with suppress(CompileError):
            return parse(self.source)
        return None

    @cached_property
    def chain(self) -> tuple[tuple[Source, ast.File], ...]:
        """The text and its tree, then those of its base and so on, as far as they can be read."""
        files: list[tuple[Source, ast.File]] = []
        with suppress(CompileError):
            files.extend(bases(self.source))
        return tuple(files)

    @property
    def composition(self) -> Composition | None:
        """The game with its bases, None if they can't be composed."""
        return self._check(()).composition

    @cached_property
    def build(self) -> Build | None:
        """The compiled game without variants, None if it has errors."""
        with suppress(CompileError):
            return build(self.source)
        return None

    def problems(self, variants: tuple[str, ...] = ()) -> tuple[Diagnostic, ...]:
        """Returns every error and warning of the game with some variants."""
        return self._check(variants).problems

    def _check(self, variants: tuple[str, ...]) -> "Checked":
        """Returns the game with some variants, which is checked once."""
        if variants not in self._checked:
            try:
                composition = compose(self.source, variants)
                problems = check_composition(composition)
                self._checked[variants] = Checked(composition, problems)
            except CompileError as error:
                self._checked[variants] = Checked(None, error.diagnostics)
        return self._checked[variants]

    def all_problems(self) -> Iterator[tuple[tuple[str, ...], tuple[Diagnostic, ...]]]:
        """Yields the problems of the game without variants, then of each variant alone."""
        yield (), self.problems()
        if self.composition is not None:
            for name in self.composition.variants:
                yield (name,), self.problems((name,))

    @cached_property
    def names(self) -> Names:
        """What the game and its bases declare."""
        return names_of(file for _, file in self.chain)

    @cached_property
    def resolved(self) -> Mapping[Span, set[Symbol]]:
        """The symbols that the names of the text and of its bases refer to.

        A name may refer to several: in the game without variants and in each variant of the text.
        """
        choices: list[tuple[str, ...]] = [()]
        if self.file is not None:
            for section in self.file.game.sections:
                if isinstance(section, ast.Variant):
                    choices.append((section.name.text,))
        symbols = defaultdict[Span, set[Symbol]](set)
        for variants in choices:
            composition = self._check(variants).composition
            if composition is not None:
                for span, symbol in composition.references:
                    symbols[span].add(symbol)
        return symbols

    @cached_property
    def occurrences(self) -> list[Occurrence]:
        """The names of the text, each with the symbols that it refers to."""
        if self.file is None:
            return []
        return occurrences(self.file, self.names, self.resolved)


class Analyses:
    """The current analysis of each text, and the last one in which the text had no syntax error."""

    def __init__(self, documents: Documents):
        self.documents = documents
        self._current: dict[str, Analysis] = {}
        self._readable: dict[str, Analysis] = {}

    def of(self, uri: str) -> Analysis | None:
        """Returns the analysis of a text as it is now, None if there is no such text."""
        document = self.documents.get(uri)
        if document is None:
            self.forget(uri)
            return None
        analysis = self._current.get(uri)
        if analysis is None or analysis.document.text != document.text or not analysis.is_current():
            analysis = Analysis(document, self.documents)
            self._current[uri] = analysis
        analysis.document = document  # its version may be newer: something was typed and undone
        if analysis.file is not None:
            self._readable[uri] = analysis
        return analysis

    def readable(self, uri: str) -> Analysis | None:
        """Returns the last analysis in which a text had no syntax error, None if there is none."""
        self.of(uri)
        return self._readable.get(uri)

    def forget(self, uri: str) -> None:
        """Drops the analyses of a text that is closed."""
        self._current.pop(uri, None)
        self._readable.pop(uri, None)

    def depending_on(self, path: Path) -> list[str]:
        """Returns the URIs of the texts that read a file."""
        return [uri for uri, analysis in self._current.items() if analysis.depends_on(path)]


def _stamp(path: Path, documents: Documents) -> Stamp:
    """Returns what changes when a file does: its open text, or its time and size.

    It is empty for a file that doesn't exist.
    """
    text = documents.text_over(path)
    if text is not None:
        return ("open", text)
    try:
        status = path.stat()
    except (OSError, ValueError):
        return ()
    return (status.st_mtime_ns, status.st_size)
