"""Elaborates `show` and `hide`: what agents see, in a fixed order, and what is hidden."""

from collections.abc import Iterable, Sequence
from itertools import chain

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol, field_symbol
from sjdsl.compiler.compose import Composition, path_text
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import Fix
from sjdsl.compiler.elaborate.observed_paths import (
    OWNERS,
    Key,
    Seen,
    What,
    help_with_a_kind,
    observer_scope,
    resolve,
)
from sjdsl.compiler.elaborate.possible import check_possible, possible_condition
from sjdsl.compiler.elaborate.scope import Scope, Static
from sjdsl.compiler.ir.entity_types import AGENTS
from sjdsl.compiler.ir.implications import is_known
from sjdsl.compiler.ir.types import element, words
from sjdsl.runtime.actions import HEADINGS

RELATIVE = (
    "same heading",
    "turned right",
    "opposite",
    "turned left",
)  # of a mover, to the observer
WHOSE = ("nobody", "self", "other")  # how an agent that a field holds is seen
PLANES = ("marks", "content")
ORDER = ("cell", "heading", "other", "mover", "everyone", "own", "world")
FORMS = "`hide marks`, `hide marks on KIND`, `hide marks on agents` or `hide content on agents`"


def observables(
    game: Composition, rules: Sequence[ir.Node], scope: Scope
) -> tuple[ir.Observable, ...]:
    """Returns what is seen: word fields of cells unless hidden, headings, and all that is shown.

    rules: those of a step.
    """
    seen = _seen_by_default(scope.static)
    broken_kinds = _show_and_hide(game, seen, scope)
    whole = {kind for what, kind, field in seen if what == "cell" and not field}
    _check_shown_as_whole(whole, game, scope)
    _drop_fields_of_whole(whole, seen, rules, scope)
    _check_labels_of_whole(whole, seen, broken_kinds, scope)
    in_order = sorted(seen.values(), key=lambda observable: ORDER.index(observable.what))
    return planes_of_rows(in_order)


def _seen_by_default(static: Static) -> dict[Key, ir.Observable]:
    """Returns what is seen unless it is hidden: words of cells, headings of others, movers."""
    seen: dict[Key, ir.Observable] = {}
    for kind, fields in static.kinds.items():
        for field in fields.values():
            if field.type.is_single("word"):
                seen["cell", kind, field.name] = ir.Observable(
                    what="cell", kind=kind, field=field.name, type=field.type, origin=field.origin
                )
    seen["heading", "", ""] = ir.Observable(what="heading", type=words(HEADINGS))
    for name, movers in static.movers.items():
        seen["mover", name, ""] = ir.Observable(
            what="mover", kind=name, type=words((name,)), origin=movers.origin
        )
    return seen


def _show_and_hide(game: Composition, seen: dict[Key, ir.Observable], scope: Scope) -> set[str]:
    """Changes what is seen as `show` and `hide` say, in their order.

    Returns the kinds of cells of which something is shown or hidden with a mistake.
    """
    static = scope.static
    shown: set[Key] = set()
    broken_kinds: set[str] = set()
    for observable in game.observables.values():
        if isinstance(observable, ast.ShowEvent):
            continue
        kinds = set(static.kinds_of(observable.what.name.text) or ()) - broken_kinds
        broken_kinds |= kinds
        with scope.problems.skip_if_broken():  # which leaves the block at a mistake
            if isinstance(observable, ast.Show):
                _show(observable, seen, shown, scope)
            elif not _is_of_a_plane(observable, static):
                _hide(observable, seen, scope)
            broken_kinds -= kinds
    return broken_kinds


def _check_shown_as_whole(whole: set[str], game: Composition, scope: Scope) -> None:
    """Reports fields that are shown, or hidden under a condition, of kinds shown as a whole."""
    for observable in game.observables.values():
        if isinstance(observable, ast.ShowEvent) or not observable.what.steps:
            continue
        if isinstance(observable, ast.Hide) and observable.condition is None:
            continue
        for kind in scope.static.kinds_of(observable.what.name.text) or ():
            if kind in whole:
                places = f"here, and in `show {kind} as {{ … }}`"
                part = f"what is seen of cells of `{kind}` ({places})"
                scope.problems.add(errors.WrittenTwice(observable.span, part=part))
                break


def _drop_fields_of_whole(
    whole: set[str], seen: dict[Key, ir.Observable], rules: Sequence[ir.Node], scope: Scope
) -> None:
    """Removes the fields of kinds that are shown as a whole, and warns if agents miss one."""
    for key in list(seen):
        what, kind, name = key
        if what != "cell" or kind not in whole or not name:
            continue
        field = seen.pop(key)
        shown = seen["cell", kind, ""]
        is_disguise = all(label.condition is None for label in shown.labels)
        if not is_disguise and not _read(field, shown.labels) and _read(field, rules):
            scope.problems.add(errors.HiddenField(shown.span, kind=kind, name=name))


def _read(field: ir.Observable, parts: Sequence[ir.Node]) -> bool:
    """Returns whether some parts of the rules name a field of cells."""
    for read in chain.from_iterable(map(ir.walk, parts)):
        if isinstance(read, ir.FieldRead) and read.name == field.field:
            if read.held_by.overlaps(field.entity_type):
                return True
    return False


def _check_labels_of_whole(
    whole: set[str], seen: dict[Key, ir.Observable], broken_kinds: set[str], scope: Scope
) -> None:
    """Reports labels of kinds shown as a whole that name a kind of which fields are seen."""
    detailed = {
        kind: field
        for what, kind, field in seen
        if what == "cell" and field and kind not in broken_kinds
    }
    for kind in whole:
        for label in seen["cell", kind, ""].labels:
            if label.name in detailed:
                field = detailed[label.name]
                wrong = errors.WrongType(
                    label.span,
                    wanted="a kind whose cells all look the same",
                    actual=f"`{label.name}`, whose `{field}` is seen",
                    help="choose another word, or say with "
                    f"`show {label.name} as {{ … }}` how its cells look",
                )
                scope.problems.add(wrong)


def planes_of_rows(seen: Iterable[ir.Observable]) -> tuple[ir.Observable, ...]:
    """Returns what is seen with a plane for each entry of a row."""
    return tuple(chain.from_iterable(map(_entries, seen)))


def _entries(observable: ir.Observable) -> list[ir.Observable]:
    """Returns the planes of a row: one for each entry.

    Labels of a row by agent or by numbers may be about all its entries, and are one plane.
    """
    if not observable.type.indexed_by:
        return [observable]
    type_ = element(observable.type)
    index_set = observable.type.indexed_by[0]
    if observable.labels and index_set.kind != "word":
        return [observable.changed(type=type_)]
    return [observable.changed(type=type_, word=entry) for entry in index_set.entries]


def _check_places(what: str, test: ir.Expr, scope: Scope) -> None:
    """Reports a condition about the place of an agent of `everyone`, who may be away."""
    if what != "everyone" or not scope.static.can_be_away:
        return
    place = next((node for node in ir.walk(test) if _is_place(node)), None)
    if place is None:
        return
    if isinstance(test, ir.Logic) and test.fn == "and":
        first = test.args[0]
        if not any(map(_is_place, ir.walk(first))):
            scope = scope.knowing([first])
    everyone = ir.Member(name="everyone", entity_type=AGENTS)
    away = ir.Attribute(type=ir.CONDITION, owner=everyone, name="away")
    if not is_known(ir.Not(value=away), scope.facts):
        example = "`as { gone where everyone.away, near where distance(agent, everyone) < 3, far }`"
        raise scope.fail(
            errors.Unsupported(
                place.origin or test.span,
                feature="the place of an agent of `everyone`, who may be away",
                help=f"ask that first: {example}, or `not everyone.away and …`",
            )
        )


def _is_place(node: ir.Node) -> bool:
    """Returns whether an expression is the place of `everyone`, or the way to it or from it."""
    match node:
        case ir.Attribute(owner=ir.Member(name="everyone"), name="row" | "col"):
            return True
        case ir.Distance() | ir.Bearing():
            return any(
                isinstance(place, ir.Member) and place.name == "everyone"
                for place in (node.left, node.right)
            )
        case _:
            return False


def _show(show: ast.Show, seen: dict[Key, ir.Observable], shown: set[Key], scope: Scope) -> None:
    """Adds to `seen` what a `show` names. shown: what was shown before."""
    for target in resolve(show, scope):
        what, kind, name = target.key
        if target.key in shown:
            path = ".".join(part for part in (kind, name) if part)
            scope.problems.add(errors.WrittenTwice(show.span, part=f"what is seen of `{path}`"))
        shown.add(target.key)
        if what == "cell" and not name:
            seen[target.key] = _look(show, kind, scope)
        elif target.field is not None:
            owner = "agent" if what in OWNERS.values() else kind
            scope.static.used.add(field_symbol(name, owner))
            seen[target.key] = _shown(show, target, target.field, scope)
        else:
            part = f"that movers `{kind}` are seen (they are, unless `hide {kind}`)"
            raise scope.fail(errors.WrittenTwice(show.span, part=part))


def _shown(show: ast.Show, target: Seen, field: ir.VarField, scope: Scope) -> ir.Observable:
    """Returns a field as it is seen."""
    what, kind, name = target.key
    observer = observer_scope(what, kind, show.what.name.text, scope)
    condition = None
    if show.condition is not None:
        condition = observer.condition(show.condition)
        _check_places(what, condition, observer)
        check_possible(condition, observer)
        observer = observer.knowing([condition])
    labels = _labels(show, what, observer)
    type_ = field.type
    if not labels and type_.is_single("agent"):
        labels = _agent_labels(target.key, field)
    elif not labels:
        _check_plain(show, what, type_, scope)
    if what == "mover" and name == "heading":
        type_ = words(RELATIVE)
    observable = ir.Observable(
        what=what,
        kind=kind,
        field=name,
        type=type_,
        value=target.value,
        labels=labels,
        origin=show.span,
    )
    if condition is None:
        return observable
    if what == "cell":
        hidden_when = ir.Not(value=condition, origin=show.span)
        return observable.changed(hidden_when=hidden_when)
    return observable.changed(shown_when=condition)


def _agent_labels(key: Key, field: ir.VarField) -> tuple[ir.Label, ...]:
    """Returns how an agent that a field holds is seen: as nobody, the observer, or another."""
    what, kind, name = key
    names = {seen: owner for owner, seen in OWNERS.items()}
    owner = None
    if what != "world":
        owner = ir.Member(name=kind or names.get(what, ""), entity_type=field.held_by)
    held = ir.FieldRead(type=field.type, owner=owner, held_by=field.held_by, name=name)
    nobody, mine, another = WHOSE
    observer = ir.Member(name="agent", entity_type=AGENTS)
    return (
        ir.Label(name=nobody, condition=ir.Same(left=held, right=ir.Nobody())),
        ir.Label(name=mine, condition=ir.Same(left=held, right=observer)),
        ir.Label(name=another, condition=None),
    )


def _check_plain(show: ast.Show, what: What, type_: ir.Type, scope: Scope) -> None:
    """Reports a field that cannot be shown as it is, with labels to show it by."""
    path = path_text(show.what)
    if show.observer is not None:
        path += f"({show.observer.text})"
    labels = {
        "agent": f"mine where {path} is agent, theirs",
        "agents": f"ours where agent in {path}, theirs",
        "cell": f"somewhere where {path} is not nowhere, unset",
    }.get(type_.kind, f"some where {path} > 0, none_left")
    shown = f"show {path} as {{ {labels} }}"
    fix = Fix(show.span, shown)
    help_ = f"write `{shown}`"
    if type_.kind in ("agent", "agents"):
        raise scope.fail(
            errors.WrongType(
                show.span,
                wanted="a field with labels",
                actual="a field that holds agents, whose numbers mean nothing to an observer",
                help=help_,
                fix=fix,
            )
        )
    if type_.kind == "cell":
        feature = "showing a field that holds a cell without labels"
    elif type_.kind == "real" or (type_.kind == "int" and type_.low < 0):
        feature = "showing a number that is not a count from 0 to 255"
        help_ = f"show it with labels, `{shown}`"
    elif what == "cell" and type_.kind != "word":
        feature = "showing a number of a cell without labels"
    else:
        return
    raise scope.fail(errors.Unsupported(show.span, feature=feature, help=help_, fix=fix))


def _look(show: ast.Show, kind: str, scope: Scope) -> ir.Observable:
    """Returns how cells of a kind look: like the first label whose condition holds."""
    if not show.labels or show.condition is not None:
        wanted = f"what cells of `{kind}` look like"
        actual = "a condition for the whole kind" if show.labels else "a kind without it"
        help_ = help_with_a_kind(kind, "show", scope.static)
        raise scope.expected(show.span, wanted, actual, help_)
    observer = observer_scope("cell", kind, show.what.name.text, scope)
    labels = _labels(show, "cell", observer)
    names = tuple(dict.fromkeys(label.name for label in labels))
    return ir.Observable(what="cell", kind=kind, type=words(names), labels=labels, origin=show.span)


def _labels(show: ast.Show, what: What, scope: Scope) -> tuple[ir.Label, ...]:
    """Returns the labels of a `show`; each is read where no label before it applies."""
    labels: list[ir.Label] = []
    for label in show.labels:
        name = label.label.text
        is_last = label is show.labels[-1]
        if is_last and label.where is not None:
            raise scope.fail(errors.LastLabelConditional(label.span))
        if not is_last and label.where is None:
            raise scope.fail(errors.LabelUnconditional(label.span, name=name))
        test = None
        if label.where is not None:
            test = scope.condition(label.where)
            others = [other.condition for other in labels if other.condition is not None]
            inner = scope.knowing(ir.Not(value=condition) for condition in others)
            _check_places(what, test, inner)
            check_possible(test, inner)
        labels.append(ir.Label(name=name, condition=test, origin=label.span))
    return tuple(labels)


def _hide(hide: ast.Hide, seen: dict[Key, ir.Observable], scope: Scope) -> None:
    """Takes out of `seen` what a `hide` names, or hides it where a condition holds."""
    for target in resolve(hide, scope):
        what, kind, name = target.key
        if what == "cell" and not name:
            help_ = help_with_a_kind(kind, "hide", scope.static)
            wanted = "something that is seen of cells"
            raise scope.expected(hide.what.span, wanted, "a kind", help_)
        if hide.condition is None:
            seen.pop(target.key, None)
            continue
        observer = observer_scope(what, kind, hide.what.name.text, scope)
        test = observer.condition(hide.condition)
        _check_places(what, test, observer)
        check_possible(test, observer)
        shown = seen.get(target.key)
        if shown is None:
            scope.problems.add(errors.NeverHappens(hide.span, problem="it is not seen anyway"))
            continue
        if shown.hidden_when is not None:
            test = ir.Logic(fn="or", args=(shown.hidden_when, test), origin=test.origin)
        seen[target.key] = shown.changed(hidden_when=test)


def _is_of_a_plane(hide: ast.Hide, static: Static) -> bool:
    """Returns whether a `hide` is about marks or content, and not about a field."""
    name = hide.what.name.text
    return hide.on is not None or (
        not hide.what.steps and name in PLANES and name not in static.fields
    )


def hidden(game: Composition, scope: Scope) -> tuple[ir.Hidden, ...]:
    """Returns what of some cells an observation leaves out, as written.

    hide marks on river   ->   Hidden(what="marks", on="cells", name="river", kinds=("water", ...))
    """
    hides = [
        observable
        for observable in game.observables.values()
        if isinstance(observable, ast.Hide) and _is_of_a_plane(observable, scope.static)
    ]
    return tuple(scope.problems.each(hides, lambda hide: _hidden(hide, scope)))


def _hidden(hide: ast.Hide, scope: Scope) -> ir.Hidden:
    """Returns a typed `hide` of marks or contents."""
    static = scope.static
    plane = hide.what.name.text
    on = hide.on
    if hide.what.steps or plane not in PLANES:
        wanted = "`marks` or `content`"
        raise scope.expected(hide.what.span, wanted, "something else", f"write {FORMS}")
    if plane == "content" and (on is None or on.text != "agents"):
        help_ = (
            "write `hide content on agents`; `show gate as { floor }` makes cells of one kind "
            "look like those of another"
        )
        raise scope.expected(hide.span, "`on agents`", "content of other cells", help_)
    if on is None or on.text == "agents":
        if hide.condition is not None:
            wanted = "`on KIND` before `when`"
            actual = "a condition without a kind of cells"
            raise scope.expected(hide.span, wanted, actual, f"write {FORMS}")
        place = "map" if on is None else "agents"
        return ir.Hidden(what=plane, on=place, origin=hide.span)  # type: ignore[arg-type]
    kinds = static.kinds_of(on.text)
    if kinds is None:
        known = [*static.kinds, *static.groups, "agents"]
        raise scope.problems.unknown(on, known, "the kinds of this game")
    static.refer(on, Symbol("name", on.text))
    test = None
    if hide.condition is not None:
        observer = scope.with_agent("observe").bind_member(on.text, ir.EntityType("cell", kinds))
        test = possible_condition(hide.condition, observer)
    return ir.Hidden(
        what="marks", on="cells", name=on.text, kinds=kinds, when=test, origin=hide.span
    )
