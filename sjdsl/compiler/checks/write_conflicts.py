"""Write conflicts: refuses two writes in one phase unless they are provably one, equal, exclusive or commuting.

A write is looked at with everything around it: the quantifiers (each gives instances), the branches taken, and the
conditions known to hold. Two writes of one field can only meet at one target, so conditions about the target decide.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import field, replace
from typing import Literal

from sjdsl.compiler import ir
from sjdsl.compiler.checks.writes import Branch, Quantifier, Target, Write
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import Label
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.ir.equivalence import Form, form
from sjdsl.compiler.ir.free_variables import renamed
from sjdsl.compiler.ir.implications import Fact, conjuncts, contradict, facts, narrowed
from sjdsl.compiler.ir.printer import expression as text
from sjdsl.compiler.ir.queries import body_sort, declared_field, phases_of, written_field
from sjdsl.compiler.ir.types import integer


def _place(who: ir.Expr) -> Target:
    return Target("place", body_sort(who).name)


class Around(Record):
    """What surrounds a statement. `locals`: the variables each `let` and `draw` depends on (`draw` on itself); `lanes`: of each shape."""

    quantifiers: tuple[Quantifier, ...] = ()
    branches: tuple[Branch, ...] = ()
    facts: tuple[Fact, ...] = ()
    locals: dict[str, frozenset[str]] = field(default_factory=dict)
    lanes: dict[str, int] = field(default_factory=dict)
    forbids: tuple[ir.Forbid, ...] = ()

    def knowing(self, known: Iterable[Fact]) -> "Around":
        """Returns this with more that is known; of an agent that chose an action, also that it was not forbidden to."""
        found = tuple(known)
        return replace(self, facts=(*self.facts, *found, *(new for f in found for new in not_forbidden(f.condition, self.forbids))))


def check_conflicts(game: ir.Game, problems: Problems) -> None:
    """Reports every pair of writes of one phase that could disagree, and `move` beside other statements."""
    for phase in phases_of(game):
        _check_phase(phase, game, problems)


def _check_phase(phase: ir.Phase, game: ir.Game, problems: Problems) -> None:
    around = Around(lanes={s.name: len(s.lanes) for s in game.shapes}, forbids=game.agents.forbids)
    writes = [replace(w, bounded=w.bounded and not _is_capped(w, game)) for w in _writes(phase.body, around)]
    for write in writes:
        if not _agrees_with_itself(write):
            _report(write, write, phase, problems)
        elif write.bounded and not is_own(write):
            _report_range(write, game, problems)
    for i, a in enumerate(writes):
        for b in writes[i + 1 :]:
            if _same_target(a, b) and _meet(a, b) and not _compatible(a, b):
                _report(a, b, phase, problems)
    moves = [s for s in _all(phase.body) if isinstance(s, ir.Move)]
    if moves and (len(phase.body) > 1 or phase.body[0] is not moves[0]):
        problems.add(errors.MoveAlone(moves[0].span))


def _all(body: tuple[ir.Stmt, ...]) -> Iterator[ir.Node]:
    for s in body:
        yield from ir.walk(s)


def _writes(body: tuple[ir.Stmt, ...], around: Around) -> Iterator[Write]:
    for s in body:
        match s:
            case ir.Let():
                around = replace(around, locals={**around.locals, s.name: _names(s.value, around)})
            case ir.Draw():
                around = replace(around, locals={**around.locals, s.name: frozenset({f"draw {s.name}"})})
            case ir.Each() | ir.Pick() | ir.First():
                yield from _quantified(s, around)
            case ir.Match():
                left, right = s.left, s.right
                known = tuple(f for d in (left, right) if d.where is not None for f in facts(d.where))
                quantifier = Quantifier(s, (*_bound(left), *_bound(right)), single=False)
                inner = replace(around, quantifiers=(*around.quantifiers, quantifier)).knowing(known)
                yield from _writes(s.body, inner)
            case ir.When() | ir.Chance():
                yield from _branched(s, around)
            case ir.Set():
                yield _field_write("set", s, s.target, s.value, around)
            case ir.Add():
                yield _field_write("add", s, s.target, s.value, around)
            case ir.Send():
                value = ("send", s.pool, None if s.after is None else form(s.after), s.facing, s.stay)
                depends = _names(s.domain, around) | (frozenset() if s.after is None else _names(s.after, around))
                yield _write("place", _place(s.who), (), s.who, value, depends, s, around)
                if body_sort(s.who).what == "mover" and s.facing != "same":  # the heading of a mover is a field
                    yield _write("set", Target("mover", "heading"), body_sort(s.who).names, s.who, value, depends, s, around)
            case ir.Shift():
                parts = (s.to, s.steps, s.heading, s.other)
                by: Form = ("shift", s.quarters, s.facing, *(None if part is None else form(part) for part in parts))
                depends = frozenset(name for part in parts if part is not None for name in _names(part, around))
                yield _write("place", _place(s.who), (), s.who, by, depends, s, around)
                if body_sort(s.who).what == "mover" and s.facing != "same":
                    yield _write("set", Target("mover", "heading"), body_sort(s.who).names, s.who, by, depends, s, around)
            case ir.Remove():
                yield _write("place", _place(s.who), (), s.who, ("remove",), frozenset(), s, around)
            case _:
                pass


def _bound(d: ir.Domain) -> tuple[ir.Member, ...]:
    return (d.var,) if d.on is None else (d.var, d.on)


def _quantified(s: ir.Each | ir.Pick | ir.First, around: Around) -> Iterator[Write]:
    known = (*_standing(s.domain), *(() if s.domain.where is None else facts(s.domain.where)))
    if isinstance(s, ir.First):
        single = isinstance(s.domain.restriction, ir.Near) and around.lanes[s.domain.restriction.shape] <= 1
    else:
        single = isinstance(s, ir.Pick) and isinstance(s.number, ir.Number) and s.number.value <= 1
    inner = replace(around, quantifiers=(*around.quantifiers, Quantifier(s, _bound(s.domain), single))).knowing(known)
    other = around
    if isinstance(s, ir.First) and not single:  # both ways can be taken, each in some lanes
        other = replace(around, quantifiers=(*around.quantifiers, Quantifier(s, (), single)))
    else:
        inner = replace(inner, branches=(*around.branches, _branch(s, 0, around)))
        other = replace(around, branches=(*around.branches, _branch(s, 1, around)))
    yield from _writes(s.body, inner)
    if not isinstance(s, ir.Each):
        yield from _writes(s.otherwise, other)


def _standing(d: ir.Domain) -> tuple[Fact, ...]:
    """Returns what `agent on kind` says of the agent."""
    return () if d.on is None else (Fact(ir.StandsOn(agent=d.var, kinds=d.on.kinds)),)


def _branch(s: ir.Stmt, way: int, around: Around) -> Branch:
    return Branch(s, way, all(q.single for q in around.quantifiers))


def _branched(s: ir.When | ir.Chance, around: Around) -> Iterator[Write]:
    known = around
    for number, branch in enumerate(s.branches):
        here = known.knowing(facts(branch.test) if isinstance(s, ir.When) else ())
        yield from _writes(branch.body, replace(here, branches=(*around.branches, _branch(s, number, around))))
        if isinstance(s, ir.When):
            known = known.knowing(facts(branch.test, holds=False))
    last = _branch(s, len(s.branches), around)
    yield from _writes(s.otherwise, replace(known, branches=(*around.branches, last)))


def _names(e: ir.Node, around: Around) -> frozenset[str]:
    """Returns the variables a value depends on; those its own quantifiers bind are not outside it."""
    found: set[str] = set()
    inner: set[str] = set()
    for node in ir.walk(e):
        match node:
            case ir.Domain():
                inner |= {m.name for m in _bound(node)}
            case ir.Member():
                found.add(node.name)
            case ir.Local():
                found |= around.locals.get(node.name, {node.name})
    return frozenset(found - inner)


def _field_write(sort: Literal["set", "add"], s: ir.Set | ir.Add, target: ir.Expr, value: ir.Expr, around: Around) -> Write:
    entries: list[str | None] = []
    keys: list[ir.Member | None] = []
    depends = _names(value, around)
    while isinstance(target, ir.At):
        entries.insert(0, str(target.key.value) if isinstance(target.key, ir.Word | ir.Number) else None)
        keys.insert(0, target.key if isinstance(target.key, ir.Member) else None)
        depends |= frozenset() if isinstance(target.key, ir.Member) else _names(target.key, around)
        target = target.row
    assert isinstance(target, ir.FieldRead)
    written = Target(target.held_by.what, target.name, tuple(entries))
    uncapped = sort == "add" and target.type.kind == "int"
    made = _write(sort, written, target.held_by.names, target.owner, form(value), depends, s, around)
    quantifiers = tuple(replace(q, single=q.single or is_of_one_agent(q, around.facts)) for q in made.quantifiers)
    return replace(made, bounded=uncapped, keys=tuple(keys), quantifiers=quantifiers)


def _write(
    sort: Literal["set", "add", "place"],
    target: Target,
    kinds: tuple[str, ...],
    owner: ir.Expr | None,
    value: Form,
    depends: frozenset[str],
    s: ir.Stmt,
    around: Around,
) -> Write:
    return Write(sort, target, kinds, owner, value, depends, s, around.quantifiers, around.branches, around.facts)


def is_own(w: Write) -> bool:
    """Returns whether every target is written by one instance: it is the variable of the only quantifier that multiplies.

    A quantifier that gives at most one instance for each of those around it does not multiply.
    """
    if any(w.keys) and _owns_entries(w):
        return True
    if w.owner is None:
        return all(q.single for q in w.quantifiers)
    if not isinstance(w.owner, ir.Member):
        return False
    names = {w.owner.name}
    quantifiers = list(w.quantifiers)
    while quantifiers:
        quantifier = quantifiers.pop()
        if not any(m.name in names for m in quantifier.binds):
            if not quantifier.single:
                return False
            continue
        alone = all(q.single for q in quantifiers)
        domain = None if isinstance(quantifier.statement, ir.Match) else quantifier.statement.domain  # type: ignore[union-attr]
        restriction = None if domain is None else domain.restriction
        if isinstance(restriction, ir.Among) and quantifiers and isinstance(quantifiers[-1].statement, ir.Match):
            names = {m.name for m in restriction.members}
        elif restriction is None or quantifier.single:
            return alone
        else:
            return False
    return False


def _owns_entries(w: Write) -> bool:
    """Returns whether every entry is written by one instance: its owner and its keys together name all that multiplies."""
    if w.owner is not None and not isinstance(w.owner, ir.Member):
        return False
    names = set(w.own_names)
    for number, quantifier in reversed(list(enumerate(w.quantifiers))):
        if quantifier.single:
            continue
        if isinstance(quantifier.statement, ir.First) or not any(m.name in names for m in quantifier.binds):
            return False  # two lanes can reach one member
        if isinstance(quantifier.statement, ir.Each) and isinstance(quantifier.statement.domain.restriction, ir.Among):
            if number and isinstance(w.quantifiers[number - 1].statement, ir.Match):  # a side of a pair names the pair
                names |= {m.name for m in quantifier.statement.domain.restriction.members}
    return True


def _agrees_with_itself(w: Write) -> bool:
    if w.sort == "add" or _is_by_lot(w):
        return True
    if is_own(w):
        return True
    return not (w.depends - w.own_names)


def _is_by_lot(w: Write) -> bool:
    return isinstance(w.statement, ir.Set) and w.statement.lot is not None


def _same_target(a: Write, b: Write) -> bool:
    if (a.target.of, a.target.name) != (b.target.of, b.target.name):
        return False
    return all(x == y or None in (x, y) for x, y in zip(a.target.entries, b.target.entries, strict=False))


def _meet(a: Write, b: Write) -> bool:
    return not (a.kinds and b.kinds) or bool(set(a.kinds) & set(b.kinds))


def _compatible(a: Write, b: Write) -> bool:
    if a.sort == b.sort == "add":
        return not (a.bounded or b.bounded) or _exclusive(a, b)
    if _is_by_lot(a) and _is_by_lot(b) and len(a.target.entries) == len(b.target.entries):
        return True  # all who would write one target draw together
    if a.sort == b.sort and a.value == b.value and not (a.depends | b.depends):
        return True
    return _exclusive(a, b)


def _exclusive(a: Write, b: Write) -> bool:
    """Returns whether the two writes can never reach the same target in one phase."""
    apart = [x for x in a.branches for y in b.branches if x.statement is y.statement and x.way != y.way]
    if any(x.once for x in apart):
        return True
    if is_own(a) and is_own(b):
        if apart and _shared_quantifier(a, b):
            return True
        if _two_sides(a, b):
            return True
    return any(contradict(x, y) for x in a.about_target for y in b.about_target)


def _shared_quantifier(a: Write, b: Write) -> bool:
    """Returns whether both targets are the variable of one and the same quantifier, or entries named by those of the same quantifiers."""
    if any(a.keys) or any(b.keys):
        alike = [None if m is None else m.name for m in a.keys] == [None if m is None else m.name for m in b.keys]
        return alike and a.own_names == b.own_names and _multiplying(a) == _multiplying(b)
    if a.owner is None and b.owner is None:
        return True
    same = isinstance(a.owner, ir.Member) and isinstance(b.owner, ir.Member) and a.owner.name == b.owner.name
    return same and bool(a.quantifiers) and bool(b.quantifiers) and a.quantifiers[0].statement is b.quantifiers[0].statement


def _multiplying(w: Write) -> list[int]:
    """Returns the quantifiers that can give several instances, by their identity."""
    return [id(q.statement) for q in w.quantifiers if not q.single]


def _two_sides(a: Write, b: Write) -> bool:
    """Returns whether the targets are the two sides of one `match`: always different members."""
    if not (a.quantifiers and b.quantifiers and a.quantifiers[0].statement is b.quantifiers[0].statement):
        return False
    if not isinstance(a.quantifiers[0].statement, ir.Match) or len(a.quantifiers) != 1 or len(b.quantifiers) != 1:
        return False
    return isinstance(a.owner, ir.Member) and isinstance(b.owner, ir.Member) and a.owner.name != b.owner.name


def _name(w: Write) -> str:
    if w.sort == "place":
        return "the place"
    return w.target.name if w.owner is None else f"{text(w.owner)}.{w.target.name}"


def _report(a: Write, b: Write, phase: ir.Phase, problems: Problems) -> None:
    span, other = b.statement.origin, a.statement.origin
    assert span is not None and other is not None
    labels = () if a is b else (Label(other, "the other write is here"),)
    if a.sort == b.sort == "place":
        who = "an agent" if a.target.name == "agent" else f"a mover `{a.target.name}`"
        problems.add(errors.TwoDestinations(span, labels=labels, phase=phase.label, who=who))
    elif {a.sort, b.sort} == {"set", "add"}:
        problems.add(errors.AddAndSet(span, labels=labels, name=_name(b), phase=phase.label))
    else:
        owner = a.target.name if a.target.of == "place" else a.target.of
        found = errors.WriteConflict(span, labels=labels, name=_name(b), owner=owner, phase=phase.label, lot=_lots_apart(a, b))
        problems.add(found)


def _lots_apart(a: Write, b: Write) -> str:
    """Returns what to write where two writes cannot draw lots together; nothing where neither is `by lot`."""
    if _is_by_lot(a) and _is_by_lot(b):
        return "those who draw lots together write the same: let both set the whole row, or both an entry of it"
    return "write `by lot` behind both, and all who would write it draw lots together" if _is_by_lot(a) or _is_by_lot(b) else ""


def _report_range(w: Write, game: ir.Game, problems: Problems) -> None:
    """An `add` that several instances can make at once is provably in range only if the field is capped (or endless)."""
    assert isinstance(w.statement, ir.Add) and w.statement.origin is not None
    declared = declared_field(game, written_field(w.statement.target))
    type_, reached = declared.type, "the sum of several adds"
    found = errors.FieldRange(w.statement.origin, name=_name(w), declared=declared.name, low=type_.low, high=type_.high, reached=reached)
    problems.add(found)


def _is_capped(w: Write, game: ir.Game) -> bool:
    return isinstance(w.statement, ir.Add) and declared_field(game, written_field(w.statement.target)).capped


def _is_lasting(node: ir.Node) -> bool:
    """Returns whether a part of a condition on an agent has one value throughout an episode: its number, and numbers of the game."""
    match node:
        case ir.Attribute():
            return node.name == "index"
        case ir.Member() | ir.ParamRef() | ir.Number() | ir.Arithmetic() | ir.Compare() | ir.InRange() | ir.Not() | ir.Logic() | ir.Named():
            return True
        case _:
            return False


def not_forbidden(condition: ir.Expr, forbids: Iterable[ir.Forbid]) -> Iterator[Fact]:
    """Yields what is known of an agent that chose an action: what holds now as it did before the step, when it was not forbidden."""
    if isinstance(condition, ir.Chose) and isinstance(condition.agent, ir.Member):
        for forbid in forbids:
            if condition.action in forbid.actions and not forbid.names:
                parts = conjuncts(renamed(forbid.condition, {"agent": condition.agent.name}), holds=False)
                yield from (fact for part in parts if all(map(_is_lasting, ir.walk(part))) for fact in facts(part))


def is_of_one_agent(quantifier: Quantifier, known: Sequence[Fact]) -> bool:
    """Returns whether all that is known leaves one agent, or one mover, to an `each`."""
    if not isinstance(quantifier.statement, ir.Each) or quantifier.statement.domain.var.sort.what == "cell":
        return False
    index = ir.Attribute(type=integer(0, float("inf"), "number"), owner=quantifier.statement.domain.var, name="index")
    low, high = narrowed(index, known)
    return low == high
