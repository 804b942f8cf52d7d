"""The names that games declare: what there is by name, and where a name stands."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

from sjdsl.compiler import ast
from sjdsl.compiler.ast.node import Node
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.diagnostics.tree import children, walk

Space = Literal[
    "game", "name", "word", "field", "action", "argument", "shape", "phase", "metric", "variant", "policy", "scenario", "checks", "local"
]  # fmt: skip
Owners = frozenset[str] | None  # what a value can be, as far as dots are concerned: `agent`, kinds, sorts of movers; None: not known
AGENT: Owners = frozenset({"agent"})
SPACES: dict[type[Node], Space] = {
    ast.Game: "game", ast.Constant: "name", ast.Kind: "name", ast.Group: "name", ast.Movers: "name", ast.Define: "name", ast.Field: "name",
    ast.Timer: "name", ast.Action: "action", ast.Argument: "argument", ast.Shape: "shape", ast.Phase: "phase", ast.Event: "metric",
    ast.Measure: "metric", ast.Variant: "variant", ast.ScriptedPolicy: "policy", ast.Scenario: "scenario", ast.Checks: "checks",
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
    """One thing with a name. `owner`: of a field or an argument, whose; of a local name, where it is bound (`file:offset`)."""

    space: Space
    name: str
    owner: str = ""


class Occurrence(Record):
    """A name at one place. `symbols`: several for a field of a group, which each of its kinds declares."""

    span: Span
    symbols: tuple[Symbol, ...]
    declares: bool = False


def field_symbol(name: str, owner: str) -> Symbol:
    """Returns a field of the agents, a kind or a sort of movers; of the world if it has no owner."""
    return Symbol("field" if owner else "name", name, owner)


def local_symbol(name: ast.Name) -> Symbol:
    """Returns what a name stands for that a statement, a domain or a parameter introduces."""
    return Symbol("local", name.text, f"{name.span.file}:{name.span.start}")


def declared_by(node: Node, owner: str) -> Symbol | None:
    """Returns what a node declares itself. `owner`: what the node belongs to, as `owner_in` tells."""
    space, name = SPACES.get(type(node)), getattr(node, "name", None)
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
    """What is declared, by name. `sorts`: what each name of the shared name space is, as messages call it."""

    sorts: dict[str, str] = field(default_factory=dict)
    nodes: dict[Symbol, Node] = field(default_factory=dict)
    kinds: set[str] = field(default_factory=set)
    groups: dict[str, tuple[str, ...]] = field(default_factory=dict)
    movers: set[str] = field(default_factory=set)
    fields: dict[str, dict[str, ast.Field | ast.Timer]] = field(default_factory=dict)  # by owner; "" is the world
    words: dict[str, list[Span]] = field(default_factory=dict)

    def owners(self, name: str) -> Owners:
        """Returns what members of a domain are: of `agent`, a kind, a group, a sort of movers."""
        if name in ("agent", "other", "everyone"):
            return AGENT
        if name in self.kinds or name in self.movers:
            return frozenset({name})
        return frozenset(self.groups[name]) if name in self.groups else None

    def with_field(self, name: str, owners: Owners) -> tuple[Symbol, ...]:
        """Returns the fields that a name after a dot can stand for; of an owner that is not known, those of all."""
        among = sorted(owners) if owners is not None else [owner for owner in self.fields if owner]
        return tuple(Symbol("field", name, owner) for owner in among if name in self.fields.get(owner, {}))

    def type_of(self, declared: ast.Field | ast.Timer) -> Owners:
        """Returns what a field holds, as far as dots are concerned."""
        match declared:
            case ast.Field(type=ast.NamedType(name=ast.Name(text="agent"))):
                return AGENT
            case ast.Field(type=ast.CellType(of=of)):
                return self.owners(of.text)
            case _:
                return frozenset()


def names_of(files: Iterable[ast.File]) -> Names:
    """Returns what games declare together, their variants too: those of the text itself first."""
    found = Names()
    for file in files:
        for symbol, node in declarations(file):
            found.nodes.setdefault(symbol, node)
            if symbol.space == "name":
                number = "size" if isinstance(node, ast.Constant) and node.is_size else "parameter"
                found.sorts.setdefault(symbol.name, SORTS.get(type(node), number))
            match node:
                case ast.Field() | ast.Timer():
                    found.fields.setdefault(symbol.owner, {}).setdefault(symbol.name, node)
                case ast.Kind():
                    found.kinds.add(symbol.name)
                case ast.Movers():
                    found.movers.add(symbol.name)
                case ast.Group():
                    found.groups.setdefault(symbol.name, tuple(kind.text for kind in node.kinds))
        for node in walk(file):
            if isinstance(node, ast.Words):
                for name in node.names:
                    found.words.setdefault(name.text, []).append(name.span)
    return found
