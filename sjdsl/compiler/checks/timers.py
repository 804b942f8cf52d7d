"""Checks timers: where in the schedule they count down (`tick`), and that rules set them on the right side of it."""

from sjdsl.compiler import ir
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.ir.queries import all_fields, body_sort, can_be
from sjdsl.compiler.ir.sorts import AGENTS


def check_timers(game: ir.Game, composition: Composition, problems: Problems) -> None:
    """Reports a missing, doubled or needless `tick`, and timers set on both sides of it."""
    timers = [field for field in all_fields(game) if field.timer]
    away = [body_sort(n.who) for n in ir.walk(game) if isinstance(n, ir.Send) and n.after is not None]
    ticks = [t for t in game.schedule if isinstance(t, ir.Tick)]
    assert composition.schedule is not None
    span = composition.schedule.span
    if (timers or away) and not ticks:
        who = "agents" if AGENTS in away or not away else f"movers `{away[0].name}`"
        what = "there are timers" if timers else f"{who} are sent away for some steps (`after`)"
        problems.add(errors.NoTick(span, what=what))
    if len(ticks) > 1:
        problems.add(errors.TickTwice(ticks[1].origin or span))
    if len(ticks) == 1:
        _check_sides(game, timers, problems)


def _check_sides(game: ir.Game, timers: list[ir.VarField], problems: Problems) -> None:
    at = next(i for i, t in enumerate(game.schedule) if isinstance(t, ir.Tick))
    for timer in timers:
        before = _sets(game.schedule[:at], timer)
        after = _sets(game.schedule[at + 1 :], timer)
        if before and after:
            problems.add(errors.TimerBothSides(before[0].origin or timer.span, name=timer.name))


def _sets(turns: tuple[ir.Turn, ...], timer: ir.VarField) -> list[ir.Set]:
    """Returns the statements that set a timer to something that can be above 0."""
    found = []
    for node in (n for t in turns for n in ir.walk(t)):
        if isinstance(node, ir.Set) and isinstance(node.target, ir.FieldRead) and can_be(node.target, timer) and node.value.type.high > 0:
            found.append(node)
    return found
