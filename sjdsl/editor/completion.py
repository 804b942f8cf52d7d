"""Completion: the keywords that may follow, and the names of the category that fits."""

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
from sjdsl.compiler.syntax.recovery.repair import ENTRIES, SECTIONS, STATEMENTS
from sjdsl.compiler.syntax.soft_words import as_name
from sjdsl.compiler.syntax.tokens import scan
from sjdsl.editor.analysis import Analyses, Analysis
from sjdsl.editor.documents import Document
from sjdsl.runtime.actions import BUILT_IN, HEADINGS

Kind = types.CompletionItemKind
KINDS = {
    "keyword": Kind.Keyword, "local": Kind.Variable, "parameter": Kind.Constant,
    "size": Kind.Constant, "define": Kind.Function, "kind": Kind.Class, "group": Kind.Interface,
    "sort of movers": Kind.Class, "field of the world": Kind.Field, "field": Kind.Field,
    "action": Kind.EnumMember, "argument": Kind.Property, "shape": Kind.Struct,
    "phase": Kind.Method, "metric": Kind.Event, "policy": Kind.Function, "variant": Kind.Module,
    "word": Kind.EnumMember, "function": Kind.Function, "file": Kind.File,
    "scenario": Kind.Module, "checks": Kind.Module, "value": Kind.Value, "split": Kind.Module,
}  # fmt: skip
TRIGGERS = (".", "[", '"')
MAX_LENGTH = 80  # characters of a declaration that is shown beside a name
MAX_FILES = 200
# Tokens that begin a declaration or a statement: they end what is unfinished before them.
BEGINNING = (SECTIONS | ENTRIES | STATEMENTS) - {"WHERE"}
# Declarations in which `agent` is a name.
ABOUT_AGENTS = ("FORBID", "BLOCKS", "WINDOW", "SHOW", "HIDE", "POLICY")
SUFFIXES = {"EXTENDS": ".sj", "MAP": ".txt", "WRAPS": ".txt"}  # of the file after a keyword
QUOTED = re.compile(r'"(?:\\.|[^"\\\n])*"')
WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\Z")
# The categories of the shared name space.
SHARED = (
    "kind",
    "group",
    "sort of movers",
    "parameter",
    "size",
    "define",
    "field of the world",
)
WHO = "agent kind group sort-of-movers"
SEEN = f"{WHO} other field-of-the-world marks content"
# What may follow a token, or stand in a place with a name of `_place`: categories of names, and
# words that stand for themselves.
EXPECTED = {
    "ACTS": " ".join(BUILT_IN), "AIM": "shape form", "ARROW": "phase tick",
    "BLOCKS": "shape sort-of-movers", "CHOOSE": "action free-local", "CHOSE": "action free-local",
    "FACING": f"local same {' '.join(HEADINGS)}", "FOR": "local", "FORBID": "action",
    "HIDE": SEEN, "IN": "shape form local", "MARK": "shape form", "MONOTONE": "define",
    "MOVES": "relative compass", "ON": "kind group", "REMOVE": "local", "SCHEDULE": "phase tick",
    "SEND": "local", "SHOW": SEEN, "TALLY": "event", "WINDOW": "ahead behind left right",
    "DROP": "kind group sort-of-movers parameter size define field-of-the-world phase metric "
    "shape policy scenario checks variant",
    "EACH": WHO, "FIRST": WHO, "MATCH": WHO, "OVER": WHO, "SEEK": WHO, "AVOIDING": WHO,
    "TOWARD": WHO, "AT": WHO, "LOOK": WHO, "who": WHO,
    "change": "parameter size", "direction": "falling rising", "glyph": "field",
    "members": "kind group", "moment": "start", "players": "policy random never", "set of": "agent",
    "slots": "policy random stay", "target": "local field-of-the-world",
    "type": "agent cell reward fraction probability", "unit": " ".join(UNITS),
}  # fmt: skip


class Offer(NamedTuple):
    """A word that may be written.

    category: a key of KINDS; rank: offers of a lower one come first.
    symbol: what the word names, if it is declared.
    """

    word: str
    category: str
    rank: int = 5
    symbol: Symbol | None = None


def completion(
    uri: str, position: types.Position, analyses: Analyses
) -> list[types.CompletionItem]:
    """Returns what may be written at a position, with names of the last text that had no error."""
    document = analyses.documents.get(uri)
    readable = analyses.readable(uri)
    if document is None:
        return []
    offset = document.lines.offset(position)
    before = document.text[:offset]
    line = QUOTED.sub("", before[before.rfind("\n") + 1 :])
    is_comment = "#" in line.partition('"')[0]
    is_quoted = '"' in line
    if is_comment:
        return []
    if is_quoted:
        typed = line.rpartition('"')[2]
        source = Source("", before[: offset - len(typed) - 1])
    else:
        word = WORD.search(before)
        typed = "" if word is None else word[0]
        source = Source("", before[: offset - len(typed)])
    tokens = [] if check_text(source) else scan(source, parser()).tokens
    if is_quoted:
        offers = _file_offers(tokens, document)
    else:
        kinds = following(tokens)
        words = automaton().words
        offers = [
            Offer(words[kind], "keyword") for kind in sorted(kinds) if words.get(kind, "").isalpha()
        ]
        if "NAME" in kinds:
            offers += fitting(tokens, kinds, Names() if readable is None else readable.names)
    best: dict[str, Offer] = {}
    for offer in sorted(offers, key=lambda offer: offer.rank):
        best.setdefault(offer.word, offer)
    range_ = document.lines.range(offset - len(typed), offset)
    return [
        types.CompletionItem(
            label=offer.word,
            kind=KINDS[offer.category],
            detail=_detail(offer, readable) or None,
            sort_text=f"{offer.rank}{offer.word}",
            text_edit=types.TextEdit(range_, offer.word),
        )
        for offer in best.values()
    ]


def following(tokens: Sequence[Token]) -> Collection[str]:
    """Returns the kinds of tokens that may stand behind tokens, soft keywords by their own kind.

    A token that can't be read is left out; but a keyword that begins something, or a `}`, ends what
    is unfinished before it.
    """
    stack = automaton().stack()
    for token in tokens:
        kind = as_name(stack, token).type
        after = stack.read(kind)
        if after is None and (kind in BEGINNING or kind == "RBRACE"):
            for outer in stack.levels():
                after = after or outer.read(kind)
        stack = after or stack
    return stack.accepted()


def _file_offers(tokens: Sequence[Token], document: Document) -> list[Offer]:
    """Returns the files that may be named in quotes: games after `extends`, maps after `map`."""
    suffix = SUFFIXES.get(tokens[-1].type) if tokens else None
    top = document.folder
    if suffix is None or top is None or not top.is_dir():
        return []
    allowed = [top.resolve()]
    if document.path is not None:
        allowed.append(document.path.parent)
    folders = [top]
    for path in sorted(top.iterdir()):
        is_inside = any(path.resolve().is_relative_to(root) for root in allowed)  # links may leave
        if is_inside and path.is_dir() and not path.name.startswith("."):
            folders.append(path)
    offers: list[Offer] = []
    for folder in folders:
        for file in sorted(folder.glob(f"*{suffix}")):
            if file.resolve() != document.path:
                offers.append(Offer(file.relative_to(top).as_posix(), "file"))
    return offers[:MAX_FILES]


def _detail(offer: Offer, analysis: Analysis | None) -> str:
    """Returns the declaration of a name on one line; of a function, its uses."""
    if offer.category == "function":
        return "; ".join(f"{use}: {meaning}" for use, meaning in FUNCTIONS[offer.word].uses)
    node = None
    if analysis is not None and offer.symbol is not None:
        node = analysis.names.nodes.get(offer.symbol)
    if analysis is None or node is None:
        return "" if offer.category in ("keyword", "file") else offer.category
    text = next((source.text for source, _ in analysis.chain if source.name == node.span.file), "")
    line = " ".join(text[node.span.start : node.span.end].split())
    return line if len(line) <= MAX_LENGTH else line[: MAX_LENGTH - 1] + "…"


# ---- names


def fitting(tokens: Sequence[Token], kinds: Collection[str], names: Names) -> Iterator[Offer]:
    """Yields the names that may stand behind tokens, where the grammar has a name.

    Args:
      kinds: of the tokens that may stand there.
    """
    bound = local_names(tokens, names)
    place = _place(tokens, kinds)
    if place == "DOT":
        yield from _names_after_dot(tokens, names, bound)
    for category in EXPECTED.get(place, "").split():
        yield from _names_of(category.replace("-", " "), names, bound, 0)
    if "INT" not in kinds or (place in EXPECTED and place != "IN"):
        return
    # A value.
    compared = _values_compared(tokens, names, bound)
    for value in compared:
        yield Offer(value, "word", 0)
    for category in ("local", "parameter", "size", "define", "field of the world"):
        yield from _names_of(category, names, bound, 1)
    if not compared:
        yield from _names_of("word", names, bound, 4)
    in_checks = _last_kind(SECTIONS, tokens) == "CHECKS"
    if in_checks:
        yield from _names_of("metric", names, bound, 3)
    check = _last_kind(ENTRIES, tokens).lower()
    for function in FUNCTIONS.values():
        if not function.word and (not function.checks or (in_checks and check in function.checks)):
            yield Offer(function.name, "function", 4)
    headings = HEADINGS if place in ("IS", "NOT", "EQUAL") else ()
    for value in ("step", NOWHERE, *headings):
        yield Offer(value, "value", 4)


def _last_kind(kinds: Collection[str], tokens: Sequence[Token]) -> str:
    """Returns the one of some kinds that the last token with any of them has; "" without one."""
    return next((token.type for token in reversed(tokens) if token.type in kinds), "")


def _place(tokens: Sequence[Token], kinds: Collection[str]) -> str:
    """Returns a key of EXPECTED, or the kind of the last token if a value or a new name follows.

    In a list, what stands before the list decides.
    """
    end = len(tokens)
    if tokens and tokens[-1].type == "COMMA":
        while end and tokens[end - 1].type in ("NAME", "INT", "COMMA"):
            end -= 1
    kinds_before = ["", "", "", "", *(token.type for token in tokens[:end])]
    third, second, previous, last = kinds_before[-4:]
    match last:
        case "EQUAL" if second == "GROUP":
            return "members"
        case "COLON" if "INT" not in kinds:
            return "unit"
        case "COLON" if "SET" in kinds:
            return "type"
        case "OF" if tokens[end - 2] == "cell":
            return "members"
        case "OF":
            return "set of" if previous == "SET" else "SEND"
        case "WITH" if "STRING" not in kinds:
            if "SEEK" in kinds:
                return "players"
            return "glyph" if previous == "STRING" else "who"
        case "AT" if second == "PHASE":
            return "moment"
        case "POLICY" if _is_in_slots(tokens):
            return "slots"
        case "SET":
            return "target" if "GIVE" in following(tokens[:-1]) else "change"
        case "TO":
            return "who" if _last_kind(STATEMENTS, tokens) == "SEND" else "target"
        case "EVENT" if previous == "SHOW":
            return "TALLY"
        case "FROM" if previous == "AWAY":
            return "who"
        case "LPAR" if previous in ("COUNT", "ANY", "ALL"):
            return "who"
        case "INT" | "NAME" if previous == "PICK":
            return "who"
        case "NAME" if previous == "MONOTONE":
            return "direction"
        case "IN" if third == "MONOTONE":
            return "MONOTONE"
        case _:
            return last


def _is_in_slots(tokens: Sequence[Token]) -> bool:
    """Returns whether `slots` stands before the last token, with no brace between."""
    back = takewhile(lambda token: token.type not in ("LBRACE", "RBRACE"), reversed(tokens))
    return any(token.type == "SLOTS" for token in back)


def _names_of(category: str, names: Names, bound: dict[str, Owners], rank: int) -> Iterator[Offer]:
    """Yields the names of a category; any other word stands for itself."""
    match category:
        case "local":
            for name in bound:
                yield Offer(name, "local", rank)
        case "free local":  # it may be an action
            for name, owners in bound.items():
                if owners is None:
                    yield Offer(name, "local", rank)
        case "form":
            for form in FORMS:
                yield Offer(form, "shape", rank + 2)
        case "word":
            for word in sorted(names.words):
                yield Offer(word, "word", rank)
        case "event":
            for symbol, node in names.nodes.items():
                if symbol.space == "metric" and isinstance(node, ast.Event):
                    yield Offer(symbol.name, "metric", rank, symbol)
        case _ if category in SHARED:
            for symbol in names.nodes:
                if symbol.space == "name" and names.sort(symbol) == category:
                    yield Offer(symbol.name, category, rank, symbol)
        case _ if category in KINDS:
            for symbol, node in names.nodes.items():
                begins = isinstance(node, ast.Phase) and (symbol.name == "start" or node.at)
                if symbol.space == category and not begins:
                    yield Offer(symbol.name, category, rank, symbol)
        case _:
            yield Offer(category, "value", rank)


def _names_after_dot(
    tokens: Sequence[Token], names: Names, bound: dict[str, Owners]
) -> Iterator[Offer]:
    """Yields what may stand after a dot.

    That is an argument behind an action, else a field, an attribute or an action with arguments.
    """
    arguments = [symbol for symbol in names.nodes if symbol.space == "argument"]
    if [token.type for token in tokens[-3:]] == ["DOT", "NAME", "DOT"]:
        of_action = [symbol for symbol in arguments if symbol.owner == tokens[-2]]
        if of_action:
            for symbol in of_action:
                yield Offer(symbol.name, "argument", 0, symbol)
            return
    _, owners = _resolve_path(tokens[:-1], names, bound)
    for symbol in names.fields(owners):
        yield Offer(symbol.name, "field", 0, symbol)
    if owners is None or "agent" in owners:
        for symbol in arguments:
            yield Offer(symbol.owner, "action", 1, Symbol("action", symbol.owner))
    for owner in owners or ("agent",):
        attributes: tuple[str, ...] = CELL_ATTRIBUTES
        if owner == "agent":
            attributes = AGENT_ATTRIBUTES
        elif isinstance(names.nodes.get(Symbol("name", owner)), ast.Movers):
            attributes = MOVER_ATTRIBUTES
        for attribute in attributes:
            yield Offer(attribute, "field", 1)


def _values_compared(tokens: Sequence[Token], names: Names, bound: dict[str, Owners]) -> list[str]:
    """Returns the enum values of the field that stands before `is`, `is not` or `=`."""
    if not tokens or tokens[-1].type not in ("IS", "NOT", "EQUAL"):
        return []
    path = tokens[:-1]
    if tokens[-1].type == "NOT":
        path = [token for token in path if token.type != "IS"]
    fields, _ = _resolve_path(path, names, bound)
    values: list[str] = []
    for field in fields:
        node = names.nodes[field]
        if isinstance(node, ast.Field) and isinstance(node.type, ast.Words):
            values += [name.text for name in node.type.names]
    return values


def _resolve_path(
    tokens: Sequence[Token], names: Names, bound: dict[str, Owners]
) -> tuple[list[Symbol], Owners]:
    """Returns the fields that the path at the end of tokens may be, and the owners it may hold.

    The owners are None if they aren't known.
    """
    if tokens and tokens[-1].type == "RSQB":
        opening = [index for index, token in enumerate(tokens) if token.type == "LSQB"]
        tokens = tokens[: opening[-1] if opening else 0]
    if not tokens or tokens[-1].type != "NAME":
        return [], None
    name = str(tokens[-1])
    owners = names.owners(name)
    if len(tokens) > 1 and tokens[-2].type == "DOT":
        _, holders = _resolve_path(tokens[:-2], names, bound)
        fields = [symbol for symbol in names.fields(holders) if symbol.name == name]
    elif name in bound or owners is not None:
        return [], bound.get(name) or owners
    elif Symbol("name", name) in names.nodes:
        fields = [Symbol("name", name)]
    else:
        fields = [symbol for symbol in names.fields(None) if symbol.name == name]
    held: set[str] = set()
    for field in fields:
        held.update(names.held(field) or ())
    return fields, frozenset(held) or None


def local_names(tokens: Sequence[Token], names: Names) -> dict[str, Owners]:
    """Returns the local names that are bound behind the tokens, each with its possible owners.

    They are bound by `as`, `let`, `draw`, a domain, or in the parentheses of a declaration.
    """
    blocks: list[dict[str, Owners]] = [{}]
    pending: dict[str, Owners] = {}  # of the statement that is being read: they hold in its block
    begun = ""
    for index, token in enumerate(tokens):
        previous = tokens[index - 1].type if index else ""
        is_condition = token.type == "WHEN" and begun in ABOUT_AGENTS
        if token.type in BEGINNING and previous != "WITH" and not is_condition:
            begun = token.type
            pending = {"agent": AGENT} if begun in ABOUT_AGENTS else {}
        match token.type:
            case "LBRACE":
                blocks.append({**blocks[-1], **pending})
                pending = {}
            case "LPAR":
                blocks.append({**blocks[-1], **pending})
                declaring = [t.type for t in tokens[max(0, index - 2) : index]]
                if declaring in (["PHASE", "NAME"], ["DEFINE", "NAME"]):
                    in_brackets = takewhile(lambda t: t.type != "RPAR", tokens[index:])
                    pending = {str(t): None for t in in_brackets if t.type == "NAME"}
            case "RBRACE" if len(blocks) > 1:
                blocks.pop()
                pending = {}
            case "RPAR" if len(blocks) > 1:
                blocks.pop()
            case "NAME" if previous in ("LET", "DRAW"):
                blocks[-1][str(token)] = None
            case "NAME" if previous == "AS":
                pending[str(token)] = pending.pop(str(tokens[index - 2]), None)
            case "NAME" if previous != "DOT" and names.owners(str(token)):
                pending[str(token)] = names.owners(str(token))
    return {**blocks[-1], **pending}
