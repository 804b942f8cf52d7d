"""Elaborates `observe`: the window of an agent, what it sees there as planes in a fixed order, and what is hidden."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Literal

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol, field_symbol
from sjdsl.compiler.compose import Composition, path_text
from sjdsl.compiler.diagnostics import errors, limits
from sjdsl.compiler.diagnostics.diagnostic import Fix, near
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.problems import Poisoned
from sjdsl.compiler.elaborate.lookup import AGENT_ATTRIBUTES, CELL_ATTRIBUTES, no_field
from sjdsl.compiler.elaborate.paths import attribute_types
from sjdsl.compiler.elaborate.possible import check_possible
from sjdsl.compiler.elaborate.scope import Scope, Static, wrong_type
from sjdsl.compiler.ir.implications import Fact, facts, is_known, narrowed
from sjdsl.compiler.ir.sorts import AGENTS
from sjdsl.compiler.ir.types import element, words
from sjdsl.runtime.actions import HEADINGS

What = Literal["cell", "own", "other", "mover", "everyone", "world", "heading"]
Key = tuple[What, str, str]  # what, kind, field
SIDES = {
    "ahead": 9,
    "behind": 1,
    "left": 5,
    "right": 5,
}  # how far an agent sees unless the game says otherwise
RELATIVE = (
    "same heading",
    "turned right",
    "opposite",
    "turned left",
)  # how the heading of a mover is seen
WHOSE = ("nobody", "self", "other")  # how an agent that a field holds is seen
OWNERS: dict[str, What] = {
    "agent": "own",
    "other": "other",
    "everyone": "everyone",
}  # how a path to a field of agents begins -> what is seen
WHO = {
    "agent": "the observer itself",
    "other": "the other agents",
    "everyone": "all agents",
}  # these, as messages call them
PLANES = ("marks", "content")
FORMS = "`hide marks`, `hide marks on KIND`, `hide marks on agents` or `hide content on agents`"


class Seen(Record):
    """What a path names: a field (None for cells as a whole).

    value: of `step` or a define, which is seen as a field of the world would be.
    """

    key: Key
    field: ir.VarField | None = None
    value: ir.Expr | None = None


# ---- the window


def window(game: Composition, scope: Scope) -> ir.Window:
    """Returns what an observation covers: as far to each side as anyone sees."""
    plain = next((w for w in game.windows if w.condition is None), None)
    usual = SIDES if plain is None else _sides(plain, SIDES, scope)
    origin = game.windows[0].span if game.windows else None
    observer = scope.with_agent("observe")

    def view(tree: ast.Window) -> ir.View:
        assert tree.condition is not None
        sides = _sides(tree, usual, scope)
        test = observer.condition(tree.condition)
        check_possible(test, observer)
        return ir.View(**sides, condition=test, origin=tree.span)

    views = scope.problems.each((w for w in game.windows if w.condition is not None), view)
    if views:
        views.append(
            ir.View(**usual, condition=None, origin=plain.span if plain is not None else origin)
        )
    farthest = {
        side: max(usual[side], *(getattr(view, side) for view in views), 0) for side in SIDES
    }
    return ir.Window(**farthest, views=tuple(views), origin=origin)


def _sides(tree: ast.Window, usual: dict[str, int], scope: Scope) -> dict[str, int]:
    """Returns how far a window goes to each side; to sides that are not named as far as usual."""
    sides = dict(usual)
    for i, (name, value) in enumerate(tree.sides):
        if name.text in [n.text for n, _ in tree.sides[:i]]:
            scope.problems.add(errors.WrittenTwice(name.span, part=f"`{name.text}`"))
        if name.text not in SIDES:
            scope.problems.unknown(name, tuple(SIDES), "the sides of a window")
            continue
        with scope.problems.survive():
            sides[name.text] = scope.whole(
                value, "the window", f"the window {name.text}", 0, limits.MAX_WINDOW
            )
    return sides


# ---- what is seen


def observables(
    game: Composition, rules: Sequence[ir.Node], scope: Scope
) -> tuple[ir.Observable, ...]:
    """Returns what is seen: word fields of cells unless hidden, others' headings, and all that is shown. `rules`: those of a step."""
    static = scope.static
    seen: dict[Key, ir.Observable] = {}
    for kind, fields in static.kinds.items():
        for f in fields.values():
            if f.type.kind == "word" and not f.type.by:
                seen["cell", kind, f.name] = ir.Observable(
                    what="cell", kind=kind, field=f.name, type=f.type, origin=f.origin
                )
    seen["heading", "", ""] = ir.Observable(what="heading", type=words(HEADINGS))
    for sort, movers in static.movers.items():
        seen["mover", sort, ""] = ir.Observable(
            what="mover", kind=sort, type=words((sort,)), origin=movers.origin
        )
    shown: set[Key] = set()
    lost: set[str] = set()  # kinds of which something is shown or hidden that has a mistake
    for observable in game.observables.values():
        kinds = set(static.kinds_of(observable.what.name.text) or ()) - lost
        lost |= kinds
        with scope.problems.survive():
            if isinstance(observable, ast.Show):
                _show(observable, seen, shown, scope)
            elif not _is_of_a_plane(observable, static):
                _hide(observable, seen, scope)
            lost -= kinds
    _leave_looks_alone(seen, lost, game, rules, scope)
    order = ("cell", "heading", "other", "mover", "everyone", "own", "world")
    return tuple(
        entry
        for what in order
        for key, s in seen.items()
        if key[0] == what
        for entry in _entries(s)
    )


def _leave_looks_alone(
    seen: dict[Key, ir.Observable],
    lost: set[str],
    game: Composition,
    rules: Sequence[ir.Node],
    scope: Scope,
) -> None:
    """Leaves of a kind that is shown as a whole nothing else; its labels are words of their own, or kinds without anything more to see."""
    whole = {kind for what, kind, field in seen if what == "cell" and not field}
    for observable in game.observables.values():
        kind = next(
            (k for k in scope.static.kinds_of(observable.what.name.text) or () if k in whole), ""
        )
        if (
            kind
            and observable.what.steps
            and not (isinstance(observable, ast.Hide) and observable.condition is None)
        ):
            what = f"what is seen of cells of `{kind}` (here, and in `show {kind} as {{ … }}`)"
            scope.problems.add(errors.WrittenTwice(observable.span, part=what))
    for key in [k for k in seen if k[0] == "cell" and k[1] in whole and k[2]]:
        hidden_field = seen.pop(key)
        labels = seen["cell", key[1], ""].labels
        is_disguise = all(label.condition is None for label in labels)
        if not is_disguise and not _read(hidden_field, labels) and _read(hidden_field, rules):
            scope.problems.add(
                errors.HiddenField(seen["cell", key[1], ""].span, kind=key[1], name=key[2])
            )
    detailed = {
        kind: field for what, kind, field in seen if what == "cell" and field and kind not in lost
    }
    for kind in whole:
        for label in seen["cell", kind, ""].labels:
            if label.name in detailed:
                given = f"a kind whose cells look different: its `{detailed[label.name]}` is seen"
                help_ = f"choose another word, or say with `show {label.name} as {{ … }}` how its cells look"
                scope.problems.add(
                    errors.WrongType(label.span, wanted="one look", actual=given, help=help_)
                )


def _read(field: ir.Observable, parts: Sequence[ir.Node]) -> bool:
    """Returns whether some parts of the rules name a field of cells."""
    nodes = (node for part in parts for node in ir.walk(part) if isinstance(node, ir.FieldRead))
    return any(node.name == field.field and node.held_by.overlaps(field.sort) for node in nodes)


def _entries(observable: ir.Observable) -> list[ir.Observable]:
    """A `by` field is seen entry by entry; labels of a row by agent or by numbers may speak of all its entries, and are one plane."""
    if not observable.type.by:
        return [observable]
    one = element(observable.type)
    if observable.labels and observable.type.by[0].sort != "word":
        return [observable.model_copy(update={"type": one})]
    return [
        observable.model_copy(update={"type": one, "word": entry})
        for entry in observable.type.by[0].entries
    ]


def observer_scope(what: str, kind: str, named: str, scope: Scope) -> Scope:
    """Returns what conditions may name: `agent`, the observer, and the cell or agent that is seen. `named`: a group that a cell is called by."""
    observer = scope.with_agent("observe").but(facts=scope.static.observed_facts)
    match what:
        case "cell":
            cell = ir.Member(name=kind, sort=ir.Sort("cell", (kind,)))
            return observer.bind(kind, cell).bind(named, cell)
        case "mover":
            return observer.bind(kind, ir.Member(name=kind, sort=ir.Sort("mover", (kind,))))
        case "other":
            return observer.bind("other", ir.Member(name="other", sort=AGENTS))
        case "everyone":
            return observer.bind("everyone", ir.Member(name="everyone", sort=AGENTS))
        case _:
            return observer


def check_places(what: str, test: ir.Expr | None, known: Iterable[Fact], scope: Scope) -> None:
    """Reports a condition that asks where an agent of `everyone` is, who may be away. `known`: what holds where it is asked."""
    if test is None or what != "everyone" or not scope.static.can_be_away:
        return
    asked = next((node for node in ir.walk(test) if _asks_place(node)), None)
    everyone = ir.Member(name="everyone", sort=AGENTS)
    away = ir.Attribute(type=ir.CONDITION, owner=everyone, name="away")
    first = test.args[0] if isinstance(test, ir.Logic) and test.fn == "and" else None
    sure = (
        *known,
        *(facts(first) if first is not None and not any(map(_asks_place, ir.walk(first))) else ()),
    )
    if asked is not None and not is_known(ir.Not(value=away), sure):
        gone = "`as { gone where everyone.away, near where distance(agent, everyone) < 3, far }`"
        what, help_ = (
            "the place of an agent of `everyone`, who may be away",
            f"ask that first: {gone}, or `not everyone.away and …`",
        )
        raise scope.fail(errors.Unsupported(asked.origin or test.span, feature=what, help=help_))


def _asks_place(node: ir.Node) -> bool:
    match node:
        case ir.Attribute(owner=ir.Member(name="everyone"), name="row" | "col"):
            return True
        case ir.Distance():
            return any(
                isinstance(place, ir.Member) and place.name == "everyone"
                for place in (node.left, node.right)
            )
        case _:
            return False


# ---- what a path names


def _resolve(observable: ast.Show | ast.Hide, scope: Scope) -> list[Seen]:
    """Returns what a path names: `agent.f`, `other.f`, `everyone.f`, `kind.f`, a world field; of a group that of each kind."""
    path, static = observable.what, scope.static
    head = path.name.text
    members = [s.name for s in path.steps if isinstance(s, ast.Member)]
    if len(members) != len(path.steps) or len(members) > 1 or (members and head in static.fields):
        wanted = "`agent.field`, `other.field`, `everyone.field` or `kind.field`"
        given, help_ = "another path", ""
        if len(members) != len(path.steps):
            given, help_ = "an entry of a row", _whole_row(path, head, static)
        raise scope.expected(path.span, wanted, given, help_)
    if members:
        return _of_owner(path.name, members[0], scope)
    kinds = static.kinds_of(head)
    if head in static.movers or kinds:
        static.refer(path.name, Symbol("name", head))
    if head in static.movers:
        return [Seen(("mover", head, ""))]
    if kinds is not None and (
        head in static.kinds or (isinstance(observable, ast.Show) and observable.labels)
    ):
        return [Seen(("cell", kind, "")) for kind in kinds]
    if isinstance(observable, ast.Show) and (head == "step" or head in static.defines):
        return [_computed(path, scope)]
    if head not in static.fields:
        raise _without_field(observable, scope)
    static.use(path.name, Symbol("name", head))
    return [Seen(("world", "", head), static.fields[head])]


def _whole_row(path: ast.Path, head: str, static: Static) -> str:
    """Returns how to show a row of which one entry was to be shown."""
    members = tuple(step for step in path.steps if isinstance(step, ast.Member))
    help_ = f"a row can only be shown as a whole: `show {path_text(replace(path, steps=members))}`"
    if head in static.fields:
        help_ += (
            f"; to show one entry, give it a name: `define entry = {path_text(path)}`, `show entry`"
        )
    return help_


def _computed(path: ast.Path, scope: Scope) -> Seen:
    """Returns `step` or a define, with what the numbers in it can be between two steps."""
    observer = observer_scope("world", "", "", scope)
    value, name = observer.expression(path), path.name.text
    if value.type.by or value.type.kind in ("member", "mix"):
        raise wrong_type(observer, path, "a single value", value.type)
    low, high = narrowed(value, observer.facts)
    type_ = (
        words(("no", "yes"))
        if value.type.kind == "condition"
        else value.type.model_copy(update={"low": low, "high": high})
    )
    return Seen(
        ("world", "", name),
        ir.VarField(name=name, held_by=ir.Sort("world"), type=type_),
        value=value,
    )


def _of_owner(owner: ast.Name, name: ast.Name, scope: Scope) -> list[Seen]:
    """Returns what `owner.name` is: of agents, of movers, or of the cells of a kind or group."""
    static, head = scope.static, owner.text
    if head in static.movers and Symbol("field", name.text, head) not in static.broken:
        fields = static.mover_fields(head)
        if name.text not in fields:
            raise no_field(name, f"a mover `{head}`", fields, scope.problems)
        static.refer(owner, Symbol("name", head))
        static.refer(name, Symbol("field", name.text, head))
        return [Seen(("mover", head, name.text), fields[name.text])]
    kinds = static.kinds_of(head)
    owners = ["agent"] if head in OWNERS else [*(kinds or ()), head]
    if any(Symbol("field", name.text, each) in static.broken for each in owners):
        raise Poisoned
    if head == "other" and name.text == "heading":
        what, wanted = (
            "always seen, as the observer sees it",
            "a field of theirs, `index`, `row`, `col` or `moved`",
        )
        raise scope.fail(
            errors.WrongSort(name.span, name="other.heading", actual=what, wanted=wanted)
        )
    if head in OWNERS:
        if name.text in static.agent_fields:
            static.refer(name, Symbol("field", name.text, "agent"))
        field = static.agent_fields.get(name.text) or _attribute(head, name, scope)
        return [Seen((OWNERS[head], "", name.text), field)]
    if kinds is None:
        raise scope.problems.unknown(
            owner, [*OWNERS, *static.kinds, *static.groups], "what has fields"
        )
    static.refer(owner, Symbol("name", head))
    for kind in kinds:
        if name.text not in static.kinds[kind]:
            called, help_ = f"the kind `{kind}`", ""
            if head in static.groups:
                called = f"{called} of the group"
            elif name.text in CELL_ATTRIBUTES:
                help_ = "where a cell is, an agent sees by its place in the window; fields of cells are shown"
            raise no_field(name, called, static.kinds[kind], scope.problems, help_)
        static.refer(name, Symbol("field", name.text, kind))
    return [Seen(("cell", kind, name.text), static.kinds[kind][name.text]) for kind in kinds]


def _attribute(head: str, name: ast.Name, scope: Scope) -> ir.VarField:
    """Returns what every agent has of itself, as if it were a field; conditions are the words `no` and `yes`."""
    if name.text not in AGENT_ATTRIBUTES:
        raise no_field(
            name, "an agent", [*scope.static.agent_fields, *AGENT_ATTRIBUTES], scope.problems
        )
    if name.text == "away" and head != "everyone":
        help_ = "an agent that is away sees nothing, and is not seen; `show everyone.away` tells all who is away"
        what, wanted = "the same whenever it is seen", "something that can change"
        raise scope.fail(
            errors.WrongSort(
                name.span, name=f"{head}.{name.text}", actual=what, wanted=wanted, help=help_
            )
        )
    type_ = attribute_types(scope.static)[name.text]
    return ir.VarField(
        name=name.text,
        held_by=AGENTS,
        type=words(("no", "yes")) if type_.kind == "condition" else type_,
    )


def _without_field(observable: ast.Show | ast.Hide, scope: Scope) -> Poisoned:
    """Reports `show NAME` where the world has no such field, with what agents and cells have that can be shown."""
    static, name, verb = (
        scope.static,
        observable.what.name,
        "show" if isinstance(observable, ast.Show) else "hide",
    )
    if name.text in WHO:
        fields = [f"`{verb} {name.text}.{field}`" for field in static.agent_fields]
        help_ = "agents are always seen; fields of theirs can be shown, if the game declares some"
        if fields:
            help_ = f"say which field: {' or '.join(fields[:3])}"
        return scope.misused(name, WHO[name.text], "a field", help_)
    if name.text in static.groups:
        help_ = _fields_of_a_kind(static.groups[name.text][0], verb, static)
        return scope.misused(name, "a group of kinds", "a field", help_)
    owners = ["agent", "other"] * (name.text in static.agent_fields)
    owners += [kind for kind, fields in static.kinds.items() if name.text in fields]
    help_ = (
        f"a field is written with its owner: {' or '.join(f'`{verb} {o}.{name.text}`' for o in owners)}"
        if owners
        else ""
    )
    values = ["step", *static.defines] if isinstance(observable, ast.Show) else []
    known = (
        "the fields of the world, the defines, and what has fields,"
        if values
        else "the fields of the world, and what has fields,"
    )
    return scope.problems.unknown(
        name, [*static.fields, *values, *WHO, *static.kinds], known, help_
    )


def _fields_of_a_kind(kind: str, verb: str, static: Static) -> str:
    """Returns what can be shown or hidden of cells of a kind."""
    fields = {
        kind: [f.name for f in own.values() if f.type.kind == "word"]
        for kind, own in static.kinds.items()
    }
    plain = next((name for name, words in fields.items() if name != kind and not words), "outside")
    one = f"write which field, `{verb} {kind}.{fields[kind][0]}`; " if fields[kind] else ""
    return f"{one}`show {kind} as {{ {plain} }}` makes its cells look like `{plain}`"


# ---- shown


def _show(show: ast.Show, seen: dict[Key, ir.Observable], shown: set[Key], scope: Scope) -> None:
    """`shown`: what was shown before, perhaps under another name."""
    for found in _resolve(show, scope):
        what, kind, name = found.key
        if found.key in shown:
            path = f"{kind}.{name}" if name and kind else name or kind
            scope.problems.add(errors.WrittenTwice(show.span, part=f"what is seen of `{path}`"))
        shown.add(found.key)
        if what == "cell" and not name:
            seen[found.key] = _look(show, kind, scope)
        elif found.field is not None:
            scope.static.used.add(field_symbol(name, "agent" if what in OWNERS.values() else kind))
            seen[found.key] = _shown(show, found, found.field, scope)
        else:
            twice = f"that movers `{kind}` are seen (they are, unless `hide {kind}`)"
            raise scope.fail(errors.WrittenTwice(show.span, part=twice))


def _shown(show: ast.Show, found: Seen, field: ir.VarField, scope: Scope) -> ir.Observable:
    """Returns a field as it is seen."""
    what, kind, name = found.key
    observer = observer_scope(what, kind, show.what.name.text, scope)
    condition = None if show.condition is None else observer.condition(show.condition)
    check_places(what, condition, (), scope)
    if condition is not None:
        check_possible(condition, observer)
        observer = observer.knowing([condition])
    labels, type_ = _labels(show, what, observer), field.type
    if not labels and type_.kind == "agent" and not type_.by:
        labels = _agent_labels(found.key, field)
    elif not labels:
        _check_plain(show, what, type_, scope)
    if what == "mover" and name == "heading":
        type_ = words(RELATIVE)
    observable = ir.Observable(
        what=what,
        kind=kind,
        field=name,
        type=type_,
        value=found.value,
        labels=labels,
        origin=show.span,
    )
    if condition is None:
        return observable
    if what == "cell":
        return observable.model_copy(
            update={"hidden_when": ir.Not(value=condition, origin=show.span)}
        )
    return observable.model_copy(update={"shown_when": condition})


def _agent_labels(key: Key, field: ir.VarField) -> tuple[ir.Label, ...]:
    """Returns how an agent that a field holds is seen: as nobody, the observer itself, or another agent."""
    what, kind, name = key
    called = kind or next((n for n, w in OWNERS.items() if w == what), "")
    owner = None if what == "world" else ir.Member(name=called, sort=field.held_by)
    held = ir.FieldRead(type=field.type, owner=owner, held_by=field.held_by, name=name)
    tests = (
        ir.Same(left=held, right=ir.Nobody()),
        ir.Same(left=held, right=ir.Member(name="agent", sort=AGENTS)),
        None,
    )
    return tuple(
        ir.Label(name=label, condition=test) for label, test in zip(WHOSE, tests, strict=True)
    )


def _check_plain(show: ast.Show, what: What, type_: ir.Type, scope: Scope) -> None:
    """Reports a field that cannot be shown as it is, with labels to show it by."""
    path = path_text(show.what)
    labels = {
        "agent": f"mine where {path} is agent, theirs",
        "agents": f"ours where agent in {path}, theirs",
        "cell": f"somewhere where {path} is not nowhere, unset",
    }.get(type_.kind, f"some where {path} > 0, none_left")
    shown = f"show {path} as {{ {labels} }}"
    help_, fix, problem = f"write `{shown}`", Fix(show.span, shown), ""
    if type_.kind in ("agent", "agents"):
        given = "a field that holds agents, whose numbers mean nothing to an observer"
        raise scope.fail(
            errors.WrongType(
                show.span, wanted="a field with labels", actual=given, help=help_, fix=fix
            )
        )
    if type_.kind == "cell":
        problem = "showing a field that holds a cell without labels"
    elif type_.kind == "real" or (type_.kind == "int" and type_.low < 0):
        problem, help_ = (
            "showing a number that is not a count from 0 to 255",
            f"show it with labels, `{shown}`",
        )
    elif what == "cell" and type_.kind != "word":
        problem = "showing a number of a cell without labels"
    if problem:
        raise scope.fail(errors.Unsupported(show.span, feature=problem, help=help_, fix=fix))


def _look(show: ast.Show, kind: str, scope: Scope) -> ir.Observable:
    """Returns how cells of a kind look: like the first label whose condition holds."""
    if not show.labels or show.condition is not None:
        given = "a condition for the whole kind" if show.labels else "a kind without it"
        help_ = _fields_of_a_kind(kind, "show", scope.static)
        raise scope.expected(show.span, f"what cells of `{kind}` look like", given, help_)
    labels = _labels(show, "cell", observer_scope("cell", kind, show.what.name.text, scope))
    names = tuple(dict.fromkeys(label.name for label in labels))
    return ir.Observable(what="cell", kind=kind, type=words(names), labels=labels, origin=show.span)


def _labels(show: ast.Show, what: What, scope: Scope) -> tuple[ir.Label, ...]:
    found: list[ir.Label] = []
    for label in show.labels:
        last, name = label is show.labels[-1], label.label.text
        if last and label.where is not None:
            raise scope.fail(errors.LastLabelConditional(label.span))
        if not last and label.where is None:
            raise scope.fail(errors.LabelUnconditional(label.span, name=name))
        test = None if label.where is None else scope.condition(label.where)
        before = scope.knowing(
            ir.Not(value=other.condition) for other in found if other.condition is not None
        )
        check_places(what, test, before.facts, scope)
        if test is not None:
            check_possible(test, before)
        found.append(ir.Label(name=name, condition=test, origin=label.span))
    return tuple(found)


# ---- hidden


def _hide(hide: ast.Hide, seen: dict[Key, ir.Observable], scope: Scope) -> None:
    for found in _resolve(hide, scope):
        what, kind, name = found.key
        if what == "cell" and not name:
            help_ = _fields_of_a_kind(kind, "hide", scope.static)
            raise scope.expected(hide.what.span, "something that is seen of cells", "a kind", help_)
        if hide.condition is None:
            seen.pop(found.key, None)
            continue
        shown = seen.get(found.key)
        observer = observer_scope(what, kind, hide.what.name.text, scope)
        test = observer.condition(hide.condition)
        check_places(what, test, (), scope)
        check_possible(test, observer)
        if shown is None:
            scope.problems.add(errors.NeverHappens(hide.span, problem="it is not seen anyway"))
            continue
        if shown.hidden_when is not None:
            test = ir.Logic(fn="or", args=(shown.hidden_when, test), origin=test.origin)
        seen[found.key] = shown.model_copy(update={"hidden_when": test})


def _is_of_a_plane(hide: ast.Hide, static: Static) -> bool:
    """Returns whether a `hide` is about marks or content, and not about a field."""
    name = hide.what.name.text
    return hide.on is not None or (
        not hide.what.steps and name in PLANES and name not in static.fields
    )


def hidden(game: Composition, scope: Scope) -> tuple[ir.Hidden, ...]:
    """Returns what of some cells an observation leaves out, as written.

    observe { hide marks on river }   ->   Hidden(what="marks", on="cells", name="river", kinds=("water", "channel"))
    """
    written = (
        o
        for o in game.observables.values()
        if isinstance(o, ast.Hide) and _is_of_a_plane(o, scope.static)
    )
    return tuple(scope.problems.each(written, lambda hide: _hidden(hide, scope)))


def _hidden(hide: ast.Hide, scope: Scope) -> ir.Hidden:
    what, on, static = hide.what.name.text, hide.on, scope.static
    if hide.what.steps or what not in PLANES:
        raise scope.expected(
            hide.what.span, "`marks` or `content`", "something else", f"write {FORMS}"
        )
    if what == "content" and (on is None or on.text != "agents"):
        help_ = "write `hide content on agents`; `show gate as { floor }` makes cells of one kind look like those of another"
        raise scope.expected(hide.span, "`on agents`", "content of other cells", help_)
    if on is None or on.text == "agents":
        if hide.condition is not None:
            given = "a condition without a kind of cells"
            raise scope.expected(hide.span, "`on KIND` before `when`", given, f"write {FORMS}")
        return ir.Hidden(what=what, on="map" if on is None else "agents", origin=hide.span)  # type: ignore[arg-type]
    kinds = static.kinds_of(on.text)
    if kinds is None:
        raise scope.fail(
            errors.UnknownName(
                on.span, name=on.text, near=near(on.text, [*static.kinds, *static.groups, "agents"])
            )
        )
    static.refer(on, Symbol("name", on.text))
    cell = ir.Member(name=on.text, sort=ir.Sort("cell", kinds))
    test, observer = None, scope.with_agent("observe").bind(on.text, cell)
    if hide.condition is not None:
        test = observer.condition(hide.condition)
        check_possible(test, observer)
    return ir.Hidden(
        what="marks", on="cells", name=on.text, kinds=kinds, when=test, origin=hide.span
    )
