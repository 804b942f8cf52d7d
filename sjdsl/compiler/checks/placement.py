"""Checks the placement of agents.

`phase start` places every agent, and no `send` can run out of free cells unnoticed.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from sjdsl.compiler import ir
from sjdsl.compiler.checks.start_values import Place, holds_at_start, places, reads_only_fields
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import Diagnostic
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.compiler.ir.entity_types import AGENTS
from sjdsl.compiler.ir.fold import UnknownValue
from sjdsl.compiler.ir.free_variables import variables_around
from sjdsl.compiler.ir.printer import domain_text
from sjdsl.compiler.ir.queries import body_type, phases_of
from sjdsl.compiler.ir.values import Evaluation, decided


class Body(NamedTuple):
    """An agent or a mover."""

    entity_type: ir.EntityType
    number: int


@dataclass
class Pool:
    """The sends of one phase use to one destination, and whom they may reach."""

    sends: list[ir.Send] = field(default_factory=list)
    reached: set[Body] = field(default_factory=set)

    @property
    def kinds(self) -> tuple[str, ...]:
        return self.sends[0].domain.var.kinds


def check_placement(game: ir.Game, sources: Mapping[str, Source], problems: Problems) -> None:
    """Reports agents and movers without a place at the start, and sends without enough cells."""
    numbers = {AGENTS: game.agents.number} | {
        movers.entity_type: movers.number for movers in game.movers
    }
    bodies: list[Body] = []
    for entity_type, number in numbers.items():
        of_type = [Body(entity_type, i) for i in range(number)]
        bodies += of_type
        missing = [body.number for body in of_type if not _always_sent(game.start.body, body)]
        if missing:
            who = f"{entity_type.name} {missing[0]}"
            if len(missing) > 1:
                who = f"{entity_type.plural} {missing[0]} .. {missing[-1]}"
            problems.add(errors.NotSentAtStart(game.start.span, who=who, sort=entity_type.name))
    for phase in phases_of(game):
        for problem in _without_room(phase, game, bodies, sources):
            problems.add(problem)


def _is_of(who: ir.Expr, agent: Body) -> bool:
    return body_type(who) == agent.entity_type


def _always_sent(body: tuple[ir.Stmt, ...], agent: Body) -> bool:
    """Returns whether the statements certainly send this agent or mover."""
    for s in body:
        sent = False
        match s:
            case ir.Send():
                sent = s.after is None and not s.stay and _is_of(s.who, agent)
            case ir.Each(domain=ir.Domain(on=None, restriction=None)) if _is_of(
                s.domain.var, agent
            ):
                where = s.domain.where
                is_member = where is None or _decide(where, agent) is True
                sent = is_member and _always_sent(s.body, agent)
            case ir.When():
                sent = all(_always_sent(way, agent) for way in _ways(s, agent))
            case ir.Chance():
                ways = [*(branch.body for branch in s.branches), s.otherwise]
                sent = bool(s.otherwise) and all(_always_sent(way, agent) for way in ways)
            case _:
                pass
        if sent:
            return True
    return False


def _ways(s: ir.When, agent: Body, certain: bool = True) -> list[tuple[ir.Stmt, ...]]:
    """Returns the ways through a `when` that are open to this agent, by conditions on its index.

    certain: whether a condition also decides about ways that have quantifiers of their own. These
      may mean another agent.
    """
    ways = []
    for branch in s.branches:
        decided = None
        if certain or not _has_quantifier(branch.body):
            decided = _decide(branch.test, agent)
        if decided is not False:
            ways.append(branch.body)
        if decided is True:
            return ways
    return [*ways, s.otherwise]


def _decide(test: ir.Expr, agent: Body) -> bool | None:
    """Returns whether a condition holds for this agent, if that follows from its index alone."""

    def index(e: ir.Expr) -> int:
        if isinstance(e, ir.Attribute) and e.name == "index" and _is_of(e.owner, agent):
            return agent.number
        raise UnknownValue

    return decided(test, Evaluation(index, computes_reals=False))


def _without_room(
    phase: ir.Phase, game: ir.Game, bodies: list[Body], sources: Mapping[str, Source]
) -> Iterator[Diagnostic]:
    """Yields what is wrong with the sends of a phase where free cells may run out."""
    pools: dict[int, Pool] = {}
    for agent in bodies:
        for send in _possible_sends(phase.body, agent):
            pool = pools.setdefault(send.pool, Pool())
            pool.reached.add(agent)
            if send not in pool.sends:
                pool.sends.append(send)
    earlier: list[Pool] = []
    for pool in pools.values():
        lacking = next((s for s in pool.sends if not s.stay), None)
        sharing = [p for p in earlier if set(p.kinds) & set(pool.kinds)]
        earlier.append(pool)
        if lacking is None:
            continue
        domain = pool.sends[0].domain
        place = domain_text(domain)
        span = domain.origin
        if span is not None and span.file in sources:  # as its author wrote it, on one line
            place = " ".join(
                re.sub(r"#[^\n]*", "", sources[span.file].text[span.start : span.end]).split()
            )
        if phase is game.start:
            yield from _without_room_at_start(pool, sharing, lacking.span, place, game)
            continue
        # besides all agents and movers, those may be in the way that were sent to the same cells
        # before: in their new and in their old places
        needed = len(bodies) + len({agent for p in sharing for agent in p.reached})
        cells = len(places(game, domain.var.kinds))
        if domain.where is not None:
            yield errors.NoFreeCell(lacking.span, place=place)
        elif cells < needed:
            movers = " or movers" if game.movers else ""
            yield errors.TooFewFreeCells(
                lacking.span, place=place, cells=cells, agents=needed, movers=movers
            )


def _possible_sends(body: tuple[ir.Stmt, ...], agent: Body) -> list[ir.Send]:
    """Returns the sends that may reach this agent, as far as conditions on its index tell.

    What a condition on its index excludes is looked at all the same where it has quantifiers of its
    own: these may mean another agent.
    """
    sends: list[ir.Send] = []
    for s in body:
        match s:
            case ir.Send():
                if _is_of(s.who, agent):
                    sends.append(s)
            case ir.Each() | ir.Pick() | ir.First():
                where = s.domain.where if _is_of(s.domain.var, agent) else None
                if where is None or _decide(where, agent) is not False or _has_quantifier(s.body):
                    sends += _possible_sends(s.body, agent)
                if isinstance(s, ir.Pick):
                    sends += _possible_sends(s.otherwise, agent)
            case ir.Match():
                sends += _possible_sends(s.body, agent)
            case ir.When():
                for way in _ways(s, agent, certain=False):
                    sends += _possible_sends(way, agent)
            case ir.Chance():
                for way in (*(branch.body for branch in s.branches), s.otherwise):
                    sends += _possible_sends(way, agent)
            case _:
                pass
    return sends


def _has_quantifier(body: tuple[ir.Stmt, ...]) -> bool:
    return any(
        isinstance(n, ir.Each | ir.Pick | ir.First | ir.Match) for s in body for n in ir.walk(s)
    )


def _without_room_at_start(
    pool: Pool, sharing: list[Pool], span: Span, place: str, game: ir.Game
) -> Iterator[Diagnostic]:
    """Yields what is wrong with the sends of `phase start` to a destination.

    Agents take cells in the order of their numbers: each needs more cells that fit than others
    before it may have taken.
    """
    earlier = {agent: _cells_at_start(p, agent, game)[1] for p in sharing for agent in p.reached}
    for agent in sorted(
        pool.reached, key=lambda body: body.number
    ):  # of one sort: each is placed by itself
        sure, possible = _cells_at_start(pool, agent, game)
        taken = sum(
            other != agent and not sure.isdisjoint(cells) for other, cells in earlier.items()
        )
        earlier[agent] = earlier.get(agent, set()) | possible
        if len(sure) > taken:
            continue
        everybody = len({*pool.reached, *earlier})
        cells = len(sure)
        if any(variables_around(s.domain) for s in pool.sends):
            yield errors.TooFewForOne(
                span,
                place=place,
                cells=cells,
                agents=taken,
                who=f"{agent.entity_type.name} {agent.number}",
            )
        elif pool.sends[0].domain.where is None:
            who = "agents and movers" if game.movers else "agents"
            yield errors.TooFewCells(span, kind=place, cells=cells, agents=everybody, who=who)
        else:
            movers = " or movers" if game.movers else ""
            yield errors.TooFewToStart(
                span, place=place, cells=cells, agents=everybody, movers=movers
            )
        return


def _cells_at_start(pool: Pool, agent: Body, game: ir.Game) -> tuple[set[Place], set[Place]]:
    """Returns the cells that certainly fit an agent when the episode begins, and those that may."""
    sure = set()
    possible = set()
    for s in pool.sends:
        known = {s.who.name: agent.number} if isinstance(s.who, ir.Member) else {}
        domain = s.domain
        by_glyph = domain.where is not None and reads_only_fields(domain.where, domain.var.name)
        fits: dict[Place | str, bool | None] = {}
        for place in places(game, domain.var.kinds):
            key = place.glyph if by_glyph else place
            if key not in fits:
                names: dict[str, Place | int] = {**known, domain.var.name: place}
                fits[key] = domain.where is None or holds_at_start(domain.where, names, game)
            if fits[key] is not False:
                possible.add(place)
            if fits[key] is True:
                sure.add(place)
    return sure, possible
