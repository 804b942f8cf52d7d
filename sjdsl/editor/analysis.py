"""What is known of one text: its words, its tree, the games it stands on, its mistakes. Kept until a text or a file changes."""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from contextlib import suppress
from functools import cached_property
from pathlib import Path

from lark import Token

from sjdsl.compiler import Build, ast, build, check_composition
from sjdsl.compiler.ast.names import Names, Occurrence, Symbol, names_of, occurrences
from sjdsl.compiler.compose import Composition, chain, compose
from sjdsl.compiler.diagnostics.diagnostic import CompileError, Diagnostic
from sjdsl.compiler.diagnostics.limits import check_text
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.compiler.elaborate import Overrides, elaborate
from sjdsl.compiler.syntax.parse import as_read, parse, parser
from sjdsl.compiler.syntax.tokens import scan
from sjdsl.editor.documents import Document, Documents

Stamp = tuple[object, ...]


class Analysis:
    """One text at one state of the files that it names: its bases and maps. Everything is found out when it is first asked for."""

    def __init__(self, document: Document, documents: Documents):
        self.document = document
        self._documents = documents
        self._seen: dict[Path, Stamp] = {}
        self._variants: dict[tuple[str, ...], tuple[Diagnostic, ...]] = {}
        self.source = Source(
            document.name, document.text, document.folder, self._over, document.path
        )

    def _over(self, path: Path) -> str | None:
        self._seen[path] = _stamp(path, self._documents)
        return self._documents.text_over(path)

    def depends_on(self, path: Path) -> bool:
        """Returns whether a file was read, or missed, for what is known."""
        return path in self._seen

    def is_current(self) -> bool:
        """Returns whether the files that were read are as they were."""
        return all(_stamp(path, self._documents) == stamp for path, stamp in self._seen.items())

    @cached_property
    def tokens(self) -> tuple[Token, ...]:
        """The words and signs of the text, also of one with mistakes; soft words that are names are tokens of names."""
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
        """The text and the games that it extends, as far as they can be read: its own tree, then that of its base, and so on."""
        read: list[tuple[Source, ast.File]] = []
        with suppress(CompileError):
            read.extend(chain(self.source))
        return tuple(read)

    @cached_property
    def composition(self) -> Composition | None:
        """The game put together, None if that fails."""
        with suppress(CompileError):
            return compose(self.source)
        return None

    @cached_property
    def build(self) -> Build | None:
        """The typed game as it is without variants, None if it has errors."""
        with suppress(CompileError):
            return build(self.source)
        return None

    def problems(self, variants: tuple[str, ...] = ()) -> tuple[Diagnostic, ...]:
        """Returns every error and warning of the game in a variant."""
        if variants not in self._variants:
            try:
                self._variants[variants] = check_composition(compose(self.source, variants))
            except CompileError as error:
                self._variants[variants] = error.diagnostics
        return self._variants[variants]

    def all_problems(self) -> Iterator[tuple[tuple[str, ...], tuple[Diagnostic, ...]]]:
        """Yields the problems of the game as it is, then of each variant alone."""
        for variants in (
            (),
            *((name,) for name in (() if self.composition is None else self.composition.variants)),
        ):
            yield variants, self.problems(variants)

    @cached_property
    def names(self) -> Names:
        """What the game declares, with its bases."""
        return names_of(file for _, file in self.chain)

    @cached_property
    def resolved(self) -> Mapping[Span, set[Symbol]]:
        """What elaboration found names to stand for, of the text and of its bases, in the game as it is and in the variants of the text."""
        own = (
            ()
            if self.file is None
            else tuple(s.name.text for s in self.file.game.sections if isinstance(s, ast.Variant))
        )
        found = defaultdict[Span, set[Symbol]](set)
        for variants in ((), *((name,) for name in own)):
            with suppress(CompileError):
                composition = compose(self.source, variants)
                elaborate(composition, Overrides(), Problems())
                for span, symbol in composition.references:
                    found[span].add(symbol)
        return found

    @cached_property
    def occurrences(self) -> list[Occurrence]:
        """The names of the text, each with what it stands for."""
        return [] if self.file is None else occurrences(self.file, self.names, self.resolved)


class Analyses:
    """The analysis of each text, made anew when the text or a file it stands on has changed, and the last one without syntax errors."""

    def __init__(self, documents: Documents):
        self.documents = documents
        self._made: dict[str, Analysis] = {}
        self._readable: dict[str, Analysis] = {}

    def of(self, uri: str) -> Analysis | None:
        """Returns what is known of a text, None if there is no such text."""
        document = self.documents.get(uri)
        if document is None:
            self.forget(uri)
            return None
        made = self._made.get(uri)
        if made is None or made.document.text != document.text or not made.is_current():
            made = self._made[uri] = Analysis(document, self.documents)
        elif made.document.version != document.version:  # typed and taken back
            made.document = document
        if made.file is not None:
            self._readable[uri] = made
        return made

    def readable(self, uri: str) -> Analysis | None:
        """Returns what is known of a text when it had no syntax error last, perhaps now; None if it always had one."""
        self.of(uri)
        return self._readable.get(uri)

    def forget(self, uri: str) -> None:
        """Drops what is known of a text that is closed."""
        self._made.pop(uri, None)
        self._readable.pop(uri, None)

    def standing_on(self, path: Path) -> list[str]:
        """Returns the URIs of the texts that read a file."""
        return [uri for uri, made in self._made.items() if made.depends_on(path)]


def _stamp(path: Path, documents: Documents) -> Stamp:
    """Returns what changes when a file does: its open text, or its time and size; empty for a file that is not there."""
    text = documents.text_over(path)
    if text is not None:
        return ("open", text)
    try:
        status = path.stat()
    except (OSError, ValueError):
        return ()
    return (status.st_mtime_ns, status.st_size)
