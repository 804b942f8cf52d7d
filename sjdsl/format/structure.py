"""Reads from the syntax tree where lines may break, which tokens touch, and what is aligned."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Literal

from lark import Token, Tree

from sjdsl.compiler.diagnostics.limits import STATEMENTS

Content = Literal["block", "list", "rows", "texts"]
ENTRIES = frozenset(("entry", "arm", "relabel"))


@dataclass(frozen=True)
class Container:
    """Items that may have their own lines, such as statements of a block or rows of a picture.

    content: `block` of statements, `list` of entries, `rows` of a picture, `texts` of `about`.
    open: the token before the first item; items: the first token of each; close: the closing brace,
    None for texts.
    """

    content: Content
    open: int
    items: tuple[int, ...]
    close: int | None

    @property
    def end(self) -> int:
        """The last token that belongs to it."""
        return self.items[-1] if self.close is None else self.close

    def ranges(self) -> Iterator[tuple[int, int]]:
        """Yields the first and last token of each item; a comma belongs to the item before it."""
        for start, following in pairwise(self.items):
            yield start, following - 1
        if self.items:
            yield self.items[-1], self.end if self.close is None else self.close - 1


@dataclass
class Structure:
    """The structure of a text. Tokens are given by their index.

    game: the keyword `game`; containers: by the token that opens them; branches: each `otherwise`
    that begins one; tight: tokens without a space before them.
    columns: first token of a line -> (the rule whose lines share columns, the tokens with which
    columns begin).
    """

    game: int
    containers: dict[int, Container] = field(default_factory=dict)
    branches: set[int] = field(default_factory=set)
    tight: set[int] = field(default_factory=set)
    columns: dict[int, tuple[str, tuple[int, ...]]] = field(default_factory=dict)


def read_structure(tokens: Sequence[Token], tree: Tree[Token]) -> Structure:
    """Returns the structure of a text without syntax errors."""
    by_start = {token.start_pos: n for n, token in enumerate(tokens)}
    by_end = {token.end_pos: n for n, token in enumerate(tokens)}
    structure = Structure(next(n for n, token in enumerate(tokens) if token.type == "GAME"))
    for n, token in enumerate(tokens):
        if token.type in ("COMMA", "RPAR", "RSQB"):
            structure.tight.add(n)
        elif token.type in ("LPAR", "LSQB", "DOT"):
            structure.tight.add(n + 1)
    rules_at: dict[int, set[str]] = {}  # the nodes that begin with a token
    chained = {id(child) for node in tree.find_data("otherwise") for child in node.children}
    for node in tree.iter_subtrees():
        start = by_start[node.meta.start_pos]
        end = by_end[node.meta.end_pos]
        if id(node) not in chained:
            rules_at.setdefault(start, set()).add(node.data)
        _add_node(node.data, start, end, tokens, structure)
    _add_braces(tokens, rules_at, structure)
    return structure


def _add_node(
    rule: str, start: int, end: int, tokens: Sequence[Token], structure: Structure
) -> None:
    """Adds to a structure what follows from a node with the tokens `start .. end`."""
    tight = structure.tight
    columns = structure.columns
    match rule:
        case "otherwise":
            structure.branches.add(start)
        case "call" | "turn" | "count" | "total" | "extreme" | "action" if end > start:
            tight.add(start + 1)
        case "signed":
            tight.add(start + 1)
        case "names" | "index" | "member" | "observer":
            tight.add(start)
        case "key":
            tight.add(end + 1)
            if tokens[end].type == "DOTS":
                tight.add(end)
        case "about" if end > start + 2:
            texts = tuple(range(start + 2, end + 1))
            structure.containers[start + 1] = Container("texts", start + 1, texts, None)
        case "size" | "param" if tokens[start + 2].type == "COLON":  # not one with `by`
            columns[start] = ("number", (start + 1, start + 2, start + 4))
        case "kind" | "field":
            columns[start] = (rule, (start + 2,))
        case "define":
            columns[start] = (rule, (_find(tokens, start, end, "EQUAL"),))
        case "look":
            columns[start] = (rule, (_find(tokens, start, end, "AS", "WITH"),))
        case "entry":
            columns[start] = (rule, (_find(tokens, start, end, "COLON") + 1,))
        case _:
            pass


def _find(tokens: Sequence[Token], start: int, end: int, *types: str) -> int:
    """Returns the first of some tokens that has one of the types."""
    return next(n for n in range(start, end) if tokens[n].type in types)


def _add_braces(
    tokens: Sequence[Token], rules_at: dict[int, set[str]], structure: Structure
) -> None:
    """Adds the braces with items in them; braces around enum values or members have none."""
    open_brackets: list[tuple[int, Content | None, list[int]]] = []
    for number, token in enumerate(tokens):
        if open_brackets:
            _, content, items = open_brackets[-1]
            if _is_item(content, token, rules_at.get(number, set())):
                items.append(number)
        if token.type in ("LPAR", "LSQB"):
            open_brackets.append((number, None, []))
        elif token.type == "LBRACE":
            content = _content_of_braces(tokens[number + 1], rules_at.get(number + 1, set()))
            open_brackets.append((number, content, []))
        elif token.type in ("RBRACE", "RPAR", "RSQB"):
            opening, content, items = open_brackets.pop()
            if content is not None:
                structure.containers[opening] = Container(content, opening, tuple(items), number)


def _is_item(content: Content | None, token: Token, rules: set[str]) -> bool:
    """Returns whether a token begins an item of a container. `rules`: the nodes it begins."""
    match content:
        case "block":
            return bool(rules & STATEMENTS)
        case "list":
            return bool(rules & ENTRIES)
        case "rows":
            return token.type == "STRING"
        case _:
            return False


def _content_of_braces(first: Token, rules: set[str]) -> Content | None:
    """Returns what braces contain. `first`: the token inside; `rules`: the nodes it begins."""
    if first.type == "RBRACE" or rules & STATEMENTS:
        return "block"
    if first.type == "STRING":
        return "rows"
    return "list" if rules & ENTRIES else None
