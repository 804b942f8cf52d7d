"""Resolves what the paths of `show` and `hide` name: fields of agents, movers, cells, the world."""

from dataclasses import replace
from typing import Literal

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.compose import path_text
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import Fix
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.problems import Poisoned
from sjdsl.compiler.elaborate.lookup import AGENT_ATTRIBUTES, CELL_ATTRIBUTES, no_field
from sjdsl.compiler.elaborate.paths import attribute_types
from sjdsl.compiler.elaborate.scope import Scope, Static, wrong_type
from sjdsl.compiler.ir.entity_types import AGENTS
from sjdsl.compiler.ir.implications import narrowed
from sjdsl.compiler.ir.operations import FUNCTIONS
from sjdsl.compiler.ir.types import words

What = Literal["cell", "own", "other", "mover", "everyone", "world", "heading"]
Key = tuple[What, str, str]  # what, kind, field
OWNERS: dict[str, What] = {"agent": "own", "other": "other", "everyone": "everyone"}
NO_OR_YES = words(("no", "yes"))  # what is shown of a condition
WHO = {  # the owners of fields of agents, as messages call them
    "agent": "the observer itself",
    "other": "the other agents",
    "everyone": "all agents",
}


class Seen(Record):
    """What a path names.

    field: None for cells or movers as a whole. value: of `step` or a define, which is seen as a
      field of the world would be, or of the observer.
    """

    key: Key
    field: ir.VarField | None = None
    value: ir.Expr | None = None


def observer_scope(what: str, kind: str, name: str, scope: Scope) -> Scope:
    """Returns what conditions may name: `agent`, the observer, and what is seen.

    name: by which the text calls a cell, perhaps that of a group.
    """
    observer = _observer_alone(scope)
    match what:
        case "cell":
            cell = ir.Member(name=kind, entity_type=ir.EntityType("cell", (kind,)))
            return observer.bind(kind, cell).bind(name, cell)
        case "mover":
            return observer.bind_member(kind, ir.EntityType("mover", (kind,)))
        case "heading":
            return observer.bind_member("other", AGENTS)
        case "other" | "everyone":
            return observer.bind_member(what, AGENTS)
        case _:
            return observer


def _observer_alone(scope: Scope) -> Scope:
    """Returns what a condition may name that isn't about something seen: `agent`, the observer."""
    return scope.with_agent("observe").but(facts=scope.static.observed_facts)


def resolve(observable: ast.Show | ast.Hide, scope: Scope) -> list[Seen]:
    """Returns what a path names; for a group, that of each of its kinds.

    A path is `agent.f`, `other.f`, `everyone.f`, `kind.f`, or a field of the world.
    """
    path = observable.what
    static = scope.static
    head = path.name.text
    if isinstance(observable, ast.Show) and observable.observer is not None:
        return [_of_observer(path, observable.observer, scope)]
    members = [step.name for step in path.steps if isinstance(step, ast.Member)]
    wanted = "`agent.field`, `other.field`, `everyone.field` or `kind.field`"
    if len(members) != len(path.steps):
        raise scope.expected(path.span, wanted, "an entry of a row", _whole_row(path, static))
    if len(members) > 1 or (members and head in static.fields):
        raise scope.expected(path.span, wanted, "another path")
    if head == "other" and members and members[0].text == "heading":
        return [_heading_of_others(observable, members[0], scope)]
    if members:
        return _of_owner(path.name, members[0], scope)
    kinds = static.kinds_of(head)
    if head in static.movers or kinds:
        static.refer(path.name, Symbol("name", head))
    if head in static.movers:
        return [Seen(("mover", head, ""))]
    is_show = isinstance(observable, ast.Show)
    if kinds is not None:
        has_labels = isinstance(observable, ast.Show) and bool(observable.labels)
        if head in static.kinds or has_labels:
            return [Seen(("cell", kind, "")) for kind in kinds]
    if is_show and (head == "step" or head in static.defines):
        if head in static.defines and len(static.defines[head].parameters) == 1:
            raise _without_observer(path, scope)
        return [_computed_value("world", path, path.name, scope)]
    if head not in static.fields:
        raise _without_field(observable, scope)
    static.use(path.name, Symbol("name", head))
    return [Seen(("world", "", head), static.fields[head])]


def _whole_row(path: ast.Path, static: Static) -> str:
    """Returns how to show a row of which one entry was to be shown."""
    members = tuple(step for step in path.steps if isinstance(step, ast.Member))
    row = path_text(replace(path, steps=members))
    help_ = f"a row can only be shown as a whole: `show {row}`"
    if path.name.text in static.fields:
        define = f"`define entry = {path_text(path)}`"
        help_ = f"{help_}; to show one entry, give it a name: {define}, `show entry`"
    return help_


def _of_observer(define: ast.Path, observer: ast.Name, scope: Scope) -> Seen:
    """Returns the value that a define has for the observer."""
    name = define.name.text
    if define.steps or name not in scope.static.defines:
        help_ = ""
        if name in FUNCTIONS:
            help_ = f"write a define of it: `define way(a) = {name}(a, …)`, `show way(agent)`"
        raise scope.problems.unknown(define.name, scope.static.defines, "the defines", help_)
    if observer.text != "agent":
        raise scope.expected(observer.span, "`agent`, the observer", f"`{observer.text}`")
    argument = ast.Path(observer.span, observer, ())
    call = ast.Call(define.span, define.name, (argument,))
    return _computed_value("own", call, define.name, scope)


def _without_observer(path: ast.Path, scope: Scope) -> Poisoned:
    """Reports a define with one parameter that is shown as if it had none."""
    name = path.name.text
    fix = Fix(path.span, f"{name}(agent)")
    help_ = f"write `show {name}(agent)`, if it is about the observer"
    return scope.fail(
        errors.WrongArguments(
            path.span, name=name, wanted="1 argument", actual=0, help=help_, fix=fix
        )
    )


def _computed_value(
    what: Literal["own", "world"], tree: ast.Expr, name: ast.Name, scope: Scope
) -> Seen:
    """Returns `step` or a define as if it were a field of the observer or of the world.

    Its numbers have the interval in which they are when agents observe.
    """
    observer = _observer_alone(scope)
    value = observer.expression(tree)
    type_ = value.type
    if type_.indexed_by or type_.kind in ("member", "mix"):
        raise wrong_type(observer, tree, "a single value", type_)
    if type_.kind == "condition":
        type_ = NO_OR_YES
    else:
        low, high = narrowed(value, observer.facts)
        type_ = type_.changed(low=low, high=high)
    held_by = AGENTS if what == "own" else ir.EntityType("world")
    field = ir.VarField(name=name.text, held_by=held_by, type=type_)
    return Seen((what, "", name.text), field, value)


def _of_owner(owner: ast.Name, name: ast.Name, scope: Scope) -> list[Seen]:
    """Returns what `owner.name` is: of agents, of movers, or of cells of a kind or group."""
    static = scope.static
    head = owner.text
    if head in static.movers and Symbol("field", name.text, head) not in static.broken:
        fields = static.fields_of(ir.EntityType("mover", (head,)))
        if name.text not in fields:
            raise no_field(name, f"a mover `{head}`", fields, scope.problems)
        static.refer(owner, Symbol("name", head))
        static.refer(name, Symbol("field", name.text, head))
        return [Seen(("mover", head, name.text), fields[name.text])]
    kinds = static.kinds_of(head)
    owners = ["agent"] if head in OWNERS else [*(kinds or ()), head]
    if any(Symbol("field", name.text, each) in static.broken for each in owners):
        raise Poisoned
    if head in OWNERS:
        if name.text in static.agent_fields:
            static.refer(name, Symbol("field", name.text, "agent"))
        field = static.agent_fields.get(name.text) or _attribute(head, name, scope)
        return [Seen((OWNERS[head], "", name.text), field)]
    if kinds is None:
        known = [*OWNERS, *static.kinds, *static.groups]
        raise scope.problems.unknown(owner, known, "what has fields")
    static.refer(owner, Symbol("name", head))
    seen = []
    for kind in kinds:
        fields = static.kinds[kind]
        if name.text not in fields:
            raise _no_field_of_kind(name, kind, head, scope)
        static.refer(name, Symbol("field", name.text, kind))
        seen.append(Seen(("cell", kind, name.text), fields[name.text]))
    return seen


def _heading_of_others(observable: ast.Show | ast.Hide, name: ast.Name, scope: Scope) -> Seen:
    """Returns what `hide other.heading` names; reports `show`, as it is seen anyway."""
    if isinstance(observable, ast.Show):
        raise scope.fail(
            errors.WrongSort(
                name.span,
                name="other.heading",
                actual="seen anyway, as the observer sees it, unless `hide other.heading`",
                wanted="one of their fields, `index`, `row`, `col` or `moved`",
            )
        )
    return Seen(("heading", "", ""))


def _no_field_of_kind(name: ast.Name, kind: str, head: str, scope: Scope) -> Poisoned:
    """Reports a field that a kind doesn't have; head: the kind's name or that of its group."""
    owner = f"the kind `{kind}`"
    help_ = ""
    if head in scope.static.groups:
        owner = f"{owner} of the group"
    elif name.text in CELL_ATTRIBUTES:
        help_ = "an agent sees where a cell is by its place in the window; only fields can be shown"
    return no_field(name, owner, scope.static.kinds[kind], scope.problems, help_)


def _attribute(head: str, name: ast.Name, scope: Scope) -> ir.VarField:
    """Returns an attribute of agents as if it were a field; conditions are words `no` and `yes`."""
    if name.text not in AGENT_ATTRIBUTES:
        known = [*scope.static.agent_fields, *AGENT_ATTRIBUTES]
        help_ = ""
        if name.text in scope.static.defines:
            help_ = f"`show {name.text}(agent)` shows a define"
        raise no_field(name, "an agent", known, scope.problems, help_)
    if name.text == "away" and head != "everyone":
        raise scope.fail(
            errors.WrongSort(
                name.span,
                name=f"{head}.{name.text}",
                actual="the same whenever it is seen",
                wanted="something that can change",
                help="an agent that is away sees nothing, and is not seen; "
                "`show everyone.away` tells all who is away",
            )
        )
    type_ = attribute_types(scope.static)[name.text]
    if type_.kind == "condition":
        type_ = NO_OR_YES
    return ir.VarField(name=name.text, held_by=AGENTS, type=type_)


def _without_field(observable: ast.Show | ast.Hide, scope: Scope) -> Poisoned:
    """Reports `show NAME` where the world has no such field, with what can be shown."""
    static = scope.static
    name = observable.what.name
    is_show = isinstance(observable, ast.Show)
    verb = "show" if is_show else "hide"
    if name.text in WHO:
        help_ = "agents are always seen; their fields can be shown, if the game declares some"
        fields = [f"`{verb} {name.text}.{field}`" for field in static.agent_fields]
        if fields:
            help_ = f"say which field: {' or '.join(fields[:3])}"
        return scope.misused(name, WHO[name.text], "a field", help_)
    if name.text in static.groups:
        help_ = help_with_a_kind(static.groups[name.text][0], verb, static)
        return scope.misused(name, "a group of kinds", "a field", help_)
    owners = [kind for kind, fields in static.kinds.items() if name.text in fields]
    if name.text in static.agent_fields:
        owners = ["agent", "other", *owners]
    help_ = ""
    if owners:
        paths = " or ".join(f"`{verb} {owner}.{name.text}`" for owner in owners)
        help_ = f"a field is written with its owner: {paths}"
    known = [*static.fields, *WHO, *static.kinds]
    described = "the fields of the world, and what has fields,"
    if is_show:
        known = [*static.fields, "step", *static.defines, *WHO, *static.kinds]
        described = "the fields of the world, the defines, and what has fields,"
    return scope.problems.unknown(name, known, described, help_)


def help_with_a_kind(kind: str, verb: str, static: Static) -> str:
    """Returns what to write to show or hide something of the cells of a kind.

    That is the first of its fields that is a word, or that it looks like a kind without such
    fields.
    """
    word_fields = {
        name: [f.name for f in fields.values() if f.type.kind == "word"]
        for name, fields in static.kinds.items()
    }
    plain = next(
        (name for name, seen in word_fields.items() if name != kind and not seen), "outside"
    )
    help_ = f"`show {kind} as {{ {plain} }}` makes its cells look like `{plain}`"
    if word_fields[kind]:
        help_ = f"write which field, `{verb} {kind}.{word_fields[kind][0]}`; {help_}"
    return help_
