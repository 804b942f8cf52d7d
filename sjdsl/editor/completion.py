"""Completion: the words of the language that may follow, and the names of the kind that fits the place."""

from collections.abc import Collection, Iterable
from pathlib import Path
from typing import NamedTuple

from lsprotocol import types

from sjdsl.compiler import ast
from sjdsl.compiler.ast.names import Names, Symbol
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.ir.operations import FUNCTIONS
from sjdsl.compiler.syntax.parse import automaton
from sjdsl.editor.analysis import Analyses
from sjdsl.editor.fitting import fitting
from sjdsl.editor.local_names import declared_in, joined, local_names
from sjdsl.editor.place import Place, place_at
from sjdsl.editor.snippets import SNIPPETS

Kind = types.CompletionItemKind
KINDS = {
    "keyword": Kind.Keyword, "snippet": Kind.Snippet, "local": Kind.Variable, "parameter": Kind.Constant, "size": Kind.Constant,
    "define": Kind.Function, "kind": Kind.Class, "group": Kind.Interface, "sort of movers": Kind.Class, "field of the world": Kind.Field,
    "field": Kind.Field, "attribute": Kind.Property, "action": Kind.EnumMember, "argument": Kind.Property, "shape": Kind.Struct,
    "form": Kind.Struct, "phase": Kind.Method, "metric": Kind.Event, "policy": Kind.Function, "variant": Kind.Module, "word": Kind.EnumMember,
    "unit": Kind.Unit, "function": Kind.Function, "value": Kind.Value, "file": Kind.File, "scenario": Kind.Module, "checks": Kind.Module,
}  # fmt: skip
TRIGGERS = (".", "[", '"')
LONGEST = 80  # characters of a declaration shown beside a name


class Offer(NamedTuple):
    """A word to write here. `sort`: a key of KINDS; `rank`: offers of a lower one come first."""

    word: str
    sort: str
    rank: int = 5


def completion(uri: str, position: types.Position, analyses: Analyses, snippets: bool = False) -> list[types.CompletionItem]:
    """Returns what may be written at a position. `snippets`: whether the client knows texts with gaps to fill in."""
    document = analyses.documents.get(uri)
    if document is None:
        return []
    offset = document.lines.offset(position)
    place = place_at(document.text, offset)
    range_ = document.lines.range(place.start, offset)
    if place.inside:
        return [_item(Offer(name, "file"), range_, "") for name in _files(place, document.path)] if place.inside == "text" else []
    names = known_names(uri, analyses)
    offers = [Offer(word, "keyword") for word in sorted(keywords(place))]
    if "NAME" in place.following:
        offers += [Offer(*found) for found in fitting(place, names, local_names(place.tokens, names))]
    items = [_item(offer, range_, _declared(offer, names, analyses, uri)) for offer in _each_once(offers)]
    return items + ([_snippet(word, range_) for word in sorted(keywords(place) & SNIPPETS.keys())] if snippets else [])


def keywords(place: Place) -> set[str]:
    """Returns the words of the language that the grammar allows at a place."""
    words = automaton().words
    return {words[kind] for kind in place.following if words.get(kind, "").isalpha()}


def known_names(uri: str, analyses: Analyses) -> Names:
    """Returns what a text declares, as it could be read last and as it is now."""
    analysis, readable = analyses.of(uri), analyses.readable(uri)
    now = Names() if analysis is None else declared_in(analysis.tokens, analysis.document.name)
    return now if readable is None else joined(readable.names, now)


def _each_once(offers: Iterable[Offer]) -> Collection[Offer]:
    first: dict[str, Offer] = {}
    for offer in sorted(offers, key=lambda o: o.rank):
        first.setdefault(offer.word, offer)
    return first.values()


def _item(offer: Offer, range_: types.Range, declared: str) -> types.CompletionItem:
    return types.CompletionItem(
        label=offer.word,
        kind=KINDS[offer.sort],
        detail=declared or None,
        sort_text=f"{offer.rank}{offer.word}",
        text_edit=types.TextEdit(range_, offer.word),
    )


def _snippet(word: str, range_: types.Range) -> types.CompletionItem:
    return types.CompletionItem(
        label=f"{word} …",
        kind=Kind.Snippet,
        filter_text=word,
        sort_text=f"6{word}",
        insert_text_format=types.InsertTextFormat.Snippet,
        text_edit=types.TextEdit(range_, SNIPPETS[word]),
    )


def _declared(offer: Offer, names: Names, analyses: Analyses, uri: str) -> str:
    """Returns the declaration of a name on one line, of a function what it gives."""
    if offer.sort == "function":
        return "; ".join(f"{written}: {gives}" for written, gives in FUNCTIONS[offer.word].uses)
    spaces = {"parameter": "name", "size": "name", "define": "name", "kind": "name", "group": "name", "phase": "phase", "shape": "shape"}
    node = names.nodes.get(Symbol(spaces.get(offer.sort, "local"), offer.word))  # type: ignore[arg-type]
    analysis = analyses.of(uri) if isinstance(node, ast.Name) else analyses.readable(uri)
    if analysis is None or node is None:
        return "" if offer.sort in ("keyword", "file") else offer.sort
    span: Span = node.span
    text = next((source.text for source, _ in analysis.chain if source.name == span.file), analysis.document.text)
    start, end = (text.rfind("\n", 0, span.start) + 1, text.find("\n", span.end)) if isinstance(node, ast.Name) else (span.start, span.end)
    line = " ".join(text[start : end if end >= 0 else len(text)].partition("  #")[0].split())
    return line if len(line) <= LONGEST else line[: LONGEST - 1] + "…"


def _files(place: Place, path: Path | None) -> list[str]:
    """Returns the files that a text in quotes can name: games after `extends`, maps after `map`."""
    suffix = {"EXTENDS": ".sj", "MAP": ".txt", "WRAPS": ".txt"}.get(place.last())
    if suffix is None or path is None:
        return []
    folders = [path.parent, *(sub for sub in sorted(path.parent.iterdir()) if sub.is_dir() and not sub.name.startswith("."))]
    found = [file.relative_to(path.parent).as_posix() for folder in folders for file in sorted(folder.glob(f"*{suffix}")) if file != path]
    return found[:200]
