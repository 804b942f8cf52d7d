"""Where names stand in one file, and what each of them means: declarations, uses, and local names in their scopes."""

from collections.abc import Iterable

from sjdsl.compiler import ast
from sjdsl.editor.names import Names, Occurrence, Symbol
from sjdsl.editor.scoped import NO_NAMES, Reader


def occurrences(file: ast.File, names: Names) -> list[Occurrence]:
    """Returns every name of a file that stands for something declared in the game, in the order of the text."""
    reader = Reader(names)
    reader.declare(file.game.name, "game")
    for section in file.game.sections:
        _section(section, reader)
    found = {(o.span.start, o.symbols): o for o in sorted(reader.found, key=lambda o: not o.declares)[::-1]}
    return sorted(found.values(), key=lambda o: o.span.start)


def at(found: Iterable[Occurrence], offset: int) -> Occurrence | None:
    """Returns the name at a place of the text, or just before it."""
    here = [o for o in found if o.span.start <= offset <= o.span.end]
    return max(here, key=lambda o: o.span.start) if here else None


def _section(s: ast.Section | ast.Override | ast.Drop, r: Reader) -> None:
    match s:
        case ast.Constant():
            _constant(s, r)
        case ast.Episode():
            r.expression(s.steps, NO_NAMES)
        case ast.Kind():
            r.declare(s.name, "name")
            _attributes(s.attributes, s.name.text, r)
        case ast.Group():
            r.declare(s.name, "name")
            for kind in s.kinds:
                r.shared(kind)
        case ast.Field() | ast.Timer():
            r.declare(s.name, "name")
            _field(s, r)
        case ast.Agents():
            if s.number is not None:
                r.expression(s.number, NO_NAMES)
            _attributes(s.attributes, "agent", r)
        case ast.Movers():
            r.declare(s.name, "name")
            r.expression(s.number, NO_NAMES)
            _attributes(s.attributes, s.name.text, r)
        case ast.Shape():
            r.declare(s.name, "shape")
            if s.call is not None:
                r.expressions(s.call.arguments, NO_NAMES)
        case ast.Define():
            r.declare(s.name, "name")
            r.expression(s.value, r.bound(s.parameters, NO_NAMES))
        case ast.Schedule():
            for turn in s.turns:
                r.use(turn.name, "phase")
                for argument in turn.arguments:
                    r.argument(argument)
        case ast.Phase():
            r.declare(s.name, "phase")
            r.block(s.block, r.bound(s.parameters, NO_NAMES))
        case ast.Variant():
            r.declare(s.name, "variant")
            for change in s.changes:
                _section(change, r)
        case ast.Override():
            r.path(s.path, NO_NAMES)
            r.value(s.value, NO_NAMES)
        case ast.Drop():
            _drop(s.name, r)
        case _:
            _observed(s, r)


def _observed(s: ast.Section | ast.Override | ast.Drop, r: Reader) -> None:
    """What is seen, measured, checked and played."""
    match s:
        case ast.Observe():
            for observable in s.observables:
                _observable(observable, r)
        case ast.Look():
            r.shared(s.what)
            if s.where is not None:
                r.expression(s.where, NO_NAMES)
        case ast.Metrics():
            for metric in s.metrics:
                r.declare(metric.name, "metric")
                if isinstance(metric, ast.Measure):
                    r.expression(metric.value, NO_NAMES)
                else:
                    r.by(metric.by)
        case ast.Checks():
            if s.name is not None:
                r.declare(s.name, "checks")
            for check in s.checks:
                _check(check, r)
        case ast.ScriptedPolicy():
            r.declare(s.name, "policy")
            for rule in s.rules:
                _rule(rule, r)
        case ast.Scenario():
            r.declare(s.name, "scenario")
            for slots in s.slots:
                r.expression(slots.number, NO_NAMES)
                if slots.policy is not None:
                    r.use(slots.policy, "policy")


def _constant(s: ast.Constant, r: Reader) -> None:
    r.declare(s.name, "name")
    r.by(s.by)
    r.value(s.value, NO_NAMES)
    for limit in (s.low, s.high):
        if limit is not None:
            r.expression(limit, NO_NAMES)


def _attributes(attributes: Iterable[object], owner: str, r: Reader) -> None:
    for a in attributes:
        match a:
            case ast.Field() | ast.Timer():
                r.declare(a.name, "field", owner)
                _field(a, r)
            case ast.Blocks():
                for what in a.what:
                    r.use(what, "shape")
                    r.shared(what)
                if a.condition is not None:
                    r.expression(a.condition, NO_NAMES)
            case ast.Glyph():
                for name, value in a.starts:
                    r.use(name, "field", owner)
                    r.value(value, NO_NAMES)
            case ast.Acts():
                _acts(a, r)
            case ast.Forbid():
                scope = NO_NAMES
                for action in a.actions:
                    scope = r.binding_action(action, scope)
                r.expression(a.condition, scope)


def _field(s: ast.Field | ast.Timer, r: Reader) -> None:
    if isinstance(s, ast.Field):
        r.by(s.by)
        r.type(s.type)
        if s.start is not None:
            r.expression(s.start, NO_NAMES)


def _acts(acts: ast.Acts, r: Reader) -> None:
    for action in acts.actions:
        r.declare(action.name, "action")
        for argument in action.arguments:
            if argument.name is not None:
                r.declare(argument.name, "argument", action.name.text)
            r.type(argument.type)


def _observable(s: ast.Window | ast.Show | ast.Hide, r: Reader) -> None:
    match s:
        case ast.Window():
            r.expressions([value for _, value in s.sides], NO_NAMES)
        case ast.Show():
            r.path(s.what, NO_NAMES)
            for label in s.labels:
                if label.where is not None:
                    r.expression(label.where, NO_NAMES)
        case ast.Hide():
            r.path(s.what, NO_NAMES)
            if s.on is not None:
                r.shared(s.on)
    if s.condition is not None:
        r.expression(s.condition, NO_NAMES)


def _check(s: ast.Check, r: Reader) -> None:
    match s:
        case ast.Require() | ast.Always():
            r.expression(s.condition, NO_NAMES)
        case ast.Once():
            r.expressions((s.trigger, s.condition), NO_NAMES)
        case ast.Conserved():
            r.expression(s.value, NO_NAMES)
        case ast.Monotone():
            r.shared(s.value)
            r.shared(s.argument)
        case ast.Symmetric():
            r.shared(s.what)
        case ast.Expect():
            r.expression(s.condition, NO_NAMES)
            for policy in s.policies:
                r.use(policy.name, "policy")
                for action in policy.actions:
                    r.use(action, "action")
                if policy.domain is not None:
                    r.domain(policy.domain, NO_NAMES)


def _rule(s: ast.Act | ast.Go | ast.Aim, r: Reader) -> None:
    match s:
        case ast.Act():
            r.expression(s.condition, NO_NAMES)
            r.action(s.action, NO_NAMES)
        case ast.Go():
            r.domain(s.domain, NO_NAMES)
        case ast.Aim():
            r.shape(s.shape, NO_NAMES)
            r.action(s.action, r.domain(s.domain, NO_NAMES))
    if isinstance(s, ast.Go | ast.Aim) and s.avoided is not None:
        r.domain(s.avoided, NO_NAMES)


def _drop(name: ast.Name, r: Reader) -> None:
    """A change takes away what first has the name, as `compose` looks for it."""
    spaces = ("name", "shape", "phase", "metric", "checks", "policy", "scenario", "field", "variant")
    for space in spaces:
        symbol = Symbol(space, name.text, "agent" if space == "field" else "")  # type: ignore[arg-type]
        if r.names.has(symbol):
            r.found.append(Occurrence(name.span, (symbol,)))
            return
