"""Write conflicts: refuses two writes in one phase that could disagree.

They are safe if they are provably one, equal, exclusive or commuting. A write is looked at with
everything around it: the quantifiers (each gives instances), the branches taken, and the conditions
known to hold. Two writes of one field can only meet at one target, so conditions about the target
decide.
"""

from collections.abc import Collection, Iterable, Iterator, Sequence
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

LASTING = (
    ir.Member | ir.ParamRef | ir.Number | ir.Arithmetic | ir.Compare | ir.InRange | ir.Not
    | ir.Logic | ir.Named
)  # fmt: skip
BOTH_BY_LOT = "those who draw lots together write the same: let both set the whole row, or both an entry of it"
ONE_BY_LOT = "write `by lot` behind both, and all who would write it draw lots together"
HEADING = "let one of the two happen with `otherwise`, or send `facing same`, or write two phases"


class Quantifier(Record):
    """One quantifier. single: whether it gives at most one instance for each around it."""

    statement: ir.Each | ir.Pick | ir.First | ir.Match
    domains: tuple[ir.Domain, ...]
    single: bool = False

    @property
    def names(self) -> set[str]:
        """The variables that it binds."""
        members = [member for domain in self.domains for member in (domain.var, domain.on)]
        return {member.name for member in members if member is not None}


class Branch(Record):
    """One way through a statement with several.

    once: the statement is met once in the phase, so only one of its ways is taken.
    """

    statement: ir.Stmt
    way: int
    once: bool


class Target(Record):
    """What is written: the place of an agent or a mover, or a field of something.

    entries: of a row, None for any of them.
    """

    of: Literal["agent", "cell", "mover", "world", "place"]
    name: str
    kinds: tuple[str, ...] = ()
    entries: tuple[str | None, ...] = ()


class Around(Record):
    """What surrounds a statement.

    locals: the variables each `let` and `draw` depends on (`draw` on itself).
    lanes: how many each shape has.
    turns_agents: whether a statement of the phase sets the heading of agents, so that a `send` may
      not set another.
    """

    quantifiers: tuple[Quantifier, ...] = ()
    branches: tuple[Branch, ...] = ()
    facts: tuple[Fact, ...] = ()
    locals: dict[str, frozenset[str]] = field(default_factory=dict)
    lanes: dict[str, int] = field(default_factory=dict)
    forbids: tuple[ir.Forbid, ...] = ()
    turns_agents: bool = False

    def knowing(self, known: Iterable[Fact]) -> "Around":
        """Returns this with more that is known.

        Of an agent that chose an action, it is also known that it was not forbidden to.
        """
        new = list(known)
        for fact in tuple(new):
            new += _not_forbidden(fact.condition, self.forbids)
        return replace(self, facts=(*self.facts, *new))

    def in_branch(self, s: ir.Stmt, way: int) -> "Around":
        """Returns what surrounds the statements of one way through `s`."""
        branch = Branch(s, way, once=all(q.single for q in self.quantifiers))
        return replace(self, branches=(*self.branches, branch))

    def inside(self, quantifier: Quantifier) -> "Around":
        """Returns what surrounds the body of a quantifier."""
        known: list[Fact] = []
        for domain in quantifier.domains:
            if domain.on is not None and not isinstance(quantifier.statement, ir.Match):
                known.append(Fact(ir.StandsOn(agent=domain.var, kinds=domain.on.kinds)))
            if domain.where is not None:
                known += facts(domain.where)
        return replace(self, quantifiers=(*self.quantifiers, quantifier)).knowing(known)

    def names_in(self, *parts: ir.Expr | None) -> frozenset[str]:
        """Returns the variables that values depend on, without those that they bind themselves."""
        names: set[str] = set()
        for part in parts:
            if part is not None:
                for variable in free_variables(part):
                    names |= self.locals.get(variable.name, {variable.name})
        return frozenset(names)

    def with_local(self, name: str, depends: frozenset[str]) -> "Around":
        """Returns this with one more variable, which depends on others."""
        return replace(self, locals={**self.locals, name: depends})


class Write(Record, eq=False):
    """One `set`, `add` or change of place.

    owner: whose field or place (None: the world's). keys: the agents that name an entry, None for
      an entry named in another way.
    value: what two equal writes share. depends: the variables that it depends on.
    """

    sort: Literal["set", "add", "place"]
    target: Target
    owner: ir.Expr | None
    value: Form
    depends: frozenset[str]
    statement: ir.Stmt
    around: Around
    keys: tuple[str | None, ...] = ()

    @property
    def quantifiers(self) -> tuple[Quantifier, ...]:
        return self.around.quantifiers

    @property
    def names_of_target(self) -> frozenset[str]:
        """The variables that name the target: its owner, and the agents that name its entry."""
        owner = self.owner.name if isinstance(self.owner, ir.Member) else None
        return frozenset(name for name in (owner, *self.keys) if name is not None)

    @cached_property
    def is_alone(self) -> bool:
        """Whether every target is written by one instance."""
        return (any(self.keys) and _is_alone_by_keys(self)) or _is_alone_by_owner(self)

    @property
    def is_by_lot(self) -> bool:
        return isinstance(self.statement, ir.Set) and self.statement.lot is not None

    @cached_property
    def about_target(self) -> tuple[Fact, ...]:
        """The known conditions that speak of the target alone, under a name two writes share."""
        if self.owner is not None and not isinstance(self.owner, ir.Member):
            return ()
        target: dict[str, object] = {}
        for place, name in enumerate(self.keys):
            if name is not None:
                target[name] = f"entry {place}"
        if self.owner is not None:
            target[self.owner.name] = "target"
        about_target = []
        for fact in self.around.facts:
            variables = free_variables(fact.condition)
            if all(variable.name in target for variable in variables):
                about_target.append(Fact(fact.condition, target))
        return tuple(about_target)


def check_conflicts(game: ir.Game, problems: Problems) -> None:
    """Reports every pair of writes of one phase that could disagree, and `move` beside others."""
    around = Around(lanes={s.name: len(s.lanes) for s in game.shapes}, forbids=game.agents.forbids)
    for phase in phases_of(game):
        turns_agents = contains(phase, ir.Face)
        writes = list(_writes(phase.body, replace(around, turns_agents=turns_agents)))
        bounded = {write for write in writes if _is_bounded(write, game)}
        for write in writes:
            if write.is_alone:
                continue
            if write in bounded:
                _report_sum(write, game, problems)
            elif write.sort != "add" and not write.is_by_lot:
                if not write.depends <= write.names_of_target:
                    _report(write, write, phase, problems)
        for a, b in combinations(writes, 2):
            if _same_target(a, b) and not _compatible(a, b, bounded):
                _report(a, b, phase, problems)
        moves = [node for node in ir.walk(phase) if isinstance(node, ir.Move)]
        if moves and phase.body != (moves[0],):
            problems.add(errors.MoveAlone(moves[0].span))


def _is_bounded(w: Write, game: ir.Game) -> bool:
    """Returns whether this is an `add` that has to stay in a range, which isn't `capped`."""
    if not isinstance(w.statement, ir.Add):
        return False
    written = written_field(w.statement.target)
    return has_limits(written.type) and not declared_field(game, written).capped


def _writes(body: tuple[ir.Stmt, ...], around: Around) -> Iterator[Write]:
    """Yields all writes of statements. around: what holds where they stand."""
    for s in body:
        match s:
            case ir.Let():
                around = around.with_local(s.name, around.names_in(s.value))
            case ir.Draw():
                around = around.with_local(s.name, frozenset({f"draw {s.name}"}))
            case ir.Each():
                yield from _writes(s.body, around.inside(Quantifier(s, (s.domain,))))
            case ir.First():
                assert isinstance(s.domain.restriction, ir.Near)
                single = around.lanes[s.domain.restriction.shape] <= 1
                yield from _writes(s.body, around.inside(Quantifier(s, (s.domain,), single)))
            case ir.Pick():
                single = isinstance(s.number, ir.Number) and s.number.value <= 1
                inner = around.inside(Quantifier(s, (s.domain,), single))
                branches = around.in_branch(s, 0).branches
                yield from _writes(s.body, replace(inner, branches=branches))
                yield from _writes(s.otherwise, around.in_branch(s, 1))
            case ir.Match():
                yield from _writes(s.body, around.inside(Quantifier(s, (s.left, s.right))))
            case ir.When() | ir.Chance():
                yield from _branched(s, around)
            case ir.Set() | ir.Add():
                yield _field_write(s, around)
            case ir.Send():
                depends = around.names_in(s.domain.where) - {s.domain.var.name}
                depends |= around.names_in(s.after, s.way)
                value = ("send", s.pool, s.facing, s.stay, *_forms(s.after, s.way))
                yield from _place_writes(s, value, depends, around)
            case ir.Shift():
                parts = (s.to, s.steps, s.heading, s.other, s.way)
                value = ("shift", s.quarters, s.facing, *_forms(*parts))
                yield from _place_writes(s, value, around.names_in(*parts), around)
            case ir.Remove():
                yield from _place_writes(s, ("remove",), frozenset(), around)
            case ir.Face():
                heading = Target("agent", "heading")
                depends = around.names_in(s.heading)
                yield Write("set", heading, s.who, form(s.heading), depends, s, around)
            case _:
                pass


def _branched(s: ir.When | ir.Chance, around: Around) -> Iterator[Write]:
    """Yields the writes of the ways through a statement."""
    is_when = isinstance(s, ir.When)
    for number, branch in enumerate(s.branches):
        inner = around.knowing(facts(branch.test)) if is_when else around
        yield from _writes(branch.body, inner.in_branch(s, number))
        if is_when:
            around = around.knowing(facts(branch.test, holds=False))
    yield from _writes(s.otherwise, around.in_branch(s, len(s.branches)))


def _forms(*parts: ir.Expr | None) -> Form:
    return tuple(None if part is None else form(part) for part in parts)


def _place_writes(
    s: ir.Send | ir.Shift | ir.Remove, value: Form, depends: frozenset[str], around: Around
) -> Iterator[Write]:
    """Yields the write of a place, and that of the heading with which one arrives there."""
    body = body_type(s.who)
    place = Target("place", body.name)
    yield Write("place", place, s.who, value, depends, s, around)
    turns = not isinstance(s, ir.Remove) and s.facing != "same"
    # A mover's heading is a field like others; an agent's matters only if some statement sets it.
    if turns and (body.what == "mover" or around.turns_agents):
        heading = Target(body.what, "heading", body.names)
        yield Write("set", heading, s.who, value, depends, s, around)


def _field_write(s: ir.Set | ir.Add, around: Around) -> Write:
    """Returns the write of a field."""
    written = written_field(s.target)
    keys = written_keys(s.target)
    entries = [str(key.value) if isinstance(key, ir.Word | ir.Number) else None for key in keys]
    others = (key for key in keys if not isinstance(key, ir.Member))
    quantifiers = tuple(
        replace(q, single=q.single or _is_of_one_agent(q, around.facts)) for q in around.quantifiers
    )
    held_by = written.held_by
    return Write(
        sort="set" if isinstance(s, ir.Set) else "add",
        target=Target(held_by.what, written.name, held_by.names, tuple(entries)),
        owner=written.owner,
        value=form(s.value),
        depends=around.names_in(s.value, *others),
        statement=s,
        around=replace(around, quantifiers=quantifiers),
        keys=tuple(key.name if isinstance(key, ir.Member) else None for key in keys),
    )


def _is_of_one_agent(quantifier: Quantifier, known: tuple[Fact, ...]) -> bool:
    """Returns whether all that is known leaves one agent, or one mover, to an `each`."""
    domain = quantifier.domains[0]
    if not isinstance(quantifier.statement, ir.Each) or domain.var.entity_type.what == "cell":
        return False
    if cell_under_all(domain) is not None:
        return True
    any_number = integer(0, float("inf"), "number")
    low, high = narrowed(ir.Attribute(type=any_number, owner=domain.var, name="index"), known)
    return low == high


def _is_alone_by_owner(w: Write) -> bool:
    """Returns whether the owner is the variable of the only quantifier that multiplies.

    A quantifier that gives at most one instance for each of those around it does not multiply.
    """
    if w.owner is None:
        return all(q.single for q in w.quantifiers)
    if not isinstance(w.owner, ir.Member):
        return False
    names = {w.owner.name}
    quantifiers = list(w.quantifiers)
    while quantifiers:
        quantifier = quantifiers.pop()
        if names.isdisjoint(quantifier.names):
            if not quantifier.single:
                return False
            continue
        is_outermost = all(q.single for q in quantifiers)
        if isinstance(quantifier.statement, ir.Match):
            return is_outermost
        (domain,) = quantifier.domains
        cell = cell_under_all(domain)
        pair = _pair_of_side(quantifier, quantifiers)
        if cell is not None and not is_outermost:
            names = {cell.name}  # nobody stands on two cells
        elif pair:
            names = pair
        else:
            is_whole = domain.restriction is None or quantifier.single
            return is_whole and is_outermost
    return False


def _is_alone_by_keys(w: Write) -> bool:
    """Returns whether an entry's owner and its keys together name all that multiplies."""
    if w.owner is not None and not isinstance(w.owner, ir.Member):
        return False
    names = set(w.names_of_target)
    quantifiers = list(w.quantifiers)
    while quantifiers:
        quantifier = quantifiers.pop()
        if quantifier.single:
            continue
        # Two lanes of a shape can reach one member.
        if isinstance(quantifier.statement, ir.First) or names.isdisjoint(quantifier.names):
            return False
        if isinstance(quantifier.statement, ir.Each):
            names |= _pair_of_side(quantifier, quantifiers)
    return True


def _pair_of_side(quantifier: Quantifier, around: Sequence[Quantifier]) -> set[str]:
    """Returns {a, b} for `each agent as x in { a, b }` just inside a `match` of a and b; else none.

    around: the quantifiers around it, outermost first.
    """
    restriction = quantifier.domains[0].restriction
    if isinstance(restriction, ir.Among) and around:
        if isinstance(around[-1].statement, ir.Match):
            return {member.name for member in restriction.members}
    return set()


def _same_target(a: Write, b: Write) -> bool:
    """Returns whether two writes may be of the same entry of the same field."""
    one = a.target
    other = b.target
    if (one.of, one.name) != (other.of, other.name):
        return False
    if one.kinds and other.kinds and set(one.kinds).isdisjoint(other.kinds):
        return False
    pairs = zip(one.entries, other.entries, strict=False)
    return all(x == y or None in (x, y) for x, y in pairs)


def _compatible(a: Write, b: Write, bounded: Collection[Write]) -> bool:
    """Returns whether two writes never disagree. bounded: adds to fields with limits."""
    if a.sort == b.sort == "add" and a not in bounded and b not in bounded:
        return True
    if a.is_by_lot and b.is_by_lot and len(a.target.entries) == len(b.target.entries):
        return True  # all who would write one target draw together
    if a.sort == b.sort != "add" and a.value == b.value and not (a.depends | b.depends):
        return True
    return _exclusive(a, b)


def _exclusive(a: Write, b: Write) -> bool:
    """Returns whether the two writes can never reach the same target in one phase."""
    ways_of_b = {id(branch.statement): branch.way for branch in b.around.branches}
    apart = []  # the branches that `a` is in where `b` is in another one of the same statement
    for branch in a.around.branches:
        if ways_of_b.get(id(branch.statement), branch.way) != branch.way:
            apart.append(branch)
    if any(branch.once for branch in apart):
        return True
    if a.is_alone and b.is_alone:
        if (apart and _share_quantifier(a, b)) or _are_two_sides(a, b):
            return True
    return any(contradict(x, y) for x in a.about_target for y in b.about_target)


def _share_quantifier(a: Write, b: Write) -> bool:
    """Returns whether both targets are named by the variables of the same quantifiers."""
    if any(a.keys) or any(b.keys):
        is_same = a.keys == b.keys and a.names_of_target == b.names_of_target
        return is_same and _multiplying(a) == _multiplying(b)
    if a.owner is None and b.owner is None:
        return True
    return a.names_of_target == b.names_of_target != frozenset() and _have_one_outermost(a, b)


def _multiplying(w: Write) -> list[int]:
    """Returns the identities of the quantifiers that can give several instances."""
    return [id(q.statement) for q in w.quantifiers if not q.single]


def _have_one_outermost(a: Write, b: Write) -> bool:
    if not a.quantifiers or not b.quantifiers:
        return False
    return a.quantifiers[0].statement is b.quantifiers[0].statement


def _are_two_sides(a: Write, b: Write) -> bool:
    """Returns whether the targets are the two sides of one `match`: always different members."""
    if not (len(a.quantifiers) == len(b.quantifiers) == 1 and _have_one_outermost(a, b)):
        return False
    if not isinstance(a.quantifiers[0].statement, ir.Match):
        return False
    if not isinstance(a.owner, ir.Member) or not isinstance(b.owner, ir.Member):
        return False
    return a.owner.name != b.owner.name


def _target_text(w: Write) -> str:
    if w.sort == "place":
        return "the place"
    return w.target.name if w.owner is None else f"{text(w.owner)}.{w.target.name}"


def _report_sum(w: Write, game: ir.Game, problems: Problems) -> None:
    """Reports an `add` that several instances make at once: only a capped field stays in range."""
    assert isinstance(w.statement, ir.Add)
    declared = declared_field(game, written_field(w.statement.target))
    problems.add(
        errors.FieldRange(
            w.statement.span,
            name=_target_text(w),
            declared=declared.name,
            low=declared.type.low,
            high=declared.type.high,
            reached="the sum of several adds",
        )
    )


def _report(a: Write, b: Write, phase: ir.Phase, problems: Problems) -> None:
    """Reports two writes of a phase that may disagree."""
    span = b.statement.span
    labels = () if a is b else (Label(a.statement.span, "the other write is here"),)
    name = _target_text(b)
    target = a.target
    if a.sort == b.sort == "place":
        who = "an agent" if target.name == "agent" else f"a mover `{target.name}`"
        problems.add(errors.TwoDestinations(span, labels=labels, phase=phase.label, who=who))
        return
    if {a.sort, b.sort} == {"set", "add"}:
        problems.add(errors.AddAndSet(span, labels=labels, name=name, phase=phase.label))
        return
    lot = ""
    if a.is_by_lot and b.is_by_lot:
        lot = BOTH_BY_LOT
    elif (target.of, target.name) == ("agent", "heading"):
        lot = HEADING
    elif a.is_by_lot or b.is_by_lot:
        lot = ONE_BY_LOT
    problems.add(
        errors.WriteConflict(
            span, labels=labels, name=name, owner=target.of, phase=phase.label, lot=lot
        )
    )


def _is_lasting(node: ir.Node) -> bool:
    """Returns whether a part of a condition has one value throughout an episode.

    That is so of the number of an agent, and of numbers of the game.
    """
    if isinstance(node, ir.Attribute):
        return node.name == "index"
    return isinstance(node, LASTING)


def _not_forbidden(condition: ir.Expr, forbids: Iterable[ir.Forbid]) -> Iterator[Fact]:
    """Yields what is known of an agent that chose an action, as it was not forbidden.

    Only what holds now as it did before the step is known.
    """
    if not isinstance(condition, ir.Chose) or not isinstance(condition.agent, ir.Member):
        return
    for forbid in forbids:
        if condition.action in forbid.actions and not forbid.names:
            forbidden = renamed(forbid.condition, {"agent": condition.agent.name})
            for part in conjuncts(forbidden, holds=False):
                if all(map(_is_lasting, ir.walk(part))):
                    yield from facts(part)
