"""Reads statements and expressions for the names in them: what each stands for in the scopes around it."""

from collections.abc import Iterable, Mapping

from sjdsl.compiler import ast
from sjdsl.editor.names import AGENT, Names, Occurrence, Owners, Space, Symbol

Scope = Mapping[str, tuple[Symbol, Owners]]  # the local names around, each with what it can be
NO_NAMES: Scope = {}
NOTHING: Owners = frozenset()


class Reader:
    """Collects the names of a file that stand for something. Names that stand for nothing are left out: the compiler speaks of them."""

    def __init__(self, names: Names):
        self.names = names
        self.found: list[Occurrence] = []

    # ---- single names

    def declare(self, name: ast.Name, space: Space, owner: str = "") -> Symbol:
        symbol = Symbol(space, name.text, owner)
        self.found.append(Occurrence(name.span, (symbol,), True))
        return symbol

    def use(self, name: ast.Name, space: Space, owner: str = "") -> None:
        if self.names.has(Symbol(space, name.text, owner)):
            self.found.append(Occurrence(name.span, (Symbol(space, name.text, owner),)))

    def shared(self, name: ast.Name) -> None:
        """A name of the name space that numbers, kinds, groups, fields of the world, defines and words share."""
        if self.names.has(Symbol("name", name.text)):
            self.use(name, "name")
        elif name.text in self.names.words:
            self.found.append(Occurrence(name.span, (Symbol("word", name.text),)))

    def bound(self, names: Iterable[ast.Name], scope: Scope, owners: Owners = None) -> Scope:
        """Returns a scope with more local names."""
        for name in names:
            symbol = self.declare(name, "local", f"{name.span.file}:{name.span.start}")
            scope = {**scope, name.text: (symbol, owners)}
        return scope

    def variable(self, name: ast.Name, scope: Scope) -> Owners:
        """A name where a value or a member is wanted; returns what it can be."""
        if name.text in scope:
            symbol, owners = scope[name.text]
            self.found.append(Occurrence(name.span, (symbol,)))
            return owners
        if Symbol("name", name.text) not in self.names.nodes and name.text not in self.names.words:
            self.use(name, "metric")
        self.shared(name)
        declared = self.names.fields.get("", {}).get(name.text)
        return self.names.type_of(declared) if declared is not None else self.names.owners(name.text)

    def argument(self, e: ast.Expr) -> None:
        """What a phase is scheduled with: a value, or an action."""
        if isinstance(e, ast.Path) and not e.steps and e.name.text not in self.names.sorts and e.name.text not in self.names.words:
            self.use(e.name, "action")
        else:
            self.expression(e, NO_NAMES)

    # ---- types and rows

    def by(self, by: ast.By | None) -> None:
        match by:
            case ast.Words():
                self.words(by, declares=True)
            case ast.Numbers():
                self.expressions((by.low, by.high), NO_NAMES)

    def type(self, t: ast.Type) -> None:
        match t:
            case ast.Words():
                self.words(t, declares=True)
            case ast.Range():
                self.expressions((t.low, t.high), NO_NAMES)
            case ast.CellType():
                self.shared(t.of)

    def words(self, words: ast.Words, declares: bool = False) -> None:
        self.found += [Occurrence(name.span, (Symbol("word", name.text),), declares) for name in words.names]

    def value(self, value: ast.Expr | ast.Table, scope: Scope) -> None:
        """A number, or a table: its keys are words."""
        if not isinstance(value, ast.Table):
            self.expression(value, scope)
            return
        for entry in value.entries:
            self.shared(entry.key)
            self.value(entry.value, scope)

    # ---- expressions

    def expressions(self, trees: Iterable[ast.Expr], scope: Scope) -> None:
        for tree in trees:
            self.expression(tree, scope)

    def expression(self, e: ast.Expr, scope: Scope) -> Owners:
        """Reads an expression; returns what it can be, as far as dots are concerned."""
        match e:
            case ast.Path():
                return self.path(e, scope)
            case ast.Call():
                self.use(e.name, "name")
                self.expressions(e.arguments, scope)
            case ast.Count() | ast.Quantified():
                self.domain(e.domain, scope)
            case ast.Total() | ast.Extreme():
                inner = scope if e.domain is None else self.domain(e.domain, scope)
                self.expression(e.value, inner)
                if isinstance(e, ast.Extreme) and e.if_none is not None:
                    self.expression(e.if_none, scope)
            case ast.Case():
                self.expression(e.subject, scope)
                for arm in e.arms:
                    if arm.word is not None:
                        self.shared(arm.word)
                    self.expression(arm.value, scope)
            case ast.Unary():
                self.expression(e.operand, scope)
            case ast.Binary():
                self.expressions((e.left, e.right), scope)
            case ast.Chose():
                self.expression(e.agent, scope)
                self.action(e.action, scope)
            case ast.Standing():
                self.expression(e.who, scope)
                self.variable(e.kind, scope)
            case ast.Within():
                self._within(e, scope)
        return NOTHING

    def _within(self, e: ast.Within, scope: Scope) -> None:
        self.expression(e.value, scope)
        if isinstance(e.container, ast.Words):
            for name in e.container.names:
                self.variable(name, scope)
        else:
            self.expression(e.container, scope)
        if e.high is not None:
            self.expression(e.high, scope)

    def path(self, e: ast.Path, scope: Scope) -> Owners:
        """Reads `a.bag[raw]`; returns what it can be."""
        owners, action = self.variable(e.name, scope), ""
        for step in e.steps:
            if isinstance(step, ast.Index):
                self.expression(step.key, scope)
                continue
            name = step.name
            if action:
                self.use(name, "argument", action)
                action = ""
                continue
            symbols = self.names.with_field(name.text, owners)
            if symbols:
                self.found.append(Occurrence(name.span, symbols))
                held = [self.names.type_of(self.names.fields[s.owner][s.name]) for s in symbols]
                owners = frozenset().union(*(h or () for h in held))
            elif (owners is None or "agent" in owners) and self._has_arguments(name.text):
                self.use(name, "action")
                action, owners = name.text, self._argument_owners(name.text)
            else:
                owners = NOTHING
        return owners

    def _has_arguments(self, action: str) -> bool:
        node = self.names.nodes.get(Symbol("action", action))
        return isinstance(node, ast.Action) and bool(node.arguments)

    def _argument_owners(self, action: str) -> Owners:
        """Returns what the only argument of an action can be: `agent.vote` is an agent."""
        node = self.names.nodes[Symbol("action", action)]
        types = [a.type for a in node.arguments] if isinstance(node, ast.Action) else []
        return AGENT if any(isinstance(t, ast.NamedType) and t.name.text == "agent" for t in types) else NOTHING

    def action(self, action: ast.Chosen, scope: Scope) -> None:
        """An action that is spoken of; in a phase with parameters it may be one of these."""
        if action.name.text in scope:
            self.variable(action.name, scope)
        else:
            self.use(action.name, "action")
        self.expressions(action.arguments or (), scope)

    def binding_action(self, action: ast.Chosen, scope: Scope) -> Scope:
        """An action whose arguments are named by what stands in its brackets, as `forbid` does it."""
        self.use(action.name, "action")
        names = [a.name for a in action.arguments or () if isinstance(a, ast.Path) and not a.steps]
        return self.bound(
            names, scope, self._argument_owners(action.name.text) if self.names.has(Symbol("action", action.name.text)) else None
        )

    # ---- domains and shapes

    def domain(self, d: ast.Domain, scope: Scope) -> Scope:
        """Reads who a statement is about; returns the scope in which its members have names."""
        self.shared(d.kind)
        match d.restriction:
            case ast.Near(shape=shape, anchor=anchor):
                self.shape(shape, scope)
                self.variable(anchor, scope)
            case ast.Path():
                self.path(d.restriction, scope)
            case ast.Members():
                for name in d.restriction.names:
                    self.variable(name, scope)
        scope = self._member(d.kind, d.bind, scope)
        if d.on is not None:
            self.shared(d.on.kind)
            scope = self._member(d.on.kind, d.on.bind, scope)
        if d.where is not None:
            self.expression(d.where, scope)
        return scope

    def _member(self, kind: ast.Name, bind: ast.Name | None, scope: Scope) -> Scope:
        if bind is not None:
            return self.bound((bind,), scope, self.names.owners(kind.text))
        return {name: bound for name, bound in scope.items() if name != kind.text}

    def shape(self, shape: ast.ShapeRef, scope: Scope) -> None:
        self.use(shape.name, "shape")
        self.expressions(shape.arguments or (), scope)

    # ---- statements

    def block(self, block: ast.Block, scope: Scope) -> None:
        for statement in block.statements:
            scope = self.statement(statement, scope)

    def otherwise(self, otherwise: ast.Otherwise | None, scope: Scope) -> None:
        if isinstance(otherwise, ast.Block):
            self.block(otherwise, scope)
        elif otherwise is not None:
            self.statement(otherwise, scope)

    def statement(self, s: ast.Stmt, scope: Scope) -> Scope:
        """Reads a statement; returns the scope behind it."""
        match s:
            case ast.Let():
                owners = self.expression(s.value, scope)
                return self.bound((s.name,), scope, owners)
            case ast.Draw():
                self._drawn(s, scope)
                return self.bound((s.name,), scope, NOTHING)
            case ast.Each():
                self.block(s.block, self.domain(s.domain, scope))
            case ast.Pick():
                self.expression(s.number, scope)
                self.block(s.block, self.domain(s.domain, scope))
                self.otherwise(s.otherwise, scope)
            case ast.First():
                self.block(s.block, self.domain(s.domain, scope))
                self.otherwise(s.otherwise, scope)
            case ast.Match():
                self.block(s.block, self.domain(s.right, self.domain(s.left, scope)))
            case ast.When():
                self.expression(s.condition, scope)
                self.block(s.block, scope)
                self.otherwise(s.otherwise, scope)
            case ast.Chance():
                self.expression(s.probability, scope)
                self.block(s.block, scope)
                self.otherwise(s.otherwise, scope)
            case _:
                self._effect(s, scope)
        return scope

    def _drawn(self, s: ast.Draw, scope: Scope) -> None:
        match s.source:
            case ast.Words():
                self.words(s.source)
            case _:
                self.value(s.source, scope)
        if s.high is not None:
            self.expression(s.high, scope)

    def _effect(self, s: ast.Stmt, scope: Scope) -> None:
        match s:
            case ast.Set() | ast.Add():
                self.path(s.target, scope)
                self.expression(s.value, scope)
            case ast.Give():
                self.expression(s.value, scope)
                if isinstance(s.receiver, ast.Path):
                    self.path(s.receiver, scope)
                elif s.receiver.but is not None:
                    self.variable(s.receiver.but, scope)
            case ast.Tally():
                self.use(s.event.name, "metric")
                self.expressions([step.key for step in s.event.steps if isinstance(step, ast.Index)], scope)
                self.expressions([e for e in (s.by, s.receiver) if e is not None], scope)
            case ast.Send():
                self._send(s, scope)
            case ast.Shift():
                self.path(s.who, scope)
                self.expression(s.steps, scope)
                self.path(s.direction.path, scope)
                self._facing(s.facing, scope)
            case ast.Remove():
                self.path(s.who, scope)
            case ast.Move():
                self._move(s, scope)
            case ast.Mark():
                self.shape(s.shape, scope)
                self.variable(s.anchor, scope)

    def _send(self, s: ast.Send, scope: Scope) -> None:
        self.path(s.who, scope)
        if isinstance(s.domain, ast.Domain):
            self.domain(s.domain, scope)
        else:
            self.path(s.domain, scope)
        if s.after is not None:
            self.expression(s.after, scope)
        self._facing(s.facing, scope)

    def _facing(self, facing: ast.Name | None, scope: Scope) -> None:
        if facing is not None and facing.text in scope:
            self.variable(facing, scope)

    def _move(self, s: ast.Move, scope: Scope) -> None:
        scope = self.domain(s.domain, scope)
        match s.course:
            case ast.Toward() | ast.AwayFrom():
                self.domain(s.course.domain, scope)
            case ast.Along():
                self.expression(s.course.heading, scope)
        if isinstance(s.course, ast.Toward | ast.AwayFrom | ast.AtRandom) and s.course.avoided is not None:
            self.domain(s.course.avoided, scope)
