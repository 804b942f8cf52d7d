"""Where names stand in a file and what each of them means: as elaboration resolved it, else by the name alone.

Elaboration knows the type before each dot. It doesn't reach everything: text beside a mistake, defines that nobody uses, games that cannot
be put together. There a name means what is declared under it, whatever the rest of its statement may be.
"""

from collections.abc import Iterable, Mapping

from sjdsl.compiler import ast
from sjdsl.compiler.ast.names import AGENT, Names, Occurrence, Owners, Space, Symbol, declared_by, local_symbol, owner_in
from sjdsl.compiler.ast.node import Node
from sjdsl.compiler.diagnostics.source import Span

Scope = Mapping[str, tuple[Symbol, Owners]]  # the local names around, each with what it can be
NOTHING: Owners = frozenset()
SHARED: tuple[Space, ...] = ("name", "word")
VALUE: tuple[Space, ...] = ("local", "name", "word", "metric")
WHAT_NAMES_ARE: dict[tuple[type[Node], str], tuple[Space, ...]] = {  # by the field of the node that they are: the first that is declared
    (ast.Group, "kinds"): SHARED, (ast.CellType, "of"): SHARED, (ast.Look, "what"): SHARED, (ast.Hide, "on"): SHARED,
    (ast.Monotone, "value"): SHARED, (ast.Monotone, "argument"): SHARED, (ast.Symmetric, "what"): SHARED, (ast.Domain, "kind"): SHARED,
    (ast.On, "kind"): SHARED, (ast.Entry, "key"): SHARED, (ast.Arm, "word"): SHARED, (ast.Call, "name"): ("name",),
    (ast.Blocks, "what"): ("shape", *SHARED), (ast.ShapeRef, "name"): ("shape",), (ast.Turn, "name"): ("phase",),
    (ast.Chosen, "name"): ("local", "action"), (ast.Policy, "actions"): ("action",), (ast.Policy, "name"): ("policy",),
    (ast.Slots, "policy"): ("policy",), (ast.Near, "anchor"): VALUE, (ast.Mark, "anchor"): VALUE, (ast.All, "but"): VALUE,
    (ast.Members, "names"): VALUE, (ast.Standing, "kind"): VALUE, (ast.Send, "facing"): ("local",), (ast.Shift, "facing"): ("local",),
    (ast.Draw, "source"): ("word",), (ast.Within, "container"): VALUE, (ast.Glyph, "starts"): ("field",),
    (ast.Drop, "name"): ("name", "shape", "phase", "metric", "checks", "policy", "scenario", "field", "variant"),
}  # fmt: skip
WHAT_PATHS_BEGIN_WITH: dict[tuple[type[Node], str], tuple[Space, ...]] = {
    (ast.Tally, "event"): ("metric",), (ast.Turn, "arguments"): (*SHARED, "action"),
}  # fmt: skip
BOUND = {
    (ast.Phase, "parameters"), (ast.Define, "parameters"), (ast.Domain, "bind"), (ast.On, "bind"), (ast.Let, "name"), (ast.Draw, "name"),
}  # fmt: skip


def occurrences(file: ast.File, names: Names, resolved: Iterable[tuple[Span, Symbol]] = ()) -> list[Occurrence]:
    """Returns every name of a file that stands for something declared in the game, in the order of the text.

    Args:
      names: what the game declares, with its bases.
      resolved: what elaboration found names to stand for, in this game and in its variants.
    """
    meanings: dict[Span, set[Symbol]] = {}
    for span, symbol in resolved:
        if symbol in names.nodes or symbol.space == "local" or (symbol.space == "word" and symbol.name in names.words):
            meanings.setdefault(span, set()).add(symbol)
    reader = _Reader(names, {span: tuple(sorted(symbols)) for span, symbols in meanings.items()})
    reader.read(file, {}, "")
    return sorted(reader.found.values(), key=lambda o: o.span.start)


class _Reader:
    """One reading of a file. A `let`, a `draw` or a domain names something for all that follows it in the same node."""

    def __init__(self, names: Names, resolved: Mapping[Span, tuple[Symbol, ...]]):
        self.names, self.resolved = names, resolved
        self.found: dict[Span, Occurrence] = {}

    def read(self, node: Node, scope: Scope, owner: str) -> Scope:
        """Reads a node; returns the scope of what follows it. `owner`: whose the fields in it are."""
        symbol, owner = declared_by(node, owner), owner_in(node, owner)
        if symbol is not None:
            self._declare(node.name, symbol)  # type: ignore[attr-defined]
        inner = scope
        if isinstance(node, ast.Forbid):
            for action in node.actions:
                inner = self._arguments_named(action, inner)
        # domains come first, for their names hold in all of the node; the name of a `let` or `draw` last, for it holds behind it
        order = {part: 0 if isinstance(value, ast.Domain) else 2 if part == "name" else 1 for part, value in vars(node).items()}
        for part, value in sorted(vars(node).items(), key=lambda item: order[item[0]]):
            inner = self._part(node, part, value, inner, owner)
        return inner if isinstance(node, ast.Let | ast.Draw | ast.Domain | ast.On) else scope

    def _part(self, node: Node, part: str, value: object, scope: Scope, owner: str) -> Scope:
        """Reads what stands in a field of a node, or in a tuple there; returns the scope of what follows it."""
        spaces = WHAT_NAMES_ARE.get((type(node), part), ())
        match value:
            case tuple():
                for each in value:
                    scope = self._part(node, part, each, scope, owner)
            case ast.Name() if (type(node), part) in BOUND:
                return self._bind(value, self._owners_of(node, scope), scope)
            case ast.Name():
                self._find(value, spaces, scope, owner)
            case ast.Words():
                for name in value.names:
                    if spaces:
                        self._find(name, spaces, scope)
                    else:
                        self._declare(name, Symbol("word", name.text))
            case ast.Path():
                self._path(value, scope, WHAT_PATHS_BEGIN_WITH.get((type(node), part), VALUE))
            case Node():
                return self.read(value, scope, owner)
        return scope

    # ---- single names

    def _declare(self, name: ast.Name, symbol: Symbol) -> None:
        self.found[name.span] = Occurrence(name.span, (symbol,), True)

    def _refer(self, name: ast.Name, symbols: tuple[Symbol, ...]) -> tuple[Symbol, ...]:
        """Adds what a name stands for, if anything; returns it. What elaboration resolved is what it means."""
        symbols = self.resolved.get(name.span, symbols)
        if symbols:
            self.found.setdefault(name.span, Occurrence(name.span, symbols, False))
        return symbols

    def _find(self, name: ast.Name, spaces: Iterable[Space], scope: Scope, owner: str = "") -> tuple[Symbol, ...]:
        """Adds what a name stands for: what has it in the first of the name spaces."""
        for space in spaces:
            symbol = Symbol(space, name.text, (owner or "agent") if space == "field" else "")
            if space == "local" and name.text in scope:
                return self._refer(name, (scope[name.text][0],))
            if symbol in self.names.nodes or (space == "word" and name.text in self.names.words):
                return self._refer(name, (symbol,))
        return self._refer(name, ())

    def _bind(self, name: ast.Name, owners: Owners, scope: Scope) -> Scope:
        """Returns a scope with one more local name."""
        symbol = local_symbol(name)
        self._declare(name, symbol)
        return {**scope, name.text: (symbol, owners)}

    def _owners_of(self, node: Node, scope: Scope) -> Owners:
        """Returns what the variable can be that a node names."""
        match node:
            case ast.Domain() | ast.On():
                return self.names.owners(node.kind.text)
            case ast.Let(value=ast.Path() as value):
                return self._path(value, scope)
            case ast.Let() | ast.Draw():
                return NOTHING
            case _:
                return None

    def _arguments_named(self, action: ast.Chosen, scope: Scope) -> Scope:
        """Returns a scope with the names that `forbid` gives to the arguments of an action: those that mean nothing else."""
        for argument in action.arguments or ():
            if isinstance(argument, ast.Path) and not argument.steps and not self._find(argument.name, VALUE, scope):
                scope = self._bind(argument.name, self._argument_owners(action.name.text), scope)
        return scope

    # ---- what stands behind dots

    def _path(self, e: ast.Path, scope: Scope, spaces: tuple[Space, ...] = VALUE) -> Owners:
        """Reads `a.bag[raw]`; returns what it can be."""
        self._find(e.name, spaces, scope)
        declared = self.names.fields.get("", {}).get(e.name.text)
        owners = self.names.type_of(declared) if declared is not None else self.names.owners(e.name.text)
        owners, action = scope[e.name.text][1] if e.name.text in scope else owners, ""
        for step in e.steps:
            if isinstance(step, ast.Index):
                self._part(step, "key", step.key, scope, "")
            elif action:
                argument = Symbol("argument", step.name.text, action)
                self._refer(step.name, (argument,) if argument in self.names.nodes else ())
                action = ""
            else:
                owners, action = self._member(step.name, owners)
        return owners

    def _member(self, name: ast.Name, owners: Owners) -> tuple[Owners, str]:
        """Reads what follows a dot; returns what it can be, and the action if it is one whose arguments are read."""
        symbols = self.names.with_field(name.text, owners)
        node = self.names.nodes.get(Symbol("action", name.text))
        if not symbols and (owners is None or "agent" in owners) and isinstance(node, ast.Action) and node.arguments:
            symbols = (Symbol("action", name.text),)
        symbols = self._refer(name, symbols)
        if symbols and symbols[0].space == "action":
            return self._argument_owners(name.text), name.text
        held = (self.names.type_of(self.names.fields[s.owner][s.name]) or () for s in symbols)
        return frozenset(owner for owners in held for owner in owners), ""

    def _argument_owners(self, action: str) -> Owners:
        """Returns what the arguments of an action can be: `agent.vote` is an agent."""
        node = self.names.nodes.get(Symbol("action", action))
        types = [a.type for a in node.arguments] if isinstance(node, ast.Action) else []
        return AGENT if any(isinstance(t, ast.NamedType) and t.name.text == "agent" for t in types) else NOTHING
