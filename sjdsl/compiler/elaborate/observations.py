"""Elaborates `observe`: what an agent sees in its window, as planes in a fixed order."""

from dataclasses import replace
from math import inf
from typing import Literal

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol, field_symbol
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors, guesses
from sjdsl.compiler.diagnostics.diagnostic import Fix
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.problems import Poisoned, Problems
from sjdsl.compiler.elaborate.hidden import hides_others, is_of_a_plane
from sjdsl.compiler.elaborate.lookup import AGENT_ATTRIBUTES, no_field
from sjdsl.compiler.elaborate.observation_help import attribute_unseen, no_agent_field, no_cell_field, of_a_kind, without_field
from sjdsl.compiler.elaborate.observation_help import labels as example_labels
from sjdsl.compiler.elaborate.paths import attribute_types
from sjdsl.compiler.elaborate.scope import Scope, Static, wrong_type
from sjdsl.compiler.elaborate.seen_conditions import check_places, joined, observer_scope
from sjdsl.compiler.ir.implications import facts, narrowed
from sjdsl.compiler.ir.types import element, integer, words
from sjdsl.runtime.actions import HEADINGS

What = Literal["cell", "own", "other", "mover", "everyone", "world", "heading"]
RELATIVE = ("same heading", "turned right", "opposite", "turned left")  # how the heading of a mover is seen
OWNERS: dict[str, What] = {
    "agent": "own",
    "other": "other",
    "everyone": "everyone",
}  # how a path to a field of agents begins -> what is seen
Key = tuple[What, str, str]  # what, kind, field
WHOSE = ("nobody", "self", "other")  # how an agent that a field holds is seen


class Seen(Record):
    """What a path names: a field (None for cells as a whole, and for headings of others), and which agent of it by number.

    value: of `step` or a define, which is seen as a field of the world would be.
    """

    key: Key
    field: ir.VarField | None = None
    numbered: bool = False
    value: ir.Expr | None = None


def observables(game: Composition, static: Static, episode: ir.Expr | None, problems: Problems) -> tuple[ir.Observable, ...]:
    """Returns what is seen: word fields of cells and others' headings unless hidden, and all that is shown."""
    step = ir.Step(type=integer(0, inf, "steps"))
    static.of_observed = () if episode is None else facts(ir.Compare(fn="<=", left=step, right=episode))
    seen: dict[Key, ir.Observable] = {}
    for kind, fields in static.kinds.items():
        for field in fields.values():
            if field.type.kind == "word" and not field.type.by:
                seen["cell", kind, field.name] = ir.Observable(
                    what="cell", kind=kind, field=field.name, type=field.type, origin=field.origin
                )
    if not any(isinstance(o, ast.Hide) and hides_others(o) and o.condition is None for o in game.observables.values()):
        seen["heading", "", ""] = ir.Observable(what="heading", type=words(HEADINGS))
    for sort, movers in static.movers.items():
        seen["mover", sort, ""] = ir.Observable(what="mover", kind=sort, type=words((sort,)), origin=movers.origin)
    shown: set[Key] = set()
    lost: set[str] = set()  # kinds of which something is shown or hidden that has a mistake
    for observable in game.observables.values():
        kinds = set(static.kinds_of(observable.what.name.text) or ()) - lost
        lost |= kinds
        with problems.survive():
            if isinstance(observable, ast.Show):
                _show(observable, seen, shown, static, problems)
            elif not is_of_a_plane(observable, static):
                _hide(observable, seen, static, problems)
            lost -= kinds
    _put_looks(seen, lost, game, static, problems)
    order = ("cell", "heading", "other", "mover", "everyone", "own", "world")
    return tuple(entry for what in order for key, s in seen.items() if key[0] == what for entry in _entries(s))


def _put_looks(seen: dict[Key, ir.Observable], lost: set[str], game: Composition, static: Static, problems: Problems) -> None:
    """Leaves of a kind that is shown as a whole nothing else; its labels are words of their own, or kinds without anything more to see."""
    whole = {kind for what, kind, field in seen if what == "cell" and not field}
    for observable in game.observables.values():
        kind = next((k for k in static.kinds_of(observable.what.name.text) or () if k in whole), "")
        if kind and observable.what.steps and not (isinstance(observable, ast.Hide) and observable.condition is None):
            problems.add(
                errors.WrittenTwice(observable.span, what=f"what is seen of cells of `{kind}` (here, and in `show {kind} as {{ … }}`)")
            )
    for key in [k for k in seen if k[0] == "cell" and k[1] in whole and k[2]]:
        del seen[key]
    detailed = {kind: field for what, kind, field in seen if what == "cell" and field and kind not in lost}
    for kind in whole:
        for label in seen["cell", kind, ""].labels:
            if label.name in detailed:
                given = f"a kind whose cells do not all look alike: its `{detailed[label.name]}` is seen"
                help = f"choose another word, or say with `show {label.name} as {{ … }}` how its cells look"
                problems.add(errors.WrongType(label.span, wanted="one look", given=given, help=help))


def _entries(observable: ir.Observable) -> list[ir.Observable]:
    """A `by` field is seen entry by entry; labels of a row by agent or by numbers may speak of all its entries, and are one plane."""
    if not observable.type.by:
        return [observable]
    one = element(observable.type)
    if observable.labels and observable.type.by[0].sort != "word":
        return [observable.model_copy(update={"type": one})]
    return [observable.model_copy(update={"type": one, "word": entry}) for entry in observable.type.by[0].entries]


def _resolve(observable: ast.Show | ast.Hide, static: Static, problems: Problems) -> list[Seen]:
    """Returns what a path names: `agent.f`, `other.f`, `everyone.f`, `other.heading`, `kind.f`, a world field; of a group that of each kind."""
    path = observable.what
    head = path.name.text
    members = [s.name for s in path.steps if isinstance(s, ast.Member)]
    numbered = len(members) > 1 and members[-1].text == "index" and isinstance(observable, ast.Show) and not observable.labels
    members = members[:-1] if numbered else members
    if len(members) + numbered != len(path.steps) or len(members) > 1:
        raise problems.fail(
            errors.WrongType(path.span, wanted="`agent.field`, `other.field`, `everyone.field` or `kind.field`", given="another path")
        )
    if numbered or members:
        return [replace(seen, numbered=numbered) for seen in _of_owner(head, members[0], path, static, problems)]
    kinds = static.kinds_of(head)
    if head in static.movers or kinds:
        static.refer(path.name, Symbol("name", head))
    if head in static.movers:
        return [Seen(("mover", head, ""))]
    if kinds is not None and (head in static.kinds or (isinstance(observable, ast.Show) and observable.labels)):
        return [Seen(("cell", kind, "")) for kind in kinds]
    if isinstance(observable, ast.Show) and (head == "step" or head in static.defines):
        return [_computed(path, static, problems)]
    if head not in static.fields:
        raise without_field(observable, static, problems)
    static.use(path.name, Symbol("name", head))
    return [Seen(("world", "", head), static.fields[head])]


def _computed(path: ast.Path, static: Static, problems: Problems) -> Seen:
    """Returns `step` or a define, with what the numbers in it can be between two steps."""
    scope = observer_scope("world", "", "", static, problems)
    value, name = scope.expression(path), path.name.text
    if value.type.by or value.type.kind in ("member", "mix"):
        raise wrong_type(scope, path, "a single value", value.type)
    low, high = narrowed(value, scope.facts)
    type_ = words(("no", "yes")) if value.type.kind == "condition" else value.type.model_copy(update={"low": low, "high": high})
    return Seen(("world", "", name), ir.VarField(name=name, held_by=ir.Sort("world"), type=type_), value=value)


def _of_owner(head: str, name: ast.Name, path: ast.Path, static: Static, problems: Problems) -> list[Seen]:
    """Returns what `head.name` is: of agents, or of the cells of a kind or group."""
    if head in static.movers and Symbol("field", name.text, head) not in static.broken:
        fields = static.mover_fields(head)
        if name.text not in fields:
            raise no_field(name, f"a mover `{head}`", fields, guesses.PLACES, problems)
        static.refer(path.name, Symbol("name", head))
        static.refer(name, Symbol("field", name.text, head))
        return [Seen(("mover", head, name.text), fields[name.text])]
    kinds = static.kinds_of(head)
    owners = ["agent"] if head in OWNERS else [*(kinds or ()), head]
    if any(Symbol("field", name.text, owner) in static.broken for owner in owners):
        raise Poisoned
    if head in static.fields and name.text == "index":
        static.use(path.name, Symbol("name", head))
        return [Seen(("world", "", head), static.fields[head])]
    if head in OWNERS:
        if head == "other" and name.text == "heading":
            return [Seen(("heading", "", ""))]
        if name.text in static.agent_fields:
            static.refer(name, Symbol("field", name.text, "agent"))
        field = static.agent_fields.get(name.text) or _attribute(head, name, static, problems)
        return [Seen((OWNERS[head], "", name.text), field)]
    if kinds is None:
        raise problems.unknown(path.name, [*OWNERS, *static.kinds, *static.groups], "what has fields")
    static.refer(path.name, Symbol("name", head))
    for kind in kinds:
        if name.text not in static.kinds[kind]:
            if head in static.kinds:
                raise no_cell_field(head, name, static.kinds[kind], problems)
            raise no_field(name, f"the kind `{kind}` of the group", static.kinds[kind], guesses.PLACES, problems)
        static.refer(name, Symbol("field", name.text, kind))
    return [Seen(("cell", kind, name.text), static.kinds[kind][name.text]) for kind in kinds]


def _attribute(head: str, name: ast.Name, static: Static, problems: Problems) -> ir.VarField:
    """Returns what every agent has of itself, as if it were a field; conditions are the words `no` and `yes`."""
    if name.text not in AGENT_ATTRIBUTES:
        raise no_agent_field(name, static, problems)
    if name.text == "away" and head != "everyone":
        raise attribute_unseen(head, name, problems)
    type_ = attribute_types(static)[name.text]
    return ir.VarField(name=name.text, held_by=ir.Sort("agent"), type=words(("no", "yes")) if type_.kind == "condition" else type_)


def _show(show: ast.Show, seen: dict[Key, ir.Observable], shown: set[Key], static: Static, problems: Problems) -> None:
    """`shown`: what was shown before, perhaps under another name."""
    for found in _resolve(show, static, problems):
        what, kind, name = found.key
        if found.key in shown:
            problems.add(
                errors.WrittenTwice(show.span, what=f"what is seen of {f'`{kind}.{name}`' if name and kind else f'`{name or kind}`'}")
            )
        shown.add(found.key)
        if what == "cell" and not name:
            seen[found.key] = _look(show, kind, static, problems)
        elif found.field is not None:
            static.used.add(field_symbol(name, "agent" if what in OWNERS.values() else kind))
            seen[found.key] = _shown(show, found, found.field, static, problems)
        elif what == "mover":
            told = f"that movers `{kind}` are seen (they are, unless `hide {kind}`)"
            raise problems.fail(errors.WrittenTwice(show.span, what=told))
        elif show.condition is not None and found.key in seen:  # headings of others, which are seen anyway
            shown_when = observer_scope(what, "", "", static, problems).condition(show.condition)
            seen[found.key] = seen[found.key].model_copy(update={"hidden_when": ir.Not(value=shown_when, origin=show.span)})


def _shown(show: ast.Show, found: Seen, field: ir.VarField, static: Static, problems: Problems) -> ir.Observable:
    """Returns a field as it is seen."""
    what, kind, name = found.key
    scope = observer_scope(what, kind, show.what.name.text, static, problems)
    condition = None if show.condition is None else scope.condition(show.condition)
    check_places(what, condition, (), static, problems)
    labels, type_ = _labels(show, what, scope.knowing(() if condition is None else (condition,)), problems), field.type
    if not labels and type_.kind == "agent" and not type_.by:
        if found.numbered:
            type_ = words(("nobody", *map(str, range(static.num_agents))))
        else:
            labels = _whose(found.key, field)
    elif found.numbered:
        raise problems.fail(errors.WrongType(show.what.span, wanted="a field that holds an agent before `.index`", given="another field"))
    elif not labels:
        _check_plain(show, what, type_, problems)
    if what == "mover" and name == "heading":
        type_ = words(RELATIVE)
    observable = ir.Observable(what=what, kind=kind, field=name, type=type_, value=found.value, labels=labels, origin=show.span)
    if condition is None:
        return observable
    if what == "cell":
        return observable.model_copy(update={"hidden_when": ir.Not(value=condition, origin=show.span)})
    return observable.model_copy(update={"shown_when": condition})


def _whose(key: Key, field: ir.VarField) -> tuple[ir.Label, ...]:
    """Returns how an agent that a field holds is seen: as nobody, the observer itself, or another agent."""
    what, kind, name = key
    called = kind or next((n for n, w in OWNERS.items() if w == what), "")
    owner = None if what == "world" else ir.Member(name=called, sort=field.held_by)
    held = ir.FieldRead(type=field.type, owner=owner, held_by=field.held_by, name=name)
    tests = (ir.Same(left=held, right=ir.Nobody()), ir.Same(left=held, right=ir.Member(name="agent", sort=ir.Sort("agent"))), None)
    return tuple(ir.Label(name=label, condition=test) for label, test in zip(WHOSE, tests, strict=True))


def _check_plain(show: ast.Show, what: What, type_: ir.Type, problems: Problems) -> None:
    """Reports a field that cannot be shown as it is."""
    told = f"`show {path_text(show.what)}{example_labels(path_text(show.what), type_.kind)}`"
    fix = Fix(show.span, told.strip("`"))
    if type_.kind in ("agent", "agents"):
        wrong = errors.WrongType(
            show.span,
            wanted="a field with labels",
            given="a field that holds agents, whose numbers mean nothing to an observer",
            help=f"write {told}",
            fix=fix,
        )
        raise problems.fail(wrong)
    if type_.kind == "cell":
        raise problems.fail(
            errors.Unsupported(show.span, what="showing a field that holds a cell without labels", help=f"write {told}", fix=fix)
        )
    if type_.kind == "real" or (type_.kind == "int" and type_.low < 0):
        problem = "showing a number that is not a count from 0 to 255"
        raise problems.fail(errors.Unsupported(show.span, what=problem, help=f"show it with labels, {told}", fix=fix))
    if what == "cell" and type_.kind != "word":
        raise problems.fail(errors.Unsupported(show.span, what="showing a number of a cell without labels", help=f"write {told}", fix=fix))


def _look(show: ast.Show, kind: str, static: Static, problems: Problems) -> ir.Observable:
    """Returns how cells of a kind look: like the first label whose condition holds."""
    if not show.labels or show.condition is not None:
        help = of_a_kind(kind, "show", static)
        given = "a condition for the whole kind" if show.labels else "a kind without it"
        raise problems.fail(errors.WrongType(show.span, wanted=f"what cells of `{kind}` look like", given=given, help=help))
    labels = _labels(show, "cell", observer_scope("cell", kind, show.what.name.text, static, problems), problems)
    names = tuple(dict.fromkeys(label.name for label in labels))
    return ir.Observable(what="cell", kind=kind, type=words(names), labels=labels, origin=show.span)


def path_text(path: ast.Path) -> str:
    """Returns a path of names as it is written."""
    return ".".join([path.name.text, *(s.name.text for s in path.steps if isinstance(s, ast.Member))])


def _labels(show: ast.Show, what: What, scope: Scope, problems: Problems) -> tuple[ir.Label, ...]:
    found: list[ir.Label] = []
    for i, label in enumerate(show.labels):
        last = i == len(show.labels) - 1
        if last != (label.where is None):
            raise problems.fail(
                errors.LastLabelConditional(label.span) if last else errors.LabelUnconditional(label.span, name=label.label.text)
            )
        test = None if label.where is None else scope.condition(label.where)
        before = tuple(ir.Not(value=other.condition) for other in found if other.condition is not None)
        check_places(what, test, scope.knowing(before).facts, scope.static, problems)
        found.append(ir.Label(name=label.label.text, condition=test, origin=label.span))
    return tuple(found)


def _hide(hide: ast.Hide, seen: dict[Key, ir.Observable], static: Static, problems: Problems) -> None:
    for found in _resolve(hide, static, problems):
        what, kind, name = found.key
        if what == "cell" and not name:
            help = of_a_kind(kind, "hide", static)
            raise problems.fail(errors.WrongType(hide.what.span, wanted="something that is seen of cells", given="a kind", help=help))
        if hide.condition is None:
            seen.pop(found.key, None)
            continue
        shown = seen.get(found.key)
        test = observer_scope(what, kind, hide.what.name.text, static, problems).condition(hide.condition)
        check_places(what, test, (), static, problems)
        if shown is None:
            problems.add(errors.NeverHappens(hide.span, problem="it is not seen anyway"))
            continue
        tests = [test] if shown.hidden_when is None else [shown.hidden_when, test]
        seen[found.key] = shown.model_copy(update={"hidden_when": joined(tests)})
