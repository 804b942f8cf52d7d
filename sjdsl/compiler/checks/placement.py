"""Checks the placement of agents: `phase start` places every agent, and no `send` can run out of free cells unnoticed."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from sjdsl.compiler import ir
from sjdsl.compiler.checks.start_values import Place, holds_at_start, places, reads_only_fields
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.ir.free_variables import variables_around
from sjdsl.compiler.ir.implications import conjuncts
from sjdsl.compiler.ir.operations import CALCULATIONS, COMPARISONS
from sjdsl.compiler.ir.printer import domain as domain_text
from sjdsl.compiler.ir.queries import body_sort, phases_of
from sjdsl.compiler.ir.sorts import AGENTS


class Body(NamedTuple):
    """An agent or a mover."""

    sort: ir.Sort
    number: int


@dataclass
class Pool:
    """The sends of one phase use to one destination: whether any lacks `otherwise stay`, and whom they may reach."""

    sends: list[ir.Send] = field(default_factory=list)
    reached: set[Body] = field(default_factory=set)

    @property
    def kinds(self) -> tuple[str, ...]:
        return self.sends[0].domain.var.kinds


def check_placement(game: ir.Game, sources: Mapping[str, Source], problems: Problems) -> None:
    """Reports agents and movers without a place at the start, and sends without enough cells."""
    _check_start(game, problems)
    for phase in phases_of(game):
        _check_capacity(phase, game, problems, sources)


def _sorts(game: ir.Game) -> dict[ir.Sort, int]:
    """Returns how many agents there are, and how many movers of each sort."""
    return {AGENTS: game.agents.number} | {movers.sort: movers.number for movers in game.movers}


def _bodies(game: ir.Game) -> list[Body]:
    return [Body(sort, number) for sort, many in _sorts(game).items() for number in range(many)]


def _check_start(game: ir.Game, problems: Problems) -> None:
    for sort, many in _sorts(game).items():
        missing = [i for i in range(many) if not _always_sent(game.start.body, Body(sort, i))]
        if missing:
            who = f"{sort.name} {missing[0]}" if len(missing) == 1 else f"{sort.plural} {missing[0]} .. {missing[-1]}"
            problems.add(errors.NotSentAtStart(game.start.span, who=who, sort=sort.name))


def _is_of(who: ir.Expr, agent: Body) -> bool:
    return body_sort(who) == agent.sort


def _always_sent(body: tuple[ir.Stmt, ...], agent: Body) -> bool:
    """Returns whether the statements certainly send this agent or mover (they stand in an `each` of all of them)."""
    for s in body:
        match s:
            case ir.Send() if s.after is None and not s.stay and _is_of(s.who, agent):
                return True
            case ir.Each(domain=ir.Domain(on=None, restriction=None)) if _is_of(s.domain.var, agent):
                if s.domain.where is None or _decide(s.domain.where, agent) is True:
                    if _always_sent(s.body, agent):
                        return True
            case ir.When():
                if _branches_send(s, agent):
                    return True
            case ir.Chance():
                if s.otherwise and all(_always_sent(b, agent) for b in (*(b.body for b in s.branches), s.otherwise)):
                    return True
            case _:
                pass
    return False


def _branches_send(s: ir.When, agent: Body) -> bool:
    for branch in s.branches:
        decided = _decide(branch.test, agent)
        if decided is False:
            continue
        if not _always_sent(branch.body, agent):
            return False
        if decided is True:
            return True
    return _always_sent(s.otherwise, agent)


def _decide(test: ir.Expr, agent: Body) -> bool | None:
    """Returns whether a condition holds for this agent, if that follows from its index alone."""
    parts = [_decide_one(p, agent) for p in conjuncts(test)]
    if False in parts:
        return False
    return True if all(p is True for p in parts) else None


def _decide_one(test: ir.Expr, agent: Body) -> bool | None:
    match test:
        case ir.Not():
            inner = _decide(test.value, agent)
            return None if inner is None else not inner
        case ir.Logic(fn="or"):
            parts = [_decide(a, agent) for a in test.args]
            if True in parts:
                return True
            return False if all(p is False for p in parts) else None
        case ir.Compare():
            left, right = _number(test.left, agent), _number(test.right, agent)
            if left is None or right is None:
                return None
            return bool(COMPARISONS[test.fn].holds(left, right))
        case ir.Truth():
            return test.value
        case _:
            return None


def _number(e: ir.Expr, agent: Body) -> float | None:
    match e:
        case ir.Number():
            return e.value
        case ir.Attribute(name="index") if _is_of(e.owner, agent):
            return agent.number
        case ir.Arithmetic() if e.type.kind == "int":
            row, values = CALCULATIONS[e.fn], [_number(a, agent) for a in e.args]
            if None in values or (row.divisor is not None and not values[row.divisor]):
                return None
            return row.fold(*values)
        case _:
            return None


def _check_capacity(phase: ir.Phase, game: ir.Game, problems: Problems, sources: Mapping[str, Source]) -> None:
    pools: dict[int, Pool] = {}
    for agent in _bodies(game):
        for send in _possible_sends(phase.body, agent):
            pool = pools.setdefault(send.pool, Pool())
            pool.reached.add(agent)
            if send not in pool.sends:
                pool.sends.append(send)
    earlier: list[Pool] = []
    for pool in pools.values():
        lacking = [s for s in pool.sends if not s.stay]
        sharing = [p for p in earlier if set(p.kinds) & set(pool.kinds)]
        if lacking and phase is game.start:
            _check_room_at_start(pool, sharing, lacking[0], game, problems, sources)
        elif lacking:
            _check_room(pool, sharing, lacking[0], game, problems, sources)
        earlier.append(pool)


def _as_written(domain: ir.Domain, sources: Mapping[str, Source]) -> str:
    """Returns a destination as its author wrote it, on one line."""
    span = domain.origin
    if span is None or span.file not in sources:
        return domain_text(domain)
    return " ".join(re.sub(r"#[^\n]*", "", sources[span.file].text[span.start : span.end]).split())


def _possible_sends(body: tuple[ir.Stmt, ...], agent: Body) -> list[ir.Send]:
    """Returns the sends that may reach this agent, as far as conditions on its index tell."""
    found: list[ir.Send] = []
    for s in body:
        match s:
            case ir.Send():
                if _is_of(s.who, agent):
                    found.append(s)
            case ir.Each() | ir.Pick() | ir.First():
                own = _is_of(s.domain.var, agent) and s.domain.where is not None
                if not (own and _decide(s.domain.where, agent) is False and _innermost(s.body)):  # type: ignore[arg-type]
                    found += _possible_sends(s.body, agent)
                if not isinstance(s, ir.Each):
                    found += _possible_sends(s.otherwise, agent)
            case ir.Match():
                found += _possible_sends(s.body, agent)
            case ir.When():
                found += _when_sends(s, agent)
            case ir.Chance():
                for branch in s.branches:
                    found += _possible_sends(branch.body, agent)
                found += _possible_sends(s.otherwise, agent)
            case _:
                pass
    return found


def _innermost(body: tuple[ir.Stmt, ...]) -> bool:
    return not any(isinstance(n, ir.Each | ir.Pick | ir.First | ir.Match) for s in body for n in ir.walk(s))


def _when_sends(s: ir.When, agent: Body) -> list[ir.Send]:
    found: list[ir.Send] = []
    for branch in s.branches:
        decided = _decide(branch.test, agent)
        if decided is not False or not _innermost(branch.body):
            found += _possible_sends(branch.body, agent)
        if decided is True and _innermost(branch.body):
            return found
    return found + _possible_sends(s.otherwise, agent)


def _check_room(
    pool: Pool, sharing: list[Pool], lacking: ir.Send, game: ir.Game, problems: Problems, sources: Mapping[str, Source]
) -> None:
    """Besides all agents and movers, those may be in the way that were sent to the same cells before: in their new and in their old places."""
    domain, needed = pool.sends[0].domain, len(_bodies(game)) + len({agent for p in sharing for agent in p.reached})
    cells = len(places(game, domain.var.kinds)) if domain.where is None else 0
    place = _as_written(domain, sources)
    if domain.where is not None:
        problems.add(errors.NoFreeCell(lacking.span, place=place))
    elif cells < needed:
        movers = " or movers" if game.movers else ""
        problems.add(errors.TooFewFreeCells(lacking.span, place=place, cells=cells, agents=needed, movers=movers))


def _check_room_at_start(
    pool: Pool, sharing: list[Pool], lacking: ir.Send, game: ir.Game, problems: Problems, sources: Mapping[str, Source]
) -> None:
    """Agents take cells in the order of their numbers: each needs more cells that fit than others before it may have taken."""
    domain, span = pool.sends[0].domain, lacking.span
    own = any(variables_around(s.domain) for s in pool.sends)
    earlier = {agent: _cells_at_start(p, agent, game)[1] for p in sharing for agent in p.reached}
    for agent in sorted(pool.reached, key=lambda body: body.number):  # of one sort: each is placed by itself
        sure, possible = _cells_at_start(pool, agent, game)
        taken = sum(other != agent and not sure.isdisjoint(cells) for other, cells in earlier.items())
        earlier[agent] = earlier.get(agent, set()) | possible
        if len(sure) > taken:
            continue
        place, everybody = _as_written(domain, sources), len({*pool.reached, *earlier})
        if own:
            problems.add(errors.TooFewForOne(span, place=place, cells=len(sure), agents=taken, who=f"{agent.sort.name} {agent.number}"))
        elif domain.where is None:
            who = "agents and movers" if game.movers else "agents"
            problems.add(errors.TooFewCells(span, kind=place, cells=len(sure), agents=everybody, who=who))
        else:
            movers = " or movers" if game.movers else ""
            problems.add(errors.TooFewToStart(span, place=place, cells=len(sure), agents=everybody, movers=movers))
        return


def _cells_at_start(pool: Pool, agent: Body, game: ir.Game) -> tuple[set[Place], set[Place]]:
    """Returns the cells that certainly fit an agent when the episode begins, and those that may."""
    sure, possible = set(), set()
    for s in pool.sends:
        known = {s.who.name: agent.number} if isinstance(s.who, ir.Member) else {}
        by_glyph = s.domain.where is not None and reads_only_fields(s.domain.where, s.domain.var.name)
        found: dict[Place | str, bool | None] = {}
        for place in places(game, s.domain.var.kinds):
            key = place.glyph if by_glyph else place
            if key not in found:
                found[key] = s.domain.where is None or holds_at_start(s.domain.where, {**known, s.domain.var.name: place}, game)
            fits = found[key]
            if fits is not False:
                possible.add(place)
            if fits is True:
                sure.add(place)
    return sure, possible
