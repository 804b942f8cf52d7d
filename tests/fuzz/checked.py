"""Random `metrics`, `checks` and `observe`."""

from collections.abc import Sequence
from dataclasses import replace

from tests.fuzz.conditions import condition
from tests.fuzz.declared import Field, Lines, World
from tests.fuzz.members import domain
from tests.fuzz.quantities import integer, real
from tests.fuzz.reading import Scope, Variable
from tests.fuzz.statements import braces
from tests.fuzz.writing import HEADING

ATTRIBUTES = ("index", "heading", "moved", "row", "col")
LABELS = ("near_by", "far_off", "mine", "theirs")


def metrics(w: World) -> Lines:
    """Declares the events, and a few numbers over the state."""
    lines = [f"event {e.name}" + (f" by {e.by}" if e.by else "") for e in w.events]
    for i in range(w.random.choice((0, 1, 2))):
        scope = Scope(w, "metric")
        text, _ = integer(scope, "count", 3) if w.is_now(0.5) else real(scope, "reward", 3)
        lines.append(f"{w.random.choice(('mean', 'final'))} value_{'abc'[i]} = {text}")
    return braces("metrics", lines)


def checks(w: World) -> list[Lines]:
    """Checks of every sort; only those about numbers matter to how the game is compiled."""
    lines = [f"require {test}" for test in w.requires]
    lines += [f"require {d}(dilemma)" for d in w.dilemmas]
    scope = Scope(w, "check")
    if w.is_now(0.3):
        text, _ = integer(scope, "count", 2)
        lines += [f"always {condition(scope, 2)}", f"conserved {text}"]
    if w.is_now(0.2):
        lines.append(f"once {condition(scope, 1)} always {condition(scope, 1)}")
    if w.is_now(0.2):
        number, _ = integer(scope, "count", 1)
        lines.append(f"always before({number}) <= {number} or before({condition(scope, 1)})")
    numbers = [d.name for d in w.defines if not d.parameters and d.type.kind in ("int", "real")]
    if numbers and w.is_now(0.5):
        lines.append(
            f"monotone {numbers[0]} {w.random.choice(('falling', 'rising'))} in {numbers[-1]}"
        )
    if w.is_now(0.2):
        lines.append(f"symmetric {w.random.choice(('agents', *w.movers))}")
    if w.is_now(0.3):
        event = w.random.choice(w.events)
        name = (
            f"{event.name}[{event.by.names[0]}]"
            if event.by and event.by.kind != "agent"
            else event.name
        )
        text, *_ = domain(scope.having(Variable("agent")), 1)
        policies = w.random.choice(
            ("random", f"never({w.actions[0]})", f"random, seek {text}", *w.policies)
        )
        lines.append(f"expect {name} >= 0 with {policies} over 5 episodes")
    return (
        [braces(w.random.choice(("checks", "checks dilemma")), lines)]
        if lines or w.is_now(0.4)
        else []
    )


def observe(w: World) -> list[Lines]:
    """Says what is seen: windows, fields shown as they are or as labels, things hidden."""
    if w.is_now(0.05):
        return []
    r = w.random
    lines = _windows(w)
    for owner, fields in (
        ("agent", w.agent_fields),
        ("other", w.agent_fields),
        ("everyone", w.agent_fields),
        ("", w.fields),
    ):
        for f in fields:
            text = f"{owner}.{f.name}" if owner else f.name
            made = (
                _observable(w, owner, f, text)
                if w.is_now(0.15 if owner == "everyone" else 0.35)
                else ""
            )
            lines += [made] if made else []
    for sort in w.movers.values():
        if w.is_now(0.15):
            lines.append(
                f"hide {sort.name}"
                + (
                    f" when {condition(_observable_scope(w, sort.name), 1)}"
                    if w.is_now(0.7)
                    else ""
                )
            )
        for f in (HEADING, *sort.fields):
            made = _observable(w, sort.name, f, f"{sort.name}.{f.name}") if w.is_now(0.3) else ""
            lines += [made] if made else []
    for owner in ("agent", "other", "everyone"):
        names = r.sample(ATTRIBUTES, 2) if w.is_now(0.3) else []
        lines += [
            _perhaps_when(w, owner, f"show {owner}.{name}")
            for name in names
            if name != "heading" or owner != "other"
        ]
    lines += [_perhaps_when(w, "everyone", "show everyone.away")] if w.is_now(0.1) else []
    lines += (
        [_perhaps_when(w, "", f"show step as {{ {_labels(w, '', LABELS)} }}")]
        if w.is_now(0.1)
        else []
    )
    for d in w.defines:
        if d.parameters in ((), ("agent",)) and w.is_now(0.3):
            name = f"{d.name}(agent)" if d.parameters else d.name
            whole = d.type.kind in ("condition", "word") or (
                d.type.kind == "int" and d.type.low >= 0 and d.type.high <= 255
            )
            labels = "" if whole else f" as {{ {_labels(w, '', LABELS)} }}"
            lines.append(_perhaps_when(w, "", f"show {name}{labels}"))
    lines += [
        f"show event {event.name}" for event in w.events[:1]
    ]  # no draw, so that the rest stays
    whole = [name for name in w.kinds if w.is_now(0.15)]
    looks = [name for name, kind in w.kinds.items() if name in whole or not kind.fields]
    for name in whole:
        lines.append(f"show {name} as {{ {_labels(w, name, (*LABELS, 'outside', *looks))} }}")
    together = {
        name: kinds
        for name, kinds in w.groups.items()
        if w.is_now(0.3) and not set(kinds) & set(whole)
    }
    for name, kinds in together.items():
        for f in w.cell_fields(kinds):
            made = _observable(w, name, f, f"{name}.{f.name}")
            lines += [made] if made else []
    alone = set(w.kinds) - set(whole) - {kind for kinds in together.values() for kind in kinds}
    for kind in (kind for name, kind in w.kinds.items() if name in alone):
        for f in kind.fields:
            made = _observable(w, kind.name, f, f"{kind.name}.{f.name}") if w.is_now(0.3) else ""
            lines += [made] if made else []
    if w.is_now(0.15):
        sometimes = f" when {_test(w, 'other')}" if w.is_now(0.6) else ""
        lines.append(f"hide other.heading{sometimes}")
    lines += [
        f"hide {what}"
        for what in ("marks", "marks on agents", "content on agents")
        if w.is_now(0.1)
    ]
    for name in w.kinds:
        if w.is_now(0.15):
            lines.append(
                f"hide marks on {name}" + (f" when {_test(w, name)}" if w.is_now(0.7) else "")
            )
    return [braces("observe", lines)] if lines or w.is_now(0.2) else []


def _windows(w: World) -> Lines:
    """Says how far agents see, perhaps some of them otherwise."""
    lines = [f"window {_sides(w, (1, 3, 4, 4))}"] if w.is_now(0.97) else []
    return lines + [
        f"window {_sides(w, (1, 2))} when {_test(w, '')}"
        for _ in range(w.random.choice((0, 0, 0, 1, 2)))
    ]


def _sides(w: World, numbers: Sequence[int]) -> str:
    r = w.random
    return ", ".join(
        f"{side} {r.randint(0, 3)}"
        for side in r.sample(("ahead", "behind", "left", "right"), r.choice(numbers))
    )


def _observable_scope(w: World, owner: str) -> Scope:
    scope = Scope(w, "observable").having(Variable("agent"))
    if owner in ("other", "everyone"):
        return scope.having(Variable(owner))
    if owner in w.movers:
        return scope.having(Variable(owner, sort=owner))
    if owner in w.kinds or owner in w.groups:
        scope = scope.having(Variable(owner, w.kinds_of(owner)))
        return replace(
            scope, bound=scope.bound | {*w.kinds_of(owner)}
        )  # what a group looks like is said for each kind, by both names
    return scope


def _test(w: World, owner: str) -> str:
    """Returns a condition; of an agent of `everyone`, who may be away, that it is here as well."""
    test = condition(_observable_scope(w, owner), 1)
    return f"not everyone.away and ({test})" if owner == "everyone" else test


def _perhaps_when(w: World, owner: str, shown: str) -> str:
    return f"{shown} when {_test(w, owner)}" if w.is_now(0.25) else shown


def _observable(w: World, owner: str, f: Field, text: str) -> str:
    cell = owner in w.kinds or owner in w.groups
    if cell and w.is_now(0.4) and f.type.kind == "word":
        return f"hide {text}" + (f" when {_test(w, owner)}" if w.is_now(0.7) else "")
    small = f.type.kind == "word" or (
        f.type.kind == "int" and f.type.low >= 0 and f.type.high <= 255 and not cell
    )
    if small and w.is_now(0.5) and not (cell and f.type.indexed_by):
        return _perhaps_when(w, owner, f"show {text}")
    if f.type.kind == "agent" and not f.type.indexed_by and w.is_now(0.6):
        return _perhaps_when(w, owner, f"show {text}")
    if f.type.indexed_by or f.timer:
        return f"show {text}" if f.timer and not cell else ""
    return _perhaps_when(w, owner, f"show {text} as {{ {_labels(w, owner, LABELS)} }}")


def _labels(w: World, owner: str, known: Sequence[str]) -> str:
    """Returns some labels with conditions, the last without one."""
    labels = w.random.sample(known, w.random.randint(1, 3))
    return ", ".join([*(f"{label} where {_test(w, owner)}" for label in labels[:-1]), labels[-1]])
