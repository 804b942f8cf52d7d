"""Random `metrics`, `checks` and `observe`."""

from collections.abc import Sequence

from tests.fuzz.conditions import condition
from tests.fuzz.declared import Field, Lines, World
from tests.fuzz.members import domain
from tests.fuzz.quantities import integer, real
from tests.fuzz.reading import Scope, Variable
from tests.fuzz.statements import braces

LABELS = ("near_by", "far_off", "mine", "theirs")


def metrics(w: World) -> Lines:
    """Declares the events, and a few numbers over the state."""
    lines = [f"event {e.name}" + (f" by {{ {', '.join(e.by)} }}" if e.by else "") for e in w.events]
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
    numbers = [d.name for d in w.defines if not d.parameters and d.type.kind in ("int", "real")]
    if numbers and w.is_now(0.5):
        lines.append(f"monotone {numbers[0]} {w.random.choice(('falling', 'rising'))} in {numbers[-1]}")
    if w.is_now(0.2):
        lines.append(f"symmetric {w.random.choice(('agents', 'mirror'))}")
    if w.is_now(0.3):
        event = w.random.choice(w.events)
        name = f"{event.name}[{event.by[0]}]" if event.by else event.name
        text, *_ = domain(scope.having(Variable("agent")), 1)
        policies = w.random.choice(("random", f"never({w.actions[0]})", f"random, seek {text}", *w.policies))
        lines.append(f"expect {name} >= 0 with {policies} over 5 episodes")
    return [braces(w.random.choice(("checks", "checks dilemma")), lines)] if lines or w.is_now(0.4) else []


def observe(w: World) -> list[Lines]:
    """Says what is seen: a window, fields shown as they are or as labels, things hidden."""
    if w.is_now(0.05):
        return []
    r = w.random
    sides = {s: r.randint(0, 3) for s in r.sample(("ahead", "behind", "left", "right"), r.choice((1, 3, 4, 4)))}
    lines = [f"window {', '.join(f'{s} {n}' for s, n in sides.items())}"] if w.is_now(0.97) else []
    shown: set[str] = set()
    for owner, fields in (("agent", w.agent_fields), ("other", w.agent_fields), ("everyone", w.agent_fields), ("", w.fields)):
        for f in fields:
            text = f"{owner}.{f.name}" if owner else f.name
            made = _observable(w, owner, f, text) if w.is_now(0.15 if owner == "everyone" else 0.35) else ""
            if made:
                lines.append(made)
                shown.add(text)
    whole = [name for name in w.kinds if w.is_now(0.15)]
    looks = [name for name, kind in w.kinds.items() if name in whole or not kind.fields]
    for name in whole:
        lines.append(f"show {name} as {{ {_labels(w, name, (*LABELS, 'outside', *looks))} }}")
    for kind in (kind for name, kind in w.kinds.items() if name not in whole):
        for f in kind.fields:
            made = _observable(w, kind.name, f, f"{kind.name}.{f.name}") if w.is_now(0.3) else ""
            lines += [made] if made else []
    if w.is_now(0.2):
        test = condition(_observable_scope(w, "other"), 1)
        lines.append("hide other.heading" + (f" when {test}" if w.is_now(0.7) else ""))
    lines += [f"hide {what}" for what in ("marks", "marks on agents", "content on agents") if w.is_now(0.1)]
    for name in w.kinds:
        if w.is_now(0.15):
            test = condition(_observable_scope(w, name), 1)
            lines.append(f"hide marks on {name}" + (f" when {test}" if w.is_now(0.7) else ""))
    return [braces("observe", lines)] if lines or w.is_now(0.2) else []


def _observable_scope(w: World, owner: str) -> Scope:
    scope = Scope(w, "observable", (Variable("agent"),))
    if owner in ("other", "everyone"):
        return scope.having(Variable(owner))
    return scope.having(Variable(owner, (owner,))) if owner in w.kinds else scope


def _observable(w: World, owner: str, f: Field, text: str) -> str:
    scope = _observable_scope(w, owner)
    cell = owner in w.kinds
    if cell and w.is_now(0.4) and f.type.kind == "word":
        return f"hide {text}" + (f" when {condition(scope, 1)}" if w.is_now(0.7) else "")
    small = f.type.kind == "word" or (f.type.kind == "int" and f.type.low >= 0 and f.type.high <= 255 and not cell)
    if small and w.is_now(0.5) and not (cell and f.type.by):
        return f"show {text}"
    if f.type.by or f.timer:
        return f"show {text}" if f.timer and not cell else ""
    return f"show {text} as {{ {_labels(w, owner, LABELS)} }}"


def _labels(w: World, owner: str, known: Sequence[str]) -> str:
    """Returns some labels with conditions, the last without one."""
    labels = w.random.sample(known, w.random.randint(1, 3))
    tests = [f"{label} where {condition(_observable_scope(w, owner), 1)}" for label in labels[:-1]]
    return ", ".join([*tests, labels[-1]])
