"""Elaborates `observe`: the egocentric window of an agent, and the planes in it, in a fixed order."""

from typing import Literal

from sjdsl.compiler import ast, ir
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors, guesses, limits
from sjdsl.compiler.diagnostics.problems import Poisoned, Problems
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate.hidden import is_of_a_plane
from sjdsl.compiler.elaborate.observation_help import labels as example_labels
from sjdsl.compiler.elaborate.observation_help import no_agent_field, no_cell_field, of_a_kind, of_group, without_field
from sjdsl.compiler.elaborate.scope import Declared, Scope, Static
from sjdsl.compiler.ir.types import element, words
from sjdsl.runtime.actions import HEADINGS

SIDES = ("ahead", "behind", "left", "right")
What = Literal["cell", "own", "other", "everyone", "world", "heading"]
OWNERS: dict[str, What] = {
    "agent": "own",
    "other": "other",
    "everyone": "everyone",
}  # how a path to a field of agents begins -> what is seen
Key = tuple[What, str, str]  # what, kind, field


def window(game: Composition, scope: Scope) -> ir.Window:
    """Returns the window; 9 ahead, 1 behind, 5 to each side unless the game says otherwise."""
    sides = {"ahead": 9, "behind": 1, "left": 5, "right": 5}
    if game.window is None:
        return _window(sides)
    for i, (name, tree) in enumerate(game.window.sides):
        if name.text in [n.text for n, _ in game.window.sides[:i]]:
            scope.problems.add(errors.WrittenTwice(name.span, what=f"`{name.text}`"))
        if name.text not in SIDES:
            scope.problems.unknown(name, SIDES, "the sides of a window", guesses.SIDES)
            continue
        with scope.problems.survive():
            value = scope.fixed(tree, "the window")
            if value != int(value) or not 0 <= value <= limits.MAX_WINDOW:
                raise scope.problems.fail(
                    errors.OutOfLimits(tree.span, name=f"the window {name.text}", value=value, low=0, high=limits.MAX_WINDOW)
                )
            sides[name.text] = int(value)
    return _window(sides, game.window.span)


def _window(sides: dict[str, int], origin: Span | None = None) -> ir.Window:
    return ir.Window(ahead=sides["ahead"], behind=sides["behind"], left=sides["left"], right=sides["right"], origin=origin)


def observables(game: Composition, static: Static, problems: Problems) -> tuple[ir.Observable, ...]:
    """Returns what is seen: word fields of cells and others' headings unless hidden, and all that is shown."""
    seen: dict[Key, ir.Observable] = {}
    for kind, fields in static.kinds.items():
        for field in fields.values():
            if field.type.kind == "word" and not field.type.by:
                seen["cell", kind, field.name] = ir.Observable(
                    what="cell", kind=kind, field=field.name, type=field.type, origin=field.origin
                )
    seen["heading", "", ""] = ir.Observable(what="heading", type=words(HEADINGS))
    for observable in game.observables.values():
        with problems.survive():
            if isinstance(observable, ast.Show):
                _show(observable, seen, static, problems)
            elif not is_of_a_plane(observable, static):
                _hide(observable, seen, static, problems)
    _put_looks(seen, game, problems)
    order = ("cell", "heading", "other", "everyone", "own", "world")
    return tuple(entry for what in order for key, s in seen.items() if key[0] == what for entry in _entries(s))


def _put_looks(seen: dict[Key, ir.Observable], game: Composition, problems: Problems) -> None:
    """Leaves of a kind that is shown as a whole nothing else; its labels are words of their own, or kinds without anything more to see."""
    whole = {kind for what, kind, field in seen if what == "cell" and not field}
    for observable in game.observables.values():
        kind = observable.what.name.text
        if kind in whole and observable.what.steps and not (isinstance(observable, ast.Hide) and observable.condition is None):
            problems.add(
                errors.WrittenTwice(observable.span, what=f"what is seen of cells of `{kind}` (here, and in `show {kind} as {{ … }}`)")
            )
    for key in [k for k in seen if k[0] == "cell" and k[1] in whole and k[2]]:
        del seen[key]
    detailed = {kind: field for what, kind, field in seen if what == "cell" and field}
    for kind in whole:
        for label in seen["cell", kind, ""].labels:
            if label.name in detailed:
                given = f"a kind whose cells do not all look alike: its `{detailed[label.name]}` is seen"
                help = f"choose another word, or say with `show {label.name} as {{ … }}` how its cells look"
                problems.add(errors.WrongType(label.span, wanted="one look", given=given, help=help))


def _entries(observable: ir.Observable) -> list[ir.Observable]:
    """A `by` field is seen entry by entry."""
    if not observable.type.by:
        return [observable]
    one = element(observable.type)
    return [observable.model_copy(update={"type": one, "word": word}) for word in observable.type.by[0]]


def _resolve(observable: ast.Show | ast.Hide, static: Static, problems: Problems) -> tuple[Key, ir.VarField | None]:
    """Returns which observable a path names: `agent.f`, `other.f`, `everyone.f`, `other.heading`, `kind.f`, or a world field."""
    path = observable.what
    head = path.name.text
    members = [s.name for s in path.steps if isinstance(s, ast.Member)]
    if len(members) != len(path.steps) or len(members) > 1:
        raise problems.fail(
            errors.WrongType(path.span, wanted="`agent.field`, `other.field`, `everyone.field` or `kind.field`", given="another path")
        )
    if not members:
        if head in static.kinds:
            return ("cell", head, ""), None
        if head not in static.fields:
            raise without_field(observable, static, problems)
        static.used.add(Declared(head))
        return ("world", "", head), static.fields[head]
    name = members[0]
    if Declared(name.text, "agent" if head in OWNERS else head) in static.broken:
        raise Poisoned
    if head in OWNERS:
        if head == "other" and name.text == "heading":
            return ("heading", "", ""), None
        if name.text not in static.agent_fields:
            raise no_agent_field(head, name, static, problems)
        return (OWNERS[head], "", name.text), static.agent_fields[name.text]
    if head in static.groups:
        raise of_group(observable, name, static, problems)
    if head not in static.kinds:
        raise problems.unknown(path.name, [*OWNERS, *static.kinds], "what has fields")
    fields = static.kinds[head]
    if name.text not in fields:
        raise no_cell_field(head, name, fields, problems)
    return ("cell", head, name.text), fields[name.text]


def _show(show: ast.Show, seen: dict[Key, ir.Observable], static: Static, problems: Problems) -> None:
    key, field = _resolve(show, static, problems)
    what, kind, name = key
    if what == "cell" and not name:
        seen[key] = _look(show, kind, static, problems)
        return
    if field is None:
        return
    static.used.add(Declared(name, "agent" if what in OWNERS.values() else kind))
    labels = _labels(show, what, kind, static, problems)
    type_ = field.type
    if not labels and type_.kind in ("agent", "agents"):
        told = example_labels(path_text(show.what), type_.kind)
        raise problems.fail(
            errors.WrongType(
                show.span,
                wanted="a field with labels",
                given="a field that holds agents, whose numbers mean nothing to an observer",
                help=f"write `show {path_text(show.what)}{told}`",
            )
        )
    if not labels and type_.kind in ("int", "real") and (type_.unit == "reward" or type_.low < 0):
        help_ = f"show it with labels, `show {path_text(show.what)}{example_labels(path_text(show.what), type_.kind)}`"
        raise problems.fail(errors.Unsupported(show.span, what="showing a number that is not a count from 0 to 255", help=help_))
    if what == "cell" and not labels and type_.kind != "word":
        help_ = f"write `show {path_text(show.what)}{example_labels(path_text(show.what), type_.kind)}`"
        raise problems.fail(errors.Unsupported(show.span, what="showing a number of a cell without labels", help=help_))
    seen[key] = ir.Observable(what=what, kind=kind, field=name, type=type_, labels=labels, origin=show.span)


def _look(show: ast.Show, kind: str, static: Static, problems: Problems) -> ir.Observable:
    """Returns how cells of a kind look: like the first label whose condition holds."""
    if not show.labels:
        help = of_a_kind(kind, "show", static)
        raise problems.fail(errors.WrongType(show.span, wanted=f"what cells of `{kind}` look like", given="a kind without it", help=help))
    labels = _labels(show, "cell", kind, static, problems)
    names = tuple(dict.fromkeys(label.name for label in labels))
    return ir.Observable(what="cell", kind=kind, type=words(names), labels=labels, origin=show.span)


def path_text(path: ast.Path) -> str:
    """Returns a path of names as it is written."""
    return ".".join([path.name.text, *(s.name.text for s in path.steps if isinstance(s, ast.Member))])


def _scope(what: str, kind: str, static: Static, problems: Problems) -> Scope:
    scope = Scope(static, problems, part="observe").bind("agent", ir.Member(name="agent", who="agent"))
    if what == "cell":
        return scope.bind(kind, ir.Member(name=kind, who="cell", kinds=(kind,)))
    if what in ("other", "heading"):
        return scope.bind("other", ir.Member(name="other", who="agent"))
    if what == "everyone":
        return scope.bind("everyone", ir.Member(name="everyone", who="agent"))
    return scope


def _labels(show: ast.Show, what: str, kind: str, static: Static, problems: Problems) -> tuple[ir.Label, ...]:
    found = []
    for i, label in enumerate(show.labels):
        last = i == len(show.labels) - 1
        if last != (label.where is None):
            raise problems.fail(
                errors.LastLabelConditional(label.span) if last else errors.LabelUnconditional(label.span, name=label.label.text)
            )
        test = None if label.where is None else _scope(what, kind, static, problems).condition(label.where)
        found.append(ir.Label(name=label.label.text, condition=test, origin=label.span))
    return tuple(found)


def _hide(hide: ast.Hide, seen: dict[Key, ir.Observable], static: Static, problems: Problems) -> None:
    key, _ = _resolve(hide, static, problems)
    if key[0] == "cell" and not key[2]:
        help = of_a_kind(key[1], "hide", static)
        raise problems.fail(errors.WrongType(hide.what.span, wanted="something that is seen of cells", given="a kind", help=help))
    if hide.condition is None:
        seen.pop(key, None)
        return
    test = _scope(key[0], key[1], static, problems).condition(hide.condition)
    if key not in seen:
        problems.add(errors.NeverHappens(hide.span, problem="it is not seen anyway"))
        return
    seen[key] = seen[key].model_copy(update={"hidden_when": test})
