"""Monitors: find the first violation of a check in the values it reads along a trajectory; the same for both engines."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import counts_of
from sjdsl.interpreter.step import Totals

REAL = 1e-6  # reals closer than this, relative, are equal
DRIFT = 1e-4  # rounding error allowed in sums of reals over an episode, relative
CONFIDENCE = 0.95
FLOATS = -1  # stands for the index of a check that every real stays inside float32
STATES = ("always", "once", "conserved", "monotone")  # checks about the states of a trajectory


@dataclass(frozen=True)
class Violation:
    """Where a check is violated: the state `at` (0: the one an episode starts from), compared with an earlier state, `since`."""

    at: int
    since: int | None = None


def find_violation(check: ir.Check, values: Sequence[Sequence[Any]]) -> Violation | None:
    """Returns the first violation of a check in a trajectory.

    Args:
      check: an `always`, `once`, `conserved` or `monotone`.
      values: for the first state and the one after each step the values of the check's expressions.
    """
    match check.sort:
        case "always":
            return next(
                (Violation(t) for t, (holds,) in enumerate(values) if t and not holds), None
            )
        case "once":
            since = next((t for t, (trigger, _) in enumerate(values) if t and trigger), len(values))
            return next(
                (Violation(t, since) for t in range(since, len(values)) if not values[t][1]), None
            )
        case "conserved":
            first = values[0][0]
            return next(
                (
                    Violation(t, 0)
                    for t, (value,) in enumerate(values)
                    if not _same(value, first, DRIFT)
                ),
                None,
            )
        case "monotone":
            return _turn(values, rising=check.words[0] == "rising")
        case _:
            raise AssertionError(check.sort)


def _same(a: Any, b: Any, tolerance: float = REAL) -> bool:
    if isinstance(a, tuple):
        return all(_same(x, y, tolerance) for x, y in zip(a, b, strict=True))
    if isinstance(a, str | bool | int | frozenset) or a is None:
        return bool(a == b)
    return abs(float(a) - float(b)) <= tolerance * max(1.0, abs(float(a)), abs(float(b)))


def _turn(values: Sequence[Sequence[Any]], rising: bool) -> Violation | None:
    """Returns the first state that, compared with an earlier one, changes the first value the wrong way for the second."""
    sign = 1 if rising else -1
    seen: dict[tuple[float, float], int] = {}
    for t, (value, argument) in enumerate(values):
        here = (float(value), float(argument))
        if here in seen:
            continue
        for (other_value, other_argument), since in seen.items():
            change = sign * (here[0] - other_value) * (1 if here[1] > other_argument else -1)
            if (
                change < 0
                and not _same(here[0], other_value)
                and not _same(here[1], other_argument)
            ):
                return Violation(t, since)
        seen[here] = t
    return None


def add_totals(
    before: Totals, events: Mapping[str, Any], game: ir.Game
) -> dict[tuple[str, str | None], int]:
    """Returns the totals after a step that counted `events`, as the interpreter's outcome has them."""
    totals = dict(before)
    for event in game.events:
        counts = events[event.name]
        rows = counts if event.per_agent else [counts]
        for i, (word, _) in enumerate(counts_of(event)):
            totals[event.name, word] = totals.get((event.name, word), 0) + sum(
                row[i] if event.by else row for row in rows
            )
    return totals


def least_share(trials: int) -> float:
    """Returns the 95% lower confidence bound of a probability of success after so many trials, all of them successes; exact.

    Source: Clopper and Pearson 1934, one-sided, all trials successes: share^n = 5%.
    """
    return float((1 - CONFIDENCE) ** (1 / trials))
