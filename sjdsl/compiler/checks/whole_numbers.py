"""Whole numbers stay in int32 in all that can happen: when a game is compiled with its own parameters, and again when others are set.

What left it would go on at the other end without a word, in the compiled game. Looked at are all numbers of the rules but those of
`require`, which are never computed in int32, and the sums of each phase.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from math import inf
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.checks.phase_sums import Sum, Sums, Target, merged, sums_of
from sjdsl.compiler.checks.value_ranges import (
    HIGHEST,
    LOWEST,
    Held,
    Here,
    Interval,
    Leaving,
    Played,
    interval_of,
    leaves_int32,
    visit,
)
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import Diagnostic, Label
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.ir.printer import expression_text as text
from sjdsl.compiler.ir.queries import all_fields, event_named, phases_of
from sjdsl.compiler.ir.types import times

ROUNDS = 40  # after so many a timer that doubles has left int32, and one that still rises is taken to have no end
READ = (
    ir.ParamRef,
    ir.Local,
    ir.FieldRead,
    ir.Step,
    ir.Count,
    ir.EventTotal,
)  # what can be bounded


def check_whole_numbers(game: ir.Game, problems: Problems) -> None:
    """Reports what leaves int32 with the parameters of the file, and an episode without a step."""
    for problem in beyond_int32(game, {p.name: p.value for p in game.params}):
        problems.add(problem)


def beyond_int32(game: ir.Game, params: Mapping[str, Any]) -> list[Diagnostic]:
    """Returns why a game cannot be played with these parameters: whole numbers that can leave int32, an episode without a step.

    Args:
      params: the value of each parameter by name, a table as nested tuples in the order of its entries.
    """
    played = Played(game, params, trials=1 if game.trials is None else game.trials.number)
    low, high = interval_of(game.episode, Here(played))
    if low < 1 or played.leaving or high * played.trials > HIGHEST:
        value = played.leaving[0].interval[1] if played.leaving else low
        if value >= 1 and not played.leaving:
            value = high * played.trials
        labels = _values_read(game.episode, played)
        name = "the number of steps of an episode"
        return [
            errors.OutOfLimits(
                game.episode.span, labels=labels, name=name, value=value, low=1, high=HIGHEST
            )
        ]
    played.steps = high
    phases = _settled(played)
    events = {target: own for target, own in merged(phases).items() if target.sort == "event"}
    for (
        target,
        own,
    ) in events.items():  # how often it is counted in an episode at most, over all agents
        receivers = game.agents.number if event_named(game, target.name).per_agent else 1
        played.totals[target.name] = times(own.high, played.steps_of_episode * receivers)
    for part in ir.children(game):
        is_required = (
            isinstance(part, ir.Check) and part.kind == "require"
        )  # decided in Python's numbers, before the game is played
        if not isinstance(part, ir.Phase) and not is_required:
            visit(part, Here(played))
    found: list[Diagnostic] = [_of_number(leaving) for leaving in played.leaving]
    found += [
        _of_sum(errors.TalliedBeyondInt32, target, own, own[:2])
        for target, own in events.items()
        if leaves_int32(own[:2])
    ]
    fields = [pair for sums in phases for pair in sums.items() if pair[0].sort == "field"]
    found += [
        _of_sum(errors.AddedBeyondInt32, target, own, _in_field(own))
        for target, own in fields
        if leaves_int32(_in_field(own))
    ]
    return found


def _settled(played: Played) -> list[Sums]:
    """Goes through the phases until no timer rises any more, or the episode is over, and returns what each of them adds."""
    game = played.game
    phases = phases_of(played.game)
    starts: dict[Held, float] = {}  # the largest value that each timer begins with on the map
    for timer in (field for field in all_fields(game) if field.timer):
        values = [
            v
            for glyph in game.glyphs
            if glyph.kind == timer.held_by.name
            for name, v in glyph.starts
            if name == timer.name
        ]
        starts[timer.held_by.what, timer.name] = max(
            (value for value in values if isinstance(value, int)), default=0
        )
    played.timers = starts
    round_ = 0
    while True:
        played.leaving = []
        played.sets = {}
        played.growth = {}
        sums = [sums_of(phase, Here(played)) for phase in phases]
        rising = {}
        for held, before in played.timers.items():
            reached = max(starts[held], played.sets.get(held, 0)) + times(
                played.growth.get(held, 0), played.steps_of_episode
            )
            if reached > before:
                rising[held] = reached if round_ < ROUNDS else inf
        if not rising or round_ >= played.steps_of_episode * len(phases):
            return sums
        played.timers = {**played.timers, **rising}
        round_ = round_ + 1


def _in_field(added: Sum) -> Interval:
    """Returns what a field can hold before it is brought into its range: its value and all that a phase adds to it."""
    assert isinstance(added.part.statement, ir.Add)
    range_ = added.part.statement.target.type
    return range_.low + added.low, range_.high + added.high


# ---- messages


def _of_number(leaving: Leaving) -> Diagnostic:
    """Returns the message about a whole number that can leave int32."""
    value = leaving.value
    name = text(leaving.value)
    name = (
        name[1:-1] if isinstance(value, ir.Arithmetic) and name.startswith("(") else name
    )  # as an author would write it
    labels = _values_read(value, leaving.here.played)
    reached, limit = _beyond(leaving.interval)
    return errors.BeyondInt32(
        value.span, labels=labels, name=name, reached=reached, limit=limit, help=_bounded(leaving)
    )


def _beyond(interval: Interval) -> tuple[float, int]:
    """Returns how far an interval goes beyond int32, and the limit that it goes beyond."""
    low, high = interval
    return (high, HIGHEST) if high > HIGHEST else (low, LOWEST)


def _bounded(leaving: Leaving) -> str:
    """Returns how the number stays within its limits: by a bound of the first number in it for which there is one."""
    value = leaving.value
    if isinstance(value, ir.FieldRead):  # a timer
        return f"bound what it is set to: `set {text(value)} = min(…, 1000)`"
    read = {
        text(node): node
        for node in ir.walk(value)
        if isinstance(node, READ) and node.type.kind == "int"
    }
    for said, node in read.items():
        bound = _bound(node, leaving)
        match node:
            case _ if bound is None:
                continue
            case ir.ParamRef():
                return f"`{said}` can be {bound} at most"
            case ir.Step():
                return f"guard it with `when step <= {bound}`, or let the episode be shorter"
            case _:
                return f"guard it with `when {said} <= {bound}`, or see to it that `{said}` has a smaller range"
    return (
        "compute with decimal numbers, which have no such limits: write `1000000.0` for `1000000`"
    )


def _bound(node: ir.Expr, leaving: Leaving) -> int | None:
    """Returns the largest value of a part of a number with which that stays in int32, None if there is none above 0."""

    def fits(bound: int) -> bool:
        """Returns whether the number stays in int32 if what it reads is at most `bound`."""
        played = replace(leaving.here.played, leaving=[])
        here = leaving.here
        if isinstance(node, ir.ParamRef):
            played.params = {**played.params, node.name: bound}
        else:
            here = here.bounded(node, (-inf, bound))
        interval_of(leaving.value, replace(here, played=played))
        return not played.leaving

    return None if node.type.indexed_by or not fits(1) else boundary(1, HIGHEST, fits)


def boundary(good: int, bad: int, fits: Callable[[int], bool]) -> int:
    """Returns the number that is nearest to `bad` and still fits, `good` if no other does."""
    while abs(good - bad) > 1:
        middle = (good + bad) // 2
        good, bad = (middle, bad) if fits(middle) else (good, middle)
    return good


def _values_read(e: ir.Expr, played: Played) -> tuple[Label, ...]:
    """Returns where the parameters that a number reads are declared, with their values."""
    named = {n.name for n in ir.walk(e) if isinstance(n, ir.ParamRef)}
    declared = [
        p
        for p in played.game.params
        if p.name in named and not p.type.indexed_by and p.origin is not None
    ]
    return tuple(Label(p.span, f"`{p.name}` is {played.params[p.name]}") for p in declared)


def _of_sum(
    kind: type[errors.AddedBeyondInt32], target: Target, own: Sum, interval: Interval
) -> Diagnostic:
    """Reports the statement that takes a sum farthest, and how much of it at a time would not."""
    reached, limit = _beyond(interval)
    room = own.part.most - abs(reached - limit)
    each = int(room // own.part.often) if room > 0 else 0
    help_ = f"it can be {each} at a time at most" if each else ""
    return kind(
        own.part.statement.span,
        name=target.name,
        reached=reached,
        limit=limit,
        often=int(own.part.often),
        help=help_,
    )
