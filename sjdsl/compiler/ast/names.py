"""The names that games declare: what there is by name, and where a name stands."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

from sjdsl.compiler import ast
from sjdsl.compiler.ast.node import Node
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.diagnostics.tree import children, walk

Space = Literal[
    "game", "name", "word", "field", "action", "argument", "shape", "phase", "metric", "variant", "policy", "scenario", "checks", "split", "local"
]  # fmt: skip
Owners = (
    frozenset[str] | None
)  # what a value can be, as far as dots are concerned: `agent`, kinds, sorts of movers; None: not known
AGENT: Owners = frozenset({"agent"})
SPACES: dict[type[Node], Space] = {
    ast.Game: "game", ast.Constant: "name", ast.Kind: "name", ast.Group: "name", ast.Movers: "name", ast.Define: "name", ast.Field: "name",
    ast.Timer: "name", ast.Action: "action", ast.Argument: "argument", ast.Shape: "shape", ast.Phase: "phase", ast.Event: "metric",
    ast.Measure: "metric", ast.Variant: "variant", ast.ScriptedPolicy: "policy", ast.Scenario: "scenario", ast.Checks: "checks",
    ast.HoldOut: "split",
}  # fmt: skip
AROUND = (
    ast.File,
    ast.Game,
    ast.Variant,
    ast.Kind,
    ast.Movers,
    ast.Agents,
    ast.Acts,
    ast.Action,
    ast.Metrics,
)  # what declarations stand in
SORTS: dict[type[Node], str] = {
    ast.Kind: "kind", ast.Group: "group", ast.Movers: "sort of movers", ast.Define: "define", ast.Field: "field of the world",
    ast.Timer: "field of the world",
}  # fmt: skip


class Symbol(NamedTuple):
    """One thing with a name.

    `owner`: of a field or an argument, whose; of a local name, where it is bound (`file:offset`).
    """

    space: Space
    name: str
    owner: str = ""


class Occurrence(Record):
    """A name at one place.

    `symbols`: several for a field of a group, which each of its kinds declares.
    """

    span: Span
    symbols: tuple[Symbol, ...]
    declares: bool = False


def field_symbol(name: str, owner: str) -> Symbol:
    """Returns a field of the agents, a kind or movers; of the world if it has no owner."""
    return Symbol("field" if owner else "name", name, owner)


def local_symbol(name: ast.Name) -> Symbol:
    """Returns what a name stands for that a statement, a domain or a parameter introduces."""
    return Symbol("local", name.text, f"{name.span.file}:{name.span.start}")


def declared_by(node: Node, owner: str) -> Symbol | None:
    """Returns what a node declares itself.

    `owner`: what the node belongs to, as `owner_in` tells.
    """
    space = SPACES.get(type(node))
    name = getattr(node, "name", None)
    if space is None or name is None:
        return None
    if isinstance(node, ast.Field | ast.Timer):
        return field_symbol(name.text, owner)
    return Symbol(space, name.text, owner if isinstance(node, ast.Argument) else "")


def owner_in(node: Node, owner: str) -> str:
    """Returns whose the fields and arguments in a node are."""
    match node:
        case ast.Kind() | ast.Movers() | ast.Action():
            return node.name.text
        case ast.Agents():
            return "agent"
        case _:
            return owner


def declarations(node: Node, owner: str = "") -> Iterator[tuple[Symbol, Node]]:
    """Yields what a node and the nodes in it declare, without local names and words."""
    symbol = declared_by(node, owner)
    if symbol is not None:
        yield symbol, node
    if isinstance(node, AROUND):
        for child in children(node):
            yield from declarations(child, owner_in(node, owner))


@dataclass
class Names:
    """What games declare: `nodes` by symbol, and the `words` of fields."""

    nodes: dict[Symbol, Node] = field(default_factory=dict)
    words: set[str] = field(default_factory=set)

    def knows(self, symbol: Symbol) -> bool:
        """Returns whether the games declare something, and not the language."""
        return (
            symbol in self.nodes
            or symbol.space == "local"
            or (symbol.space == "word" and symbol.name in self.words)
        )

    def called(self, name: str, spaces: Iterable[Space]) -> set[Symbol]:
        """Returns what has a name in some of the name spaces, of whomever it is."""
        word = {Symbol("word", name)} if name in self.words and "word" in spaces else set()
        return word | {
            symbol for symbol in self.nodes if symbol.name == name and symbol.space in spaces
        }

    def sort(self, symbol: Symbol) -> str:
        """Returns what something of the shared name space is, as messages call it."""
        node = self.nodes[symbol]
        if isinstance(node, ast.Constant):
            return "size" if node.is_size else "parameter"
        return SORTS[type(node)]

    def owners(self, name: str) -> Owners:
        """Returns what members of a domain are: of `agent`, a kind, a group, a sort of movers."""
        if name in ("agent", "other", "everyone"):
            return AGENT
        match self.nodes.get(Symbol("name", name)):
            case ast.Kind() | ast.Movers():
                return frozenset({name})
            case ast.Group(kinds=kinds):
                return frozenset(kind.text for kind in kinds)
            case _:
                return None

    def fields(self, owners: Owners) -> list[Symbol]:
        """Returns the fields that can follow a dot: of any owner, if it is not known."""
        return [
            symbol
            for symbol in self.nodes
            if symbol.space == "field" and (owners is None or symbol.owner in owners)
        ]

    def held(self, symbol: Symbol) -> Owners:
        """Returns what a field holds, as far as dots are concerned."""
        match self.nodes.get(symbol):
            case ast.Field(type=ast.NamedType(name=ast.Name(text="agent"))):
                return AGENT
            case ast.Field(type=ast.CellType(of=of)):
                return self.owners(of.text)
            case _:
                return None


def names_of(files: Iterable[ast.File]) -> Names:
    """Returns what games declare together, their variants too: those of the text itself first."""
    names = Names()
    for file in files:
        for symbol, node in declarations(file):
            names.nodes.setdefault(symbol, node)
        for node in walk(file):
            if isinstance(node, ast.Words):
                names.words.update(name.text for name in node.names)
    return names


# Names that elaboration resolves where it gets to them, and in which name spaces their spelling
# counts where it doesn't.
USES: dict[type[Node], tuple[Space, ...]] = {
    ast.Path: ("name", "word", "metric"), ast.Call: ("name",), ast.Member: ("field", "argument"), ast.Domain: ("name",),
    ast.On: ("name",), ast.Chosen: ("action",), ast.ShapeRef: ("shape",), ast.Turn: ("phase",), ast.ShowEvent: ("metric",),
}  # fmt: skip


def occurrences(
    file: ast.File, names: Names, resolved: Mapping[Span, set[Symbol]]
) -> list[Occurrence]:
    """Returns every name of a file that stands for something declared, in the order of the text.

    Elaboration doesn't reach everything: not text beside a mistake, a define that nobody uses, a
    game that cannot be put together. There a name means all that is declared under it.

    Args:
      names: what the game declares, with its bases.
      resolved: what elaboration found names to stand for, in this game, in its variants, and
        perhaps in games that stand on it.
    """
    by_span = {}
    for symbol, node in declarations(file):
        span = node.name.span  # type: ignore[attr-defined]
        by_span[span] = Occurrence(span, (symbol,), True)
    used = {symbol for symbols in resolved.values() for symbol in symbols}
    for node in walk(file):
        match node:
            case ast.Words():
                for word in node.names:
                    # `draw colour from { red, green }` and `in { red, green }` are uses.
                    if word.span not in resolved:
                        by_span[word.span] = Occurrence(
                            word.span, (Symbol("word", word.text),), True
                        )
            case ast.Name(span=span) if local_symbol(node) in used:
                by_span[span] = Occurrence(span, (local_symbol(node),), True)
            case ast.Name(span=span) if span in resolved:
                symbols = tuple(sorted(symbol for symbol in resolved[span] if names.knows(symbol)))
                if symbols:
                    by_span[span] = Occurrence(span, symbols)
            case _ if type(node) in USES:
                name: ast.Name = node.kind if isinstance(node, ast.Domain | ast.On) else node.name  # type: ignore[attr-defined]
                symbols = tuple(sorted(names.called(name.text, USES[type(node)])))
                if name.span not in resolved and symbols:
                    by_span[name.span] = Occurrence(name.span, symbols)
            case _:
                pass
    return sorted(by_span.values(), key=lambda o: o.span.start)
