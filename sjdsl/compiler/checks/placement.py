"""Checks the placement of agents: `phase start` places every agent, and no `send` can run out of free cells unnoticed."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.ir.implications import conjuncts
from sjdsl.compiler.ir.printer import domain as domain_text
from sjdsl.compiler.ir.queries import phases_of, starts_of


@dataclass
class Pool:
    """The sends of one phase use to one destination: whether any lacks `otherwise stay`, and whom they may reach."""

    sends: list[ir.Send] = field(default_factory=list)
    agents: set[int] = field(default_factory=set)


def check_placement(game: ir.Game, sources: Mapping[str, Source], problems: Problems) -> None:
    """Reports agents without a place at the start, sends without enough cells, and destinations that overlap."""
    _check_start(game, problems)
    for phase in phases_of(game):
        _check_capacity(phase, game, problems, sources)


def _check_start(game: ir.Game, problems: Problems) -> None:
    missing = [i for i in range(game.agents.number) if not _always_sent(game.start.body, i)]
    if missing:
        who = f"agent {missing[0]}" if len(missing) == 1 else f"agents {missing[0]} .. {missing[-1]}"
        problems.add(errors.NotSentAtStart(game.start.span, who=who))


def _always_sent(body: tuple[ir.Stmt, ...], agent: int) -> bool:
    """Returns whether the statements certainly send this agent (they stand in an `each agent`)."""
    for s in body:
        match s:
            case ir.Send() if s.after is None and not s.stay:
                return True
            case ir.Each(domain=ir.Domain(var=ir.Member(who="agent"), on=None, restriction=None)):
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


def _branches_send(s: ir.When, agent: int) -> bool:
    for branch in s.branches:
        decided = _decide(branch.test, agent)
        if decided is False:
            continue
        if not _always_sent(branch.body, agent):
            return False
        if decided is True:
            return True
    return _always_sent(s.otherwise, agent)


def _decide(test: ir.Expr, agent: int) -> bool | None:
    """Returns whether a condition holds for this agent, if that follows from its index alone."""
    parts = [_decide_one(p, agent) for p in conjuncts(test)]
    if False in parts:
        return False
    return True if all(p is True for p in parts) else None


def _decide_one(test: ir.Expr, agent: int) -> bool | None:
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
            return {
                "<": left < right,
                "<=": left <= right,
                ">": left > right,
                ">=": left >= right,
                "==": left == right,
                "!=": left != right,
            }[test.fn]
        case ir.Truth():
            return test.value
        case _:
            return None


def _number(e: ir.Expr, agent: int) -> float | None:
    match e:
        case ir.Number():
            return e.value
        case ir.Attribute(name="index"):
            return agent
        case ir.Arithmetic(fn="%"):
            left, right = _number(e.args[0], agent), _number(e.args[1], agent)
            return None if left is None or not right else left % right
        case _:
            return None


def _check_capacity(phase: ir.Phase, game: ir.Game, problems: Problems, sources: Mapping[str, Source]) -> None:
    pools: dict[int, Pool] = {}
    for agent in range(game.agents.number):
        for send in _possible_sends(phase.body, agent):
            pool = pools.setdefault(send.pool, Pool())
            pool.agents.add(agent)
            if send not in pool.sends:
                pool.sends.append(send)
    starting = phase is game.start
    for pool in pools.values():
        needed = len(pool.agents) if starting else game.agents.number
        cells = _sure_cells(pool.sends[0].domain, game, starting)
        lacking = [s for s in pool.sends if not s.stay]
        if cells < needed and lacking:
            domain = pool.sends[0].domain
            span, place = lacking[0].span, _as_written(domain, sources)
            if domain.where is None and starting:
                problems.add(errors.TooFewCells(span, kind=place, cells=cells, agents=needed))
            elif starting:
                problems.add(errors.TooFewToStart(span, place=place, cells=cells, agents=needed))
            elif domain.where is None:
                problems.add(errors.TooFewFreeCells(span, place=place, cells=cells, agents=needed))
            else:
                problems.add(errors.NoFreeCell(span, place=place))
    _check_overlap(pools, problems)


def _as_written(domain: ir.Domain, sources: Mapping[str, Source]) -> str:
    """Returns a destination as its author wrote it, on one line."""
    span = domain.origin
    if span is None or span.file not in sources:
        return domain_text(domain)
    return " ".join(re.sub(r"#[^\n]*", "", sources[span.file].text[span.start : span.end]).split())


def _possible_sends(body: tuple[ir.Stmt, ...], agent: int) -> list[ir.Send]:
    """Returns the sends that may reach this agent, as far as conditions on its index tell."""
    found: list[ir.Send] = []
    for s in body:
        match s:
            case ir.Send():
                found.append(s)
            case ir.Each() | ir.Pick() | ir.First():
                own = s.domain.var.who == "agent" and s.domain.where is not None
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


def _when_sends(s: ir.When, agent: int) -> list[ir.Send]:
    found: list[ir.Send] = []
    for branch in s.branches:
        decided = _decide(branch.test, agent)
        if decided is not False or not _innermost(branch.body):
            found += _possible_sends(branch.body, agent)
        if decided is True and _innermost(branch.body):
            return found
    return found + _possible_sends(s.otherwise, agent)


def _sure_cells(domain: ir.Domain, game: ir.Game, starting: bool) -> int:
    """Returns how many cells of a destination are certainly there; at the start, the map decides `where` too."""
    if domain.where is not None and not starting:
        return 0
    glyphs = {g.glyph: g for g in game.glyphs}
    starts = {g.glyph: starts_of(game, g) for g in game.glyphs}
    count = 0
    for row in game.rows:
        for glyph in row:
            meaning = glyphs[glyph]
            if meaning.kind in domain.var.kinds:
                count += domain.where is None or _cell_fits(domain.where, domain.var.name, starts[glyph])
    return count


def _cell_fits(test: ir.Expr, name: str, values: Mapping[str, object]) -> bool:
    """Returns whether a condition on the cell's own fields certainly holds for these values."""
    match test:
        case ir.Logic(fn="and"):
            return all(_cell_fits(a, name, values) for a in test.args)
        case ir.Same(left=ir.FieldRead(owner=ir.Member(name=owner)) as left, right=ir.Word(value=word)):
            return owner == name and values[left.name] == word
        case ir.Not(value=ir.Same(left=ir.FieldRead(owner=ir.Member(name=owner)) as left, right=ir.Word(value=word))):
            return owner == name and values[left.name] != word
        case _:
            return False


def _check_overlap(pools: dict[int, Pool], problems: Problems) -> None:
    """Two different destinations of one phase must not share cells."""
    first = list(pools.values())
    for i, a in enumerate(first):
        for b in first[i + 1 :]:
            if set(a.sends[0].domain.var.kinds) & set(b.sends[0].domain.var.kinds):
                span = b.sends[0].origin
                problems.add(errors.OverlappingSends(span, kind=" | ".join(b.sends[0].domain.var.kinds)))  # type: ignore[arg-type]
