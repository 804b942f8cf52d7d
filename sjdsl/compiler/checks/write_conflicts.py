"""Write conflicts: refuses two writes in one phase unless they are provably one, equal, exclusive or commuting.

A write is looked at with everything around it: the quantifiers (each gives instances), the branches taken, and the
conditions known to hold. Two writes of one field can only meet at one target, so conditions about the target decide.
"""

from collections.abc import Collection, Iterable, Iterator
from dataclasses import field, replace
from functools import cached_property
from itertools import combinations
from typing import Literal

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import Label
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.ir.equivalence import Form, form
from sjdsl.compiler.ir.free_variables import free_variables, renamed
from sjdsl.compiler.ir.implications import Fact, conjuncts, contradict, facts, narrowed
from sjdsl.compiler.ir.printer import expression_text as text
from sjdsl.compiler.ir.queries import (
    body_type,
    cell_under_all,
    contains,
    declared_field,
    phases_of,
    written_field,
    written_keys,
)
from sjdsl.compiler.ir.types import has_limits, integer


class Quantifier(Record):
    """One quantifier: the statement, the variables it binds, and whether it gives at most one instance for each around it."""

    statement: ir.Stmt
    binds: tuple[ir.Member, ...]
    single: bool


class Branch(Record):
    """One way through a statement with several. `once`: the statement is met once in the phase, so only one of its ways is taken."""

    statement: ir.Stmt
    way: int
    once: bool


class Target(Record):
    """What is written: the place of an agent or a mover, or a field of something; `entries` of a row, None for any of them."""

    of: Literal["agent", "cell", "mover", "world", "place"]
    name: str = ""
    entries: tuple[str | None, ...] = ()


class Write(Record, eq=False):
    """One `set`, `add` or change of place.

    owner: whose field or place (None: the world's). keys: the agents that name an entry, None for an entry named in another way.
    value: what two equal writes share.
    """

    sort: Literal["set", "add", "place"]
    target: Target
    kinds: tuple[str, ...]
    owner: ir.Expr | None
    value: Form
    depends: frozenset[str]
    statement: ir.Stmt
    quantifiers: tuple[Quantifier, ...]
    branches: tuple[Branch, ...]
    facts: tuple[Fact, ...]
    keys: tuple[ir.Member | None, ...] = ()

    @property
    def own_names(self) -> frozenset[str]:
        """The variables that name the target: its owner, and the agents that name its entry."""
        owner = (self.owner,) if isinstance(self.owner, ir.Member) else ()
        return frozenset(member.name for member in (*owner, *self.keys) if member is not None)

    @cached_property
    def is_own(self) -> bool:
        """Whether every target is written by one instance."""
        return _is_own(self)

    @property
    def is_by_lot(self) -> bool:
        return isinstance(self.statement, ir.Set) and self.statement.lot is not None

    @cached_property
    def about_target(self) -> tuple[Fact, ...]:
        """The known conditions that speak of the target alone, under a name that two writes share."""
        if self.owner is not None and not isinstance(self.owner, ir.Member):
            return ()
        target = {
            member.name: f"entry {place}"
            for place, member in enumerate(self.keys)
            if member is not None
        }
        if self.owner is not None:
            target[self.owner.name] = "target"
        return tuple(
            Fact(f.condition, target)
            for f in self.facts
            if {v.name for v in free_variables(f.condition)} <= target.keys()
        )


class Around(Record):
    """What surrounds a statement. `locals`: the variables each `let` and `draw` depends on (`draw` on itself); `lanes`: of each shape;
    `turns_agents`: whether a statement of the phase sets the heading of agents, so that a `send` may not set another."""

    quantifiers: tuple[Quantifier, ...] = ()
    branches: tuple[Branch, ...] = ()
    facts: tuple[Fact, ...] = ()
    locals: dict[str, frozenset[str]] = field(default_factory=dict)
    lanes: dict[str, int] = field(default_factory=dict)
    forbids: tuple[ir.Forbid, ...] = ()
    turns_agents: bool = False

    def knowing(self, known: Iterable[Fact]) -> "Around":
        """Returns this with more that is known; of an agent that chose an action, also that it was not forbidden to."""
        found = tuple(known)
        return replace(
            self,
            facts=(
                *self.facts,
                *found,
                *(new for f in found for new in _not_forbidden(f.condition, self.forbids)),
            ),
        )

    def in_branch(self, s: ir.Stmt, way: int) -> "Around":
        """Returns what surrounds the statements of one way through `s`."""
        return replace(
            self, branches=(*self.branches, Branch(s, way, all(q.single for q in self.quantifiers)))
        )


def check_conflicts(game: ir.Game, problems: Problems) -> None:
    """Reports every pair of writes of one phase that could disagree, and `move` beside other statements."""
    around = Around(lanes={s.name: len(s.lanes) for s in game.shapes}, forbids=game.agents.forbids)
    for phase in phases_of(game):
        turns_agents = contains(phase, ir.Face)
        writes = list(_writes(phase.body, replace(around, turns_agents=turns_agents)))
        bounded = {write for write in writes if _is_bounded(write, game)}
        for write in writes:
            if not (
                write.sort == "add"
                or write.is_by_lot
                or write.is_own
                or not (write.depends - write.own_names)
            ):
                _report(write, write, phase, problems)
            elif (
                write in bounded and not write.is_own
            ):  # an `add` that several instances make at once is in range only if capped
                assert isinstance(write.statement, ir.Add) and write.statement.origin is not None
                declared = declared_field(game, written_field(write.statement.target))
                span = write.statement.origin
                low = declared.type.low
                high = declared.type.high
                reached = "the sum of several adds"
                problems.add(
                    errors.FieldRange(
                        span,
                        name=_target_text(write),
                        declared=declared.name,
                        low=low,
                        high=high,
                        reached=reached,
                    )
                )
        for a, b in combinations(writes, 2):
            if _same_target(a, b) and not _compatible(a, b, bounded):
                _report(a, b, phase, problems)
        move = next(
            (node for s in phase.body for node in ir.walk(s) if isinstance(node, ir.Move)), None
        )
        if move is not None and (len(phase.body) > 1 or phase.body[0] is not move):
            problems.add(errors.MoveAlone(move.span))


def _is_bounded(w: Write, game: ir.Game) -> bool:
    """Returns whether this is an `add` that has to stay in a range of numbers: not one that is `capped`."""
    if not isinstance(w.statement, ir.Add):
        return False
    if not has_limits(written_field(w.statement.target).type):
        return False
    return not declared_field(game, written_field(w.statement.target)).capped


def _writes(body: tuple[ir.Stmt, ...], around: Around) -> Iterator[Write]:
    """Yields all writes of statements. around: what holds where they stand."""
    for s in body:
        match s:
            case ir.Let():
                around = replace(around, locals={**around.locals, s.name: _names(s.value, around)})
            case ir.Draw():
                around = replace(
                    around, locals={**around.locals, s.name: frozenset({f"draw {s.name}"})}
                )
            case ir.Each() | ir.Pick() | ir.First():
                yield from _quantified(s, around)
            case ir.Match():
                known = tuple(
                    f for d in (s.left, s.right) if d.where is not None for f in facts(d.where)
                )
                quantifier = Quantifier(s, (*_bound(s.left), *_bound(s.right)), single=False)
                yield from _writes(
                    s.body,
                    replace(around, quantifiers=(*around.quantifiers, quantifier)).knowing(known),
                )
            case ir.When() | ir.Chance():
                known_here = around
                for number, branch in enumerate(s.branches):
                    here = known_here.knowing(facts(branch.test) if isinstance(s, ir.When) else ())
                    yield from _writes(branch.body, here.in_branch(s, number))
                    if isinstance(s, ir.When):
                        known_here = known_here.knowing(facts(branch.test, holds=False))
                yield from _writes(s.otherwise, known_here.in_branch(s, len(s.branches)))
            case ir.Set() | ir.Add():
                yield _field_write(s, around)
            case ir.Send():
                depends = _names(s.domain, around)
                for part in (s.after, s.way):
                    if part is not None:
                        depends |= _names(part, around)
                value = (
                    "send",
                    s.pool,
                    None if s.after is None else form(s.after),
                    s.facing,
                    None if s.way is None else form(s.way),
                    s.stay,
                )
                yield from _place_writes(s, value, depends, around)
            case ir.Shift():
                parts = (s.to, s.steps, s.heading, s.other, s.way)
                depends = frozenset(
                    name for part in parts if part is not None for name in _names(part, around)
                )
                by: Form = (
                    "shift",
                    s.quarters,
                    s.facing,
                    *(None if part is None else form(part) for part in parts),
                )
                yield from _place_writes(s, by, depends, around)
            case ir.Face():
                yield Write(
                    "set",
                    Target("agent", "heading"),
                    (),
                    s.who,
                    form(s.heading),
                    _names(s.heading, around),
                    s,
                    around.quantifiers,
                    around.branches,
                    around.facts,
                )
            case ir.Remove():
                yield from _place_writes(s, ("remove",), frozenset(), around)
            case _:
                pass


def _place_writes(
    s: ir.Send | ir.Shift | ir.Remove, value: Form, depends: frozenset[str], around: Around
) -> Iterator[Write]:
    """Yields the writes of a place: of `send`, `shift` and `remove`."""
    entity_type = body_type(s.who)
    rest = (around.quantifiers, around.branches, around.facts)
    yield Write("place", Target("place", entity_type.name), (), s.who, value, depends, s, *rest)
    if isinstance(s, ir.Remove) or s.facing == "same":
        return
    if entity_type.what == "mover":  # the heading of a mover is a field
        yield Write(
            "set", Target("mover", "heading"), entity_type.names, s.who, value, depends, s, *rest
        )
    elif around.turns_agents:
        yield Write("set", Target("agent", "heading"), (), s.who, value, depends, s, *rest)


def _bound(d: ir.Domain) -> tuple[ir.Member, ...]:
    return (d.var,) if d.on is None else (d.var, d.on)


def _quantified(s: ir.Each | ir.Pick | ir.First, around: Around) -> Iterator[Write]:
    """Yields the writes of the members of a domain, and of what happens if there is none."""
    known = (
        ()
        if s.domain.on is None
        else (Fact(ir.StandsOn(agent=s.domain.var, kinds=s.domain.on.kinds)),)
    )
    known = (*known, *(() if s.domain.where is None else facts(s.domain.where)))
    if isinstance(s, ir.First):
        single = (
            isinstance(s.domain.restriction, ir.Near)
            and around.lanes[s.domain.restriction.shape] <= 1
        )
    else:
        single = isinstance(s, ir.Pick) and isinstance(s.number, ir.Number) and s.number.value <= 1
    inner = replace(
        around, quantifiers=(*around.quantifiers, Quantifier(s, _bound(s.domain), single))
    ).knowing(known)
    if isinstance(s, ir.Pick):
        yield from _writes(s.body, replace(inner, branches=around.in_branch(s, 0).branches))
        yield from _writes(s.otherwise, around.in_branch(s, 1))
    else:
        yield from _writes(s.body, inner)


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


def _field_write(s: ir.Set | ir.Add, around: Around) -> Write:
    """Returns the write of a field."""
    written = written_field(s.target)
    keys = written_keys(s.target)
    entries = [str(key.value) if isinstance(key, ir.Word | ir.Number) else None for key in keys]
    depends = _names(s.value, around)
    for key in keys:
        if not isinstance(key, ir.Member):
            depends |= _names(key, around)
    sort: Literal["set", "add"] = "set" if isinstance(s, ir.Set) else "add"
    quantifiers = tuple(
        replace(q, single=q.single or _is_of_one_agent(q, around.facts)) for q in around.quantifiers
    )
    return Write(
        sort,
        Target(written.held_by.what, written.name, tuple(entries)),
        written.held_by.names,
        written.owner,
        form(s.value),
        depends,
        s,
        quantifiers,
        around.branches,
        around.facts,
        tuple(key if isinstance(key, ir.Member) else None for key in keys),
    )


def _is_of_one_agent(quantifier: Quantifier, known: tuple[Fact, ...]) -> bool:
    """Returns whether all that is known leaves one agent, or one mover, to an `each`."""
    if (
        not isinstance(quantifier.statement, ir.Each)
        or quantifier.statement.domain.var.entity_type.what == "cell"
    ):
        return False
    if cell_under_all(quantifier.statement.domain) is not None:
        return True
    index = ir.Attribute(
        type=integer(0, float("inf"), "number"), owner=quantifier.statement.domain.var, name="index"
    )
    low, high = narrowed(index, known)
    return low == high


def _is_own(w: Write) -> bool:
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
        cell = None if domain is None else cell_under_all(domain)
        if cell is not None and not alone:
            names = {cell.name}  # nobody stands on two cells
        elif (
            isinstance(restriction, ir.Among)
            and quantifiers
            and isinstance(quantifiers[-1].statement, ir.Match)
        ):
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
        if isinstance(quantifier.statement, ir.First) or not any(
            m.name in names for m in quantifier.binds
        ):
            return False  # two lanes can reach one member
        if isinstance(quantifier.statement, ir.Each) and isinstance(
            quantifier.statement.domain.restriction, ir.Among
        ):
            if number and isinstance(
                w.quantifiers[number - 1].statement, ir.Match
            ):  # a side of a pair names the pair
                names |= {m.name for m in quantifier.statement.domain.restriction.members}
    return True


def _same_target(a: Write, b: Write) -> bool:
    """Returns whether two writes may be of the same entry of the same field."""
    if (a.target.of, a.target.name) != (b.target.of, b.target.name) or (
        a.kinds and b.kinds and set(a.kinds).isdisjoint(b.kinds)
    ):
        return False
    return all(
        x == y or None in (x, y) for x, y in zip(a.target.entries, b.target.entries, strict=False)
    )


def _compatible(a: Write, b: Write, bounded: Collection[Write]) -> bool:
    """Returns whether two writes never disagree. bounded: adds to fields with limits."""
    if a.sort == b.sort == "add":
        return not (a in bounded or b in bounded) or _exclusive(a, b)
    if a.is_by_lot and b.is_by_lot and len(a.target.entries) == len(b.target.entries):
        return True  # all who would write one target draw together
    if a.sort == b.sort and a.value == b.value and not (a.depends | b.depends):
        return True
    return _exclusive(a, b)


def _exclusive(a: Write, b: Write) -> bool:
    """Returns whether the two writes can never reach the same target in one phase."""
    apart = [
        x for x in a.branches for y in b.branches if x.statement is y.statement and x.way != y.way
    ]
    if any(x.once for x in apart):
        return True
    if a.is_own and b.is_own and ((apart and _shared_quantifier(a, b)) or _two_sides(a, b)):
        return True
    return any(contradict(x, y) for x in a.about_target for y in b.about_target)


def _shared_quantifier(a: Write, b: Write) -> bool:
    """Returns whether both targets are the variable of one and the same quantifier, or entries named by those of the same quantifiers."""
    if any(a.keys) or any(b.keys):
        alike = [None if m is None else m.name for m in a.keys] == [
            None if m is None else m.name for m in b.keys
        ]
        multiplying = (
            [id(q.statement) for q in w.quantifiers if not q.single] for w in (a, b)
        )  # those that can give several instances
        return alike and a.own_names == b.own_names and next(multiplying) == next(multiplying)
    if a.owner is None and b.owner is None:
        return True
    same = (
        isinstance(a.owner, ir.Member)
        and isinstance(b.owner, ir.Member)
        and a.owner.name == b.owner.name
    )
    return (
        same
        and bool(a.quantifiers)
        and bool(b.quantifiers)
        and a.quantifiers[0].statement is b.quantifiers[0].statement
    )


def _two_sides(a: Write, b: Write) -> bool:
    """Returns whether the targets are the two sides of one `match`: always different members."""
    if not (
        a.quantifiers and b.quantifiers and a.quantifiers[0].statement is b.quantifiers[0].statement
    ):
        return False
    if (
        not isinstance(a.quantifiers[0].statement, ir.Match)
        or len(a.quantifiers) != 1
        or len(b.quantifiers) != 1
    ):
        return False
    return (
        isinstance(a.owner, ir.Member)
        and isinstance(b.owner, ir.Member)
        and a.owner.name != b.owner.name
    )


def _target_text(w: Write) -> str:
    if w.sort == "place":
        return "the place"
    return w.target.name if w.owner is None else f"{text(w.owner)}.{w.target.name}"


def _report(a: Write, b: Write, phase: ir.Phase, problems: Problems) -> None:
    """Reports two writes of a phase that may disagree."""
    span = b.statement.origin
    other = a.statement.origin
    assert span is not None and other is not None
    labels = () if a is b else (Label(other, "the other write is here"),)
    if a.sort == b.sort == "place":
        who = "an agent" if a.target.name == "agent" else f"a mover `{a.target.name}`"
        problems.add(errors.TwoDestinations(span, labels=labels, phase=phase.label, who=who))
    elif {a.sort, b.sort} == {"set", "add"}:
        problems.add(errors.AddAndSet(span, labels=labels, name=_target_text(b), phase=phase.label))
    else:
        owner = a.target.name if a.target.of == "place" else a.target.of
        lot = ""
        if a.is_by_lot and b.is_by_lot:
            lot = "those who draw lots together write the same: let both set the whole row, or both an entry of it"
        elif (a.target.of, a.target.name) == ("agent", "heading"):
            lot = "let one of the two happen with `otherwise`, or send `facing same`, or write two phases"
        elif a.is_by_lot or b.is_by_lot:
            lot = "write `by lot` behind both, and all who would write it draw lots together"
        problems.add(
            errors.WriteConflict(
                span, labels=labels, name=_target_text(b), owner=owner, phase=phase.label, lot=lot
            )
        )


def _is_lasting(node: ir.Node) -> bool:
    """Returns whether a part of a condition on an agent has one value throughout an episode: its number, and numbers of the game."""
    match node:
        case ir.Attribute():
            return node.name == "index"
        case (
            ir.Member()
            | ir.ParamRef()
            | ir.Number()
            | ir.Arithmetic()
            | ir.Compare()
            | ir.InRange()
            | ir.Not()
            | ir.Logic()
            | ir.Named()
        ):
            return True
        case _:
            return False


def _not_forbidden(condition: ir.Expr, forbids: Iterable[ir.Forbid]) -> Iterator[Fact]:
    """Yields what is known of an agent that chose an action: what holds now as it did before the step, when it was not forbidden."""
    if isinstance(condition, ir.Chose) and isinstance(condition.agent, ir.Member):
        for forbid in forbids:
            if condition.action in forbid.actions and not forbid.names:
                parts = conjuncts(
                    renamed(forbid.condition, {"agent": condition.agent.name}), holds=False
                )
                yield from (
                    fact
                    for part in parts
                    if all(map(_is_lasting, ir.walk(part)))
                    for fact in facts(part)
                )
