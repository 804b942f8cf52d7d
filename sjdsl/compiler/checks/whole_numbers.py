"""Whole numbers stay in int32 in all that can happen.

That is checked when a game is compiled with its own parameters, and again when others are set. A
number that left int32 would wrap round in the compiled game, without an error. All numbers of the
rules and the sums of each phase are checked, but not what a `require` reads: that is never computed
in int32.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import count
from math import inf
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.checks.phase_sums import Sum, Sums, Target, merged, sums_of
from sjdsl.compiler.checks.value_ranges import (
    HIGHEST,
    LOWEST,
    Held,
    Interval,
    IntRanges,
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

# After so many rounds a timer that doubles has left int32; one that still rises is taken to have
# no end.
ROUNDS = 40
# What can be bounded.
READ = ir.ParamRef | ir.Local | ir.FieldRead | ir.Step | ir.Count | ir.EventTotal
DECIMALS = (
    "compute with decimal numbers, which have no such limits: write `1000000.0` for `1000000`"
)


def check_whole_numbers(game: ir.Game, problems: Problems) -> None:
    """Reports what leaves int32 with the parameters of the file, and an episode without a step."""
    for problem in beyond_int32(game, {p.name: p.value for p in game.params}):
        problems.add(problem)


def beyond_int32(game: ir.Game, params: Mapping[str, Any]) -> list[Diagnostic]:
    """Returns why a game cannot be played with these parameters.

    Whole numbers can leave int32, or an episode has no step.

    Args:
      params: the value of each by name, a table as nested tuples in the order of its entries.
    """
    played = Played(game, params, trials=1 if game.trials is None else game.trials.number)
    low, high = interval_of(game.episode, IntRanges(played))
    if low < 1 or played.leaving or high * played.trials > HIGHEST:
        return [_of_episode(played, low, high)]
    played.steps = high
    phases = _settled(played)
    in_step = merged(phases)
    events = {target: sum_ for target, sum_ in in_step.items() if target.sort == "event"}
    for target, sum_ in events.items():  # at most, in an episode, over all agents
        receivers = game.agents.number if event_named(game, target.name).per_agent else 1
        played.totals[target.name] = times(sum_.high, played.steps_of_episode * receivers)
    for part in ir.children(game):
        is_required = isinstance(part, ir.Check) and part.kind == "require"
        if not isinstance(part, ir.Phase) and not is_required:
            visit(part, IntRanges(played))
    problems = [_of_number(leaving) for leaving in played.leaving]
    for target, sum_ in events.items():
        if leaves_int32(sum_.interval):
            problems.append(_of_sum(errors.TalliedBeyondInt32, target, sum_, sum_.interval))
    for sums in phases:
        for target, sum_ in sums.items():
            if target.sort == "field" and leaves_int32(_in_field(sum_)):
                problems.append(_of_sum(errors.AddedBeyondInt32, target, sum_, _in_field(sum_)))
    return problems


def _settled(played: Played) -> list[Sums]:
    """Goes through the phases until no timer rises any more, or the episode is over.

    Returns what each phase adds.
    """
    phases = phases_of(played.game)
    starts = _starts_of_timers(played.game)
    played.timers = starts
    for number in count():
        played.leaving = []
        played.sets = {}
        played.growth = {}
        sums = [sums_of(phase, IntRanges(played)) for phase in phases]
        rising = {}
        for held, before in played.timers.items():
            grown = times(played.growth.get(held, 0), played.steps_of_episode)
            reached = max(starts[held], played.sets.get(held, 0)) + grown
            if reached > before:
                rising[held] = reached if number < ROUNDS else inf
        if not rising or number >= played.steps_of_episode * len(phases):
            return sums
        played.timers = {**played.timers, **rising}
    raise AssertionError


def _starts_of_timers(game: ir.Game) -> dict[Held, float]:
    """Returns the largest value that each timer begins with on the map."""
    starts: dict[Held, float] = {}
    for timer in all_fields(game):
        if timer.timer:
            held = (timer.held_by.what, timer.name)
            starts.setdefault(held, 0)
            for glyph in game.glyphs:
                start = dict(glyph.starts).get(timer.name)
                if glyph.kind == timer.held_by.name and isinstance(start, int):
                    starts[held] = max(starts[held], start)
    return starts


def _in_field(added: Sum) -> Interval:
    """Returns what a field can hold before it is brought into its range.

    That is its value and all that a phase adds to it.
    """
    assert isinstance(added.part.statement, ir.Add)
    range_ = added.part.statement.target.type
    return range_.low + added.low, range_.high + added.high


# ---- messages


def _of_episode(played: Played, low: float, high: float) -> Diagnostic:
    """Returns the message about an episode without steps, or with too many."""
    episode = played.game.episode
    value = low
    if played.leaving:
        _, value = played.leaving[0].interval
    elif low >= 1:
        value = high * played.trials
    return errors.OutOfLimits(
        episode.span,
        labels=_values_read(episode, played),
        name="the number of steps of an episode",
        value=value,
        low=1,
        high=HIGHEST,
    )


def _of_number(leaving: Leaving) -> Diagnostic:
    """Returns the message about a whole number that can leave int32."""
    value = leaving.value
    name = text(value)
    if isinstance(value, ir.Arithmetic) and name.startswith("("):
        name = name[1:-1]  # as an author would write it
    labels = _values_read(value, leaving.ranges.played)
    reached, limit = _beyond(leaving.interval)
    return errors.BeyondInt32(
        value.span, labels=labels, name=name, reached=reached, limit=limit, help=_bounded(leaving)
    )


def _beyond(interval: Interval) -> tuple[float, int]:
    """Returns how far an interval goes beyond int32, and the limit that it goes beyond."""
    low, high = interval
    return (high, HIGHEST) if high > HIGHEST else (low, LOWEST)


def _bounded(leaving: Leaving) -> str:
    """Returns how the number stays within its limits: by a bound of the first part that has one."""
    value = leaving.value
    if isinstance(value, ir.FieldRead):  # a timer
        return f"bound what it is set to: `set {text(value)} = min(…, 1000)`"
    parts = (node for node in ir.walk(value) if isinstance(node, READ) and node.type.kind == "int")
    for part in parts:
        bound = _bound(part, leaving)
        if bound is None:
            continue
        name = text(part)
        match part:
            case ir.ParamRef():
                return f"`{name}` can be {bound} at most"
            case ir.Step():
                return f"guard it with `when step <= {bound}`, or let the episode be shorter"
        guard = f"guard it with `when {name} <= {bound}`"
        return f"{guard}, or see to it that `{name}` has a smaller range"
    return DECIMALS


def _bound(part: ir.Expr, leaving: Leaving) -> int | None:
    """Returns the largest value of a part of a number with which that stays in int32.

    None if there is none above 0.
    """

    def fits(bound: int) -> bool:
        """Returns whether the number stays in int32 if what it reads is at most `bound`."""
        played = replace(leaving.ranges.played, leaving=[])
        ranges = leaving.ranges
        if isinstance(part, ir.ParamRef):
            played.params = {**played.params, part.name: bound}
        else:
            ranges = ranges.bounded(part, (-inf, bound))
        interval_of(leaving.value, replace(ranges, played=played))
        return not played.leaving

    return None if part.type.indexed_by or not fits(1) else boundary(1, HIGHEST, fits)


def boundary(good: int, bad: int, fits: Callable[[int], bool]) -> int:
    """Returns the number that is nearest to `bad` and still fits, `good` if no other does."""
    while abs(good - bad) > 1:
        middle = (good + bad) // 2
        if fits(middle):
            good = middle
        else:
            bad = middle
    return good


def _values_read(e: ir.Expr, played: Played) -> tuple[Label, ...]:
    """Returns where the parameters that a number reads are declared, with their values."""
    names = {node.name for node in ir.walk(e) if isinstance(node, ir.ParamRef)}
    return tuple(
        Label(param.span, f"`{param.name}` is {played.params[param.name]}")
        for param in played.game.params
        if param.name in names and not param.type.indexed_by and param.origin is not None
    )


def _of_sum(
    kind: type[errors.AddedBeyondInt32], target: Target, sum_: Sum, interval: Interval
) -> Diagnostic:
    """Reports the statement that takes a sum farthest, and how much of it at a time would not."""
    reached, limit = _beyond(interval)
    part = sum_.part
    room = part.most - abs(reached - limit)
    most = int(room // part.often) if room > 0 else 0
    help_ = f"it can be {most} at a time at most" if most else ""
    return kind(
        part.statement.span,
        name=target.name,
        reached=reached,
        limit=limit,
        often=int(part.often),
        help=help_,
    )
