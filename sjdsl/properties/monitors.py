"""Finds the first violation of a check in the values that it reads along a trajectory.

These may come from either engine.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import counts_of
from sjdsl.interpreter.step import Totals

Total = tuple[str, str | None]  # an event, and one of its enum values or None
REAL = 1e-6  # reals closer than this, relative, are equal
DRIFT = 1e-4  # rounding error allowed in sums of reals over an episode, relative
CONFIDENCE = 0.95
FLOATS = -1  # stands for the index of a check that every real stays inside float32


@dataclass(frozen=True)
class Violation:
    """Where a check is violated.

    at: the state, 0 for the one that an episode starts from; since: the earlier state with which
    it is compared, if it is.
    """

    at: int
    since: int | None = None


def find_violation(check: ir.Check, values: Sequence[Sequence[Any]]) -> Violation | None:
    """Returns the first violation of a check in a trajectory.

    Args:
      check: an `always`, `once`, `conserved` or `monotone`.
      values: for the first state and the one after each step the values of the check's expressions.
    """
    match check.kind:
        case "always":
            for t, (holds,) in enumerate(values):
                if t > 0 and not holds:
                    return Violation(t)
            return None
        case "once":
            since = None
            for t, (trigger, holds) in enumerate(values):
                if since is None and t > 0 and trigger:
                    since = t
                if since is not None and not holds:
                    return Violation(t, since)
            return None
        case "conserved":
            first = values[0][0]
            for t, (value,) in enumerate(values):
                if not _same(value, first, DRIFT):
                    return Violation(t, 0)
            return None
        case "monotone":
            return _find_turn(values, rising=check.words[0] == "rising")
        case _:
            raise AssertionError(check.kind)


def _same(a: Any, b: Any, tolerance: float = REAL) -> bool:
    """Returns whether two values are equal, reals up to a relative tolerance."""
    if isinstance(a, tuple):
        return all(_same(x, y, tolerance) for x, y in zip(a, b, strict=True))
    if isinstance(a, str | bool | int | frozenset) or a is None:
        return bool(a == b)
    return abs(float(a) - float(b)) <= tolerance * max(1.0, abs(float(a)), abs(float(b)))


def _find_turn(values: Sequence[Sequence[Any]], rising: bool) -> Violation | None:
    """Returns the first state whose value has changed the wrong way since an earlier state.

    Args:
      values: (value, argument) in each state.
      rising: whether the value must grow where the argument does, or else shrink.
    """
    sign = 1 if rising else -1
    seen: dict[tuple[float, float], int] = {}
    for t, (new_value, new_argument) in enumerate(values):
        value = float(new_value)
        argument = float(new_argument)
        if (value, argument) in seen:
            continue
        for (old_value, old_argument), since in seen.items():
            wanted_sign = sign if argument > old_argument else -sign
            is_wrong = wanted_sign * (value - old_value) < 0
            if is_wrong and not (_same(value, old_value) or _same(argument, old_argument)):
                return Violation(t, since)
        seen[value, argument] = t
    return None


def add_totals(before: Totals, events: Mapping[str, Any], game: ir.Game) -> dict[Total, int]:
    """Returns the totals after a step.

    Args:
      events: the counts of the step, from the interpreter's `Outcome`.
    """
    totals = dict(before)
    for event in game.events:
        counts = events[event.name]
        rows = counts if event.per_agent else [counts]
        for i, (word, _) in enumerate(counts_of(event)):
            count = sum(row[i] if event.by else row for row in rows)
            totals[event.name, word] = totals.get((event.name, word), 0) + count
    return totals


def least_share(trials: int) -> float:
    """Returns the 95% lower confidence bound of a probability after trials that all succeeded.

    Source: Clopper and Pearson 1934, one-sided, exact: share^trials = 5%.
    """
    return float((1 - CONFIDENCE) ** (1 / trials))
