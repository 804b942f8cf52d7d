"""Reads off the syntax tree where a line may break, which tokens touch, and what can be aligned."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Literal

from lark import Token, Tree

from sjdsl.compiler.diagnostics.limits import STATEMENTS

Sort = Literal["block", "list", "rows", "texts"]
ENTRIES = frozenset(("entry", "arm", "relabel"))


@dataclass(frozen=True)
class Container:
    """Items that may stand on lines of their own: statements of a block, entries of a list, rows of a picture, texts of `about`.

    open: the token before the first item. items: the first token of each. close: the closing brace; texts have none.
    """

    sort: Sort
    open: int
    items: tuple[int, ...]
    close: int | None

    @property
    def end(self) -> int:
        """The last token that belongs to it."""
        return self.items[-1] if self.close is None else self.close

    def ranges(self) -> Iterator[tuple[int, int]]:
        """Yields the first and last token of each item; a comma belongs to the item before it."""
        ends = (*(start - 1 for start in self.items[1:]), self.end - (self.close is not None))
        yield from zip(self.items, ends, strict=True) if self.items else ()


@dataclass
class Structure:
    """Numbers are those of tokens. game: the word `game`.

    containers: by the token that opens them. branches: `otherwise` that begins a branch. tight: no space before these.
    columns: first token of a line -> (what it shares columns with, tokens before which columns begin).
    """

    game: int
    containers: dict[int, Container] = field(default_factory=dict)
    branches: set[int] = field(default_factory=set)
    tight: set[int] = field(default_factory=set)
    columns: dict[int, tuple[str, tuple[int, ...]]] = field(default_factory=dict)


def read_structure(tokens: Sequence[Token], tree: Tree[Token]) -> Structure:
    """Returns the structure of a text without syntax errors."""
    number = {token.start_pos: n for n, token in enumerate(tokens)}
    last = {token.end_pos: n for n, token in enumerate(tokens)}
    found = Structure(next(n for n, token in enumerate(tokens) if token.type == "GAME"))
    # tokens that stand close to the one before wherever they are
    found.tight |= {n for n, token in enumerate(tokens) if token.type in ("COMMA", "RPAR", "RSQB")}
    found.tight |= {
        n + 1 for n, token in enumerate(tokens) if token.type in ("LPAR", "LSQB", "DOT")
    }
    starts: dict[int, set[str]] = {}
    chained = {id(child) for node in tree.find_data("otherwise") for child in node.children}
    for node in tree.iter_subtrees():
        start, end = number[node.meta.start_pos], last[node.meta.end_pos]
        if id(node) not in chained:
            starts.setdefault(start, set()).add(node.data)
        _note(node.data, start, end, tokens, found)
    _find_containers(tokens, starts, found)
    return found


def _note(rule: str, start: int, end: int, tokens: Sequence[Token], found: Structure) -> None:
    """Notes what one node says of its tokens `start .. end`."""
    match rule:
        case "otherwise":
            found.branches.add(start)
        case "call" | "turn" | "count" | "total" | "extreme" | "action" if end > start:
            found.tight.add(start + 1)
        case "signed":
            found.tight.add(start + 1)
        case "names" | "index" | "member":
            found.tight.add(start)
        case "key":
            found.tight |= {end + 1, end} if tokens[end].type == "DOTS" else {end + 1}
        case "about" if end > start + 2:
            found.containers[start + 1] = Container(
                "texts", start + 1, tuple(range(start + 2, end + 1)), None
            )
        case "size" | "param" if tokens[start + 2].type == "COLON":  # not one with `by`
            found.columns[start] = ("number", (start + 1, start + 2, start + 4))
        case "kind" | "field":
            found.columns[start] = (rule, (start + 2,))
        case "define" | "look" | "entry":
            signs = {"define": ("EQUAL",), "look": ("AS", "WITH"), "entry": ("COLON",)}[rule]
            sign = next(n for n in range(start, end) if tokens[n].type in signs)
            found.columns[start] = (rule, (sign + (rule == "entry"),))
        case _:
            pass


def _find_containers(
    tokens: Sequence[Token], starts: dict[int, set[str]], found: Structure
) -> None:
    """Adds the braces with items in them; braces around words or members have none."""
    around: list[tuple[int, Sort | None, list[int]]] = []
    for number, token in enumerate(tokens):
        if around:
            _, sort, items = around[-1]
            wanted = (
                STATEMENTS if sort == "block" else ENTRIES if sort == "list" else frozenset[str]()
            )
            if wanted & starts.get(number, set()) or (sort == "rows" and token.type == "STRING"):
                items.append(number)
        if token.type in ("LBRACE", "LPAR", "LSQB"):
            rules, inside = starts.get(number + 1, set()), tokens[number + 1].type
            sort = "list" if rules & ENTRIES else None
            sort = (
                "block"
                if inside == "RBRACE" or rules & STATEMENTS
                else "rows"
                if inside == "STRING"
                else sort
            )
            around.append((number, sort if token.type == "LBRACE" else None, []))
        elif token.type in ("RBRACE", "RPAR", "RSQB"):
            open_, sort, items = around.pop()
            if sort is not None:
                found.containers[open_] = Container(sort, open_, tuple(items), number)
