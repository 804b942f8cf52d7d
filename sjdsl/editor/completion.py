"""Completion: the words of the language that may follow, and the names of the sort that fits the place."""

import re
from collections.abc import Collection, Iterator, Sequence
from itertools import takewhile
from typing import NamedTuple

from lark import Token
from lsprotocol import types

from sjdsl.compiler import ast
from sjdsl.compiler.ast.names import AGENT, Names, Owners, Symbol
from sjdsl.compiler.diagnostics.limits import check_text
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.elaborate.constants import UNITS
from sjdsl.compiler.elaborate.lookup import (
    AGENT_ATTRIBUTES,
    CELL_ATTRIBUTES,
    MOVER_ATTRIBUTES,
    NOWHERE,
)
from sjdsl.compiler.elaborate.shapes import BUILT_IN as FORMS
from sjdsl.compiler.ir.operations import FUNCTIONS
from sjdsl.compiler.syntax.parse import automaton, parser
from sjdsl.compiler.syntax.recovery.automaton import Stack, accepted, levels, read
from sjdsl.compiler.syntax.recovery.repair import ENTRIES, SECTIONS, STATEMENTS
from sjdsl.compiler.syntax.soft_words import as_name
from sjdsl.compiler.syntax.tokens import scan
from sjdsl.editor.analysis import Analyses, Analysis
from sjdsl.editor.documents import Document
from sjdsl.runtime.actions import BUILT_IN, HEADINGS

Kind = types.CompletionItemKind
KINDS = {
    "keyword": Kind.Keyword, "local": Kind.Variable, "parameter": Kind.Constant, "size": Kind.Constant, "define": Kind.Function,
    "kind": Kind.Class, "group": Kind.Interface, "sort of movers": Kind.Class, "field of the world": Kind.Field, "field": Kind.Field,
    "action": Kind.EnumMember, "argument": Kind.Property, "shape": Kind.Struct, "phase": Kind.Method, "metric": Kind.Event,
    "policy": Kind.Function, "variant": Kind.Module, "word": Kind.EnumMember, "function": Kind.Function, "file": Kind.File,
    "scenario": Kind.Module, "checks": Kind.Module, "value": Kind.Value,
}  # fmt: skip
TRIGGERS = (".", "[", '"')
LONGEST = 80  # characters of a declaration shown beside a name
BEGINNING = (SECTIONS | ENTRIES | STATEMENTS) - {
    "WHERE"
}  # kinds of tokens that end what is unfinished before them
ABOUT_AGENTS = (
    "FORBID",
    "BLOCKS",
    "WINDOW",
    "SHOW",
    "HIDE",
    "POLICY",
)  # declarations in which `agent` has a name
QUOTED = re.compile(r'"(?:\\.|[^"\\\n])*"')
WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*$")
SHARED = (
    "kind",
    "group",
    "sort of movers",
    "parameter",
    "size",
    "define",
    "field of the world",
)  # the sorts of the shared name space
WHO = "agent kind group sort-of-movers"
SEEN = f"{WHO} other field-of-the-world marks content"
# What comes behind a token, or at a place that `_asked` calls so: sorts of names, and words that stand for themselves.
EXPECTED = {
    "CHOSE": "action free-local", "CHOOSE": "action free-local", "FORBID": "action", "SCHEDULE": "phase tick", "ARROW": "phase tick", "TALLY": "event",
    "ACTS": " ".join(BUILT_IN), "MOVES": "relative compass", "BLOCKS": "shape sort-of-movers", "MARK": "shape form", "AIM": "shape form",
    "IN": "shape form local", "ON": "kind group", "SEND": "local", "REMOVE": "local", "FOR": "local", "FACING": f"local same {' '.join(HEADINGS)}",
    "MONOTONE": "define", "WINDOW": "ahead behind left right", "SHOW": SEEN, "HIDE": SEEN,
    "DROP": "kind group sort-of-movers parameter size define field-of-the-world phase metric shape policy scenario checks variant",
    **dict.fromkeys(("EACH", "FIRST", "MATCH", "OVER", "SEEK", "AVOIDING", "TOWARD", "AT", "LOOK"), WHO), "who": WHO, "members": "kind group",
    "unit": " ".join(UNITS), "type": "agent cell reward fraction probability", "set of": "agent", "target": "local field-of-the-world",
    "change": "parameter size", "glyph": "field", "players": "policy random never", "slots": "policy random stay", "direction": "falling rising",
}  # fmt: skip


class Offer(NamedTuple):
    """A word to write here. `sort`: a key of KINDS; `rank`: offers of a lower one come first; `symbol`: what it names, if it is declared."""

    word: str
    sort: str
    rank: int = 5
    symbol: Symbol | None = None


def completion(
    uri: str, position: types.Position, analyses: Analyses
) -> list[types.CompletionItem]:
    """Returns what may be written at a position. Names are those of the text as it could be read last."""
    document, readable = analyses.documents.get(uri), analyses.readable(uri)
    if document is None:
        return []
    offset = document.lines.offset(position)
    before = document.text[:offset]
    open_ = QUOTED.sub("", before[before.rfind("\n") + 1 :])
    if "#" in open_.partition('"')[0]:
        return []
    written = open_.rpartition('"')[2] if '"' in open_ else "".join(WORD.findall(before))
    source = Source("", before[: offset - len(written)].removesuffix('"' if '"' in open_ else ""))
    tokens = [] if check_text(source) else scan(source, parser()).tokens
    if '"' in open_:
        offers = _files(tokens, document)
    else:
        kinds = following(tokens)
        words = automaton().words
        offers = [
            Offer(words[kind], "keyword") for kind in sorted(kinds) if words.get(kind, "").isalpha()
        ]
        offers += (
            fitting(tokens, kinds, Names() if readable is None else readable.names)
            if "NAME" in kinds
            else []
        )
    first: dict[str, Offer] = {}
    for offer in sorted(offers, key=lambda o: o.rank):
        first.setdefault(offer.word, offer)
    range_ = document.lines.range(offset - len(written), offset)
    return [
        types.CompletionItem(
            label=offer.word,
            kind=KINDS[offer.sort],
            detail=_detail(offer, readable) or None,
            sort_text=f"{offer.rank}{offer.word}",
            text_edit=types.TextEdit(range_, offer.word),
        )
        for offer in first.values()
    ]


def following(tokens: Sequence[Token]) -> Collection[str]:
    """Returns the kinds of tokens that may stand behind tokens, soft words by their own kind.

    What cannot be read is left out; a keyword or a `}` that cannot be read ends what is unfinished around it.
    """
    table = automaton()
    stack = Stack(table.start, None)
    for token in tokens:
        kind = as_name(table, stack, token).type
        after = read(table, stack, kind)
        if after is None and (kind in BEGINNING or kind == "RBRACE"):
            after = next(filter(None, (read(table, level, kind) for level in levels(stack))), None)
        stack = after or stack
    return accepted(table, stack)


def _files(tokens: Sequence[Token], document: Document) -> list[Offer]:
    """Returns the files that a text in quotes can name: games after `extends`, maps after `map`."""
    suffix = (
        {"EXTENDS": ".sj", "MAP": ".txt", "WRAPS": ".txt"}.get(tokens[-1].type) if tokens else None
    )
    top = document.folder
    if suffix is None or top is None or not top.is_dir():
        return []
    homes = [
        top.resolve(),
        *([] if document.path is None else [document.path.parent]),
    ]  # links that lead elsewhere are refused
    inside = [
        sub
        for sub in sorted(top.iterdir())
        if any(sub.resolve().is_relative_to(home) for home in homes)
    ]
    folders = [top, *(sub for sub in inside if sub.is_dir() and not sub.name.startswith("."))]
    files = [
        file
        for folder in folders
        for file in sorted(folder.glob(f"*{suffix}"))
        if file.resolve() != document.path
    ]
    return [Offer(file.relative_to(top).as_posix(), "file") for file in files[:200]]


def _detail(offer: Offer, analysis: Analysis | None) -> str:
    """Returns the declaration of a name on one line, of a function what it gives."""
    if offer.sort == "function":
        return "; ".join(f"{written}: {gives}" for written, gives in FUNCTIONS[offer.word].uses)
    node = (
        None if analysis is None or offer.symbol is None else analysis.names.nodes.get(offer.symbol)
    )
    text = (
        next(
            (source.text for source, _ in analysis.chain if node and source.name == node.span.file),
            "",
        )
        if analysis
        else ""
    )
    if node is None:
        return "" if offer.sort in ("keyword", "file") else offer.sort
    line = " ".join(text[node.span.start : node.span.end].split())
    return line if len(line) <= LONGEST else line[: LONGEST - 1] + "…"


# ---- names


def fitting(tokens: Sequence[Token], kinds: Collection[str], names: Names) -> Iterator[Offer]:
    """Yields the names that may stand behind tokens, where the grammar has a name. kinds: of the tokens that may stand there."""
    around = local_names(tokens, names)
    asked = _asked(tokens, kinds)
    if asked == "DOT":
        yield from _members(tokens, names, around)
    for sort in EXPECTED.get(asked, "").split():
        yield from _of(sort.replace("-", " "), names, around, 0)
    if "INT" not in kinds or (asked in EXPECTED and asked != "IN"):
        return
    words = _words_compared(tokens, names, around)
    yield from (Offer(word, "word", 0) for word in words)
    for sort in ("local", "parameter", "size", "define", "field of the world"):
        yield from _of(sort, names, around, 1)
    yield from () if words else _of("word", names, around, 4)
    section, check = (
        next((t.type for t in reversed(tokens) if t.type in group), "")
        for group in (SECTIONS, ENTRIES)
    )
    in_checks = section == "CHECKS"
    yield from _of("metric", names, around, 3) if in_checks else ()
    yield from (
        Offer(f.name, "function", 4)
        for f in FUNCTIONS.values()
        if not f.word and (not f.checks or (in_checks and check.lower() in f.checks))
    )
    yield from (
        Offer(word, "value", 4)
        for word in ("step", NOWHERE, *(HEADINGS if asked in ("IS", "NOT", "EQUAL") else ()))
    )


def _asked(tokens: Sequence[Token], kinds: Collection[str]) -> str:
    """Returns a key of EXPECTED, or the kind of the last token where a value or a new name stands."""
    at = len(tokens) - 1
    while (
        at >= 0 and tokens[-1].type == "COMMA" and tokens[at].type in ("NAME", "INT", "COMMA")
    ):  # a list: what stands before it asks
        at -= 1
    before = [token.type for token in reversed(tokens[: at + 1])] + 4 * [""]
    match last := before.pop(0):
        case "EQUAL" if before[1] == "GROUP":
            return "members"
        case "COLON" if "INT" not in kinds:
            return "unit"
        case "COLON" if "SET" in kinds:
            return "type"
        case "OF":
            return (
                "members"
                if tokens[at - 1] == "cell"
                else "set of"
                if before[0] == "SET"
                else "SEND"
            )
        case "WITH" if "STRING" not in kinds:
            return "players" if "SEEK" in kinds else "glyph" if before[0] == "STRING" else "who"
        case "POLICY" if "SLOTS" in [
            t.type
            for t in takewhile(lambda t: t.type not in ("LBRACE", "RBRACE"), reversed(tokens))
        ]:
            return "slots"
        case "SET":
            return "target" if "GIVE" in following(tokens[:-1]) else "change"
        case "TO":
            return (
                "who"
                if next((t.type for t in reversed(tokens) if t.type in STATEMENTS), "") == "SEND"
                else "target"
            )
        case "FROM" if before[0] == "AWAY":
            return "who"
        case "LPAR" if before[0] in ("COUNT", "ANY", "ALL"):
            return "who"
        case "INT" | "NAME" if before[0] == "PICK":
            return "who"
        case "NAME" if before[0] == "MONOTONE":
            return "direction"
        case "IN" if before[2] == "MONOTONE":
            return "MONOTONE"
        case _:
            return last


def _of(sort: str, names: Names, around: dict[str, Owners], rank: int) -> Iterator[Offer]:
    """Yields the names of a sort; a word that is no sort stands for itself."""
    match sort:
        case "local" | "free local":  # free: it may be an action
            yield from (
                Offer(name, "local", rank)
                for name, owners in around.items()
                if sort == "local" or owners is None
            )
        case "form":
            yield from (Offer(form, "shape", rank + 2) for form in FORMS)
        case "word":
            yield from (Offer(word, "word", rank) for word in sorted(names.words))
        case "event":
            yield from (
                offer
                for offer in _of("metric", names, around, rank)
                if offer.symbol and isinstance(names.nodes[offer.symbol], ast.Event)
            )
        case _ if sort in SHARED:
            yield from (
                Offer(s.name, sort, rank, s)
                for s in names.nodes
                if s.space == "name" and names.sort(s) == sort
            )
        case _ if sort in KINDS:
            hidden = ("start",) if sort == "phase" else ()
            yield from (
                Offer(s.name, sort, rank, s)
                for s in names.nodes
                if s.space == sort and s.name not in hidden
            )
        case _:
            yield Offer(sort, "value", rank)


def _members(tokens: Sequence[Token], names: Names, around: dict[str, Owners]) -> Iterator[Offer]:
    """Yields what may stand after a dot: fields, attributes, actions that have arguments, and behind one of these its arguments."""
    arguments = [s for s in names.nodes if s.space == "argument"]
    own = [
        s
        for s in arguments
        if [t.type for t in tokens[-3:]] == ["DOT", "NAME", "DOT"] and s.owner == tokens[-2]
    ]
    if own:
        yield from (Offer(s.name, "argument", 0, s) for s in own)
        return
    _, owners = _path(tokens[:-1], names, around)
    yield from (Offer(s.name, "field", 0, s) for s in names.fields(owners))
    if owners is None or "agent" in owners:
        yield from (Offer(s.owner, "action", 1, Symbol("action", s.owner)) for s in arguments)
    for owner in owners or ("agent",):
        is_mover = isinstance(names.nodes.get(Symbol("name", owner)), ast.Movers)
        attributes = (
            AGENT_ATTRIBUTES
            if owner == "agent"
            else MOVER_ATTRIBUTES
            if is_mover
            else CELL_ATTRIBUTES
        )
        yield from (Offer(attribute, "field", 1) for attribute in attributes)


def _words_compared(tokens: Sequence[Token], names: Names, around: dict[str, Owners]) -> list[str]:
    """Returns the words of the field that stands before `is`, `is not` or `=`."""
    if not tokens or tokens[-1].type not in ("IS", "NOT", "EQUAL"):
        return []
    fields, _ = _path(
        [t for t in tokens[:-1] if t.type != "IS"] if tokens[-1].type == "NOT" else tokens[:-1],
        names,
        around,
    )
    nodes = [names.nodes[field] for field in fields]
    return [
        w.text
        for node in nodes
        if isinstance(node, ast.Field) and isinstance(node.type, ast.Words)
        for w in node.type.names
    ]


def _path(
    tokens: Sequence[Token], names: Names, around: dict[str, Owners]
) -> tuple[list[Symbol], Owners]:
    """Returns the fields that the path at the end of tokens can be, and what its value can be, None if that is not known."""
    if tokens and tokens[-1].type == "RSQB":
        tokens = tokens[
            : max(at for at, token in enumerate(tokens) if token.type == "LSQB" or not at)
        ]
    if not tokens or tokens[-1].type != "NAME":
        return [], None
    name = str(tokens[-1])
    if [t.type for t in tokens[-2:-1]] == ["DOT"]:
        fields = [s for s in names.fields(_path(tokens[:-2], names, around)[1]) if s.name == name]
    elif name in around or names.owners(name) is not None:
        return [], around.get(name) or names.owners(name)
    else:
        world = Symbol("name", name)
        fields = (
            [world] if world in names.nodes else [s for s in names.fields(None) if s.name == name]
        )
    held = [names.held(field) for field in fields]
    return fields, frozenset[str]().union(*(h for h in held if h)) or None


def local_names(tokens: Sequence[Token], names: Names) -> dict[str, Owners]:
    """Returns the local names behind the tokens, each with what it can be: bound by `as`, `let`, `draw`, a domain or in a declaration's `()`."""
    blocks: list[dict[str, Owners]] = [{}]
    pending: dict[str, Owners] = {}  # of the statement that is being read: they hold in its block
    begun = ""
    for at, token in enumerate(tokens):
        before = tokens[at - 1].type if at else ""
        if (
            token.type in BEGINNING
            and before != "WITH"
            and not (token.type == "WHEN" and begun in ABOUT_AGENTS)
        ):
            begun, pending = token.type, {"agent": AGENT} if token.type in ABOUT_AGENTS else {}
        if token.type in ("LBRACE", "LPAR"):
            blocks.append({**blocks[-1], **pending})
            pending = {} if token.type == "LBRACE" else pending
            if [t.type for t in tokens[at - 2 : at]] in (["PHASE", "NAME"], ["DEFINE", "NAME"]):
                inside = takewhile(lambda t: t.type != "RPAR", tokens[at:])
                pending = {str(parameter): None for parameter in inside if parameter.type == "NAME"}
        elif token.type in ("RBRACE", "RPAR") and len(blocks) > 1:
            blocks.pop()
            pending = {} if token.type == "RBRACE" else pending
        elif token.type == "NAME" and before in ("LET", "DRAW"):
            blocks[-1][str(token)] = None
        elif token.type == "NAME" and before == "AS":
            pending[str(token)] = pending.pop(str(tokens[at - 2]), None)
        elif token.type == "NAME" and before != "DOT" and names.owners(str(token)):
            pending[str(token)] = names.owners(str(token))
    return {**blocks[-1], **pending}
