"""The names that a game declares, with its bases and in its variants: which symbols there are, and where a dot leads."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

from sjdsl.compiler import ast
from sjdsl.compiler.ast.node import Node
from sjdsl.compiler.ast.traverse import walk
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.source import Span

Space = Literal[
    "game", "name", "word", "field", "action", "argument", "shape", "phase", "metric", "variant", "policy", "scenario", "checks", "local"
]  # fmt: skip
Owners = frozenset[str] | None  # what a value can be, as far as dots are concerned: `agent`, kinds, sorts of movers; None: not known
AGENT: Owners = frozenset({"agent"})


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

    def has(self, symbol: Symbol) -> bool:
        """Returns whether something is declared."""
        return symbol in self.nodes


def names_of(files: Iterable[ast.File]) -> Names:
    """Returns what games declare together, their variants too: those of the text itself first."""
    found = Names()
    for file in files:
        found.nodes.setdefault(Symbol("game", file.game.name.text), file.game)
        _collect(file.game.sections, found)
        for node in walk(file):
            if isinstance(node, ast.Words):
                for name in node.names:
                    found.words.setdefault(name.text, []).append(name.span)
    return found


def _collect(sections: Sequence[ast.Section | ast.Override | ast.Drop], names: Names) -> None:
    for section in sections:
        match section:
            case ast.Constant():
                _shared(section, "size" if section.is_size else "parameter", names)
            case ast.Kind():
                _shared(section, "kind", names)
                names.kinds.add(section.name.text)
                _fields(section.attributes, section.name.text, names)
            case ast.Group():
                _shared(section, "group", names)
                names.groups.setdefault(section.name.text, tuple(kind.text for kind in section.kinds))
            case ast.Movers():
                _shared(section, "sort of movers", names)
                names.movers.add(section.name.text)
                _fields(section.attributes, section.name.text, names)
            case ast.Define():
                _shared(section, "define", names)
            case ast.Field() | ast.Timer():
                _shared(section, "field of the world", names)
                names.fields.setdefault("", {}).setdefault(section.name.text, section)
            case ast.Agents():
                _fields(section.attributes, "agent", names)
                for attribute in section.attributes:
                    if isinstance(attribute, ast.Acts):
                        _actions(attribute, names)
            case ast.Shape():
                names.nodes.setdefault(Symbol("shape", section.name.text), section)
            case ast.Phase():
                names.nodes.setdefault(Symbol("phase", section.name.text), section)
            case ast.Metrics():
                for metric in section.metrics:
                    names.nodes.setdefault(Symbol("metric", metric.name.text), metric)
            case ast.Checks(name=ast.Name() as name):
                names.nodes.setdefault(Symbol("checks", name.text), section)
            case ast.ScriptedPolicy():
                names.nodes.setdefault(Symbol("policy", section.name.text), section)
            case ast.Scenario():
                names.nodes.setdefault(Symbol("scenario", section.name.text), section)
            case ast.Variant():
                names.nodes.setdefault(Symbol("variant", section.name.text), section)
                _collect(section.changes, names)


def _shared(node: ast.Constant | ast.Kind | ast.Group | ast.Movers | ast.Define | ast.Field | ast.Timer, sort: str, names: Names) -> None:
    names.sorts.setdefault(node.name.text, sort)
    names.nodes.setdefault(Symbol("name", node.name.text), node)


def _fields(attributes: Sequence[object], owner: str, names: Names) -> None:
    for attribute in attributes:
        if isinstance(attribute, ast.Field | ast.Timer):
            names.fields.setdefault(owner, {}).setdefault(attribute.name.text, attribute)
            names.nodes.setdefault(Symbol("field", attribute.name.text, owner), attribute)


def _actions(acts: ast.Acts, names: Names) -> None:
    for action in acts.actions:
        names.nodes.setdefault(Symbol("action", action.name.text), action)
        for argument in action.arguments:
            if argument.name is not None:
                names.nodes.setdefault(Symbol("argument", argument.name.text, action.name.text), argument)
