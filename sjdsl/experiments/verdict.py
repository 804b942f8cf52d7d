"""Whether a Schelling diagram shows a dilemma, by the intervals of its four contrasts; and how many samples would settle it."""

import math
from bisect import bisect_left
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy import stats

from sjdsl.experiments.contrasts import CONFIDENCE, JOINT_CONFIDENCE, estimate_contrasts
from sjdsl.trainers.policies.estimates import Estimate

Outcome = Literal["dilemma", "no dilemma", "undecided"]
POWER = 0.9  # probability of settling each deciding contrast, if the means and deviations found were the true ones
MOST = 10**4  # samples; more are out of reach in practice


@dataclass(frozen=True)
class Verdict:
    """Whether there is a dilemma, by the intervals."""

    outcome: Outcome
    fear: bool  # by its lower bound
    greed: bool  # by its lower bound
    reason: str  # which bounds decide, in a sentence
    wanted: int | None = (
        None  # total samples that would probably settle it; None if it is settled, or no number would
    )
    without_spread: tuple[
        str, ...
    ] = ()  # contrasts it rests on whose samples are all equal, so their intervals have no width

    @property
    def shape(self) -> str:
        """Which of fear and greed are present by their lower bounds: `fear and greed`, `fear`, `greed` or `neither`."""
        return (
            " and ".join(
                name for name, there in (("fear", self.fear), ("greed", self.greed)) if there
            )
            or "neither"
        )


def judge(samples: Mapping[str, np.ndarray]) -> Verdict:
    """Returns the verdict, at 95 % confidence, on the samples `[units]` of the contrasts A, B, fear and greed."""
    found = estimate_contrasts(samples)
    outcome = outcome_of(found)
    fear, greed = found["fear"].low > 0, found["greed"].low > 0
    wanted = samples_wanted(samples) if outcome == "undecided" else None
    return Verdict(
        outcome,
        fear,
        greed,
        _reason(outcome, found),
        wanted,
        _without_spread(outcome, found, samples),
    )


def outcome_of(found: Mapping[str, Estimate]) -> Outcome:
    """Returns the verdict on intervals: a dilemma by lower bounds, none by upper bounds, else undecided."""
    a, b, fear, greed = (found[name] for name in ("A", "B", "fear", "greed"))
    if a.low > 0 and b.low > 0 and (fear.low > 0 or greed.low > 0):
        return "dilemma"
    if a.high <= 0 or b.high <= 0 or (fear.high <= 0 and greed.high <= 0):
        return "no dilemma"
    return "undecided"


def _without_spread(
    outcome: Outcome, found: Mapping[str, Estimate], samples: Mapping[str, np.ndarray]
) -> tuple[str, ...]:
    """Returns the contrasts with all-equal samples that a verdict rests on; none if it would be the same whatever they are."""
    equal = {name for name, values in samples.items() if len(values) > 1 and not _deviation(values)}
    unknown = {
        name: Estimate(figure.mean, -math.inf, math.inf) if name in equal else figure
        for name, figure in found.items()
    }
    if outcome == "undecided" or outcome_of(unknown) == outcome:
        return ()
    decide = [
        name
        for name in found
        if (found[name].low > 0 if outcome == "dilemma" else found[name].high <= 0)
    ]
    return tuple(name for name in decide if name in equal)


def share_that_may_differ(number: int) -> float:
    """Returns the 95 % upper bound of the share of further samples that may differ, after `number` equal ones.

    Source: the exact binomial bound after no events, Clopper and Pearson 1934.
    """
    return float(1 - (1 - CONFIDENCE) ** (1 / number))


def _reason(outcome: Outcome, found: Mapping[str, Estimate]) -> str:
    above = [name for name, figure in found.items() if figure.low > 0]
    below = [name for name, figure in found.items() if figure.high <= 0]
    match outcome:
        case "dilemma":
            return f"the lower bounds of {listed(above)} are above 0"
        case "no dilemma":
            return (
                f"the upper bound of {listed(below)} is not above 0"
                if len(below) == 1
                else f"{listed(below)} are not above 0 by upper bounds"
            )
    return f"0 is inside the interval of {listed([name for name in found if name not in (*above, *below)])}"


def listed(names: Sequence[str]) -> str:
    """Returns `A`, `A and B` or `A, B and fear`."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def samples_wanted(samples: Mapping[str, np.ndarray]) -> int | None:
    """Returns how many samples in total would probably settle the verdict; None if their spread is unknown, or no number would.

    With that many samples, each deciding contrast would be settled with probability 0.9 if the means and standard deviations found were the
    true ones.
    """
    number = len(samples["A"])
    if number < 2:
        return None
    figures = {name: (float(values.mean()), _deviation(values)) for name, values in samples.items()}

    def settled(count: int) -> bool:
        narrow = {
            name: Estimate(mean, *_probable_bounds(mean, spread, count))
            for name, (mean, spread) in figures.items()
        }
        return outcome_of(narrow) != "undecided"

    low, high = number, number + 1  # bisection: once settled, more samples leave it settled
    while not settled(high):
        low, high = high, 2 * high
        if low > MOST:
            return None
    return low + 1 + bisect_left(range(low + 1, high), True, key=settled)


def _deviation(values: np.ndarray) -> float:
    return 0.0 if (values == values[0]).all() else float(values.std(ddof=1))


def _probable_bounds(mean: float, deviation: float, count: int) -> tuple[float, float]:
    """Returns bounds that `count` samples would probably reach or improve on."""
    margin = (
        float(stats.t.ppf(0.5 + JOINT_CONFIDENCE / 2, count - 1) + stats.norm.ppf(POWER))
        * deviation
        / math.sqrt(count)
        if deviation
        else 0.0
    )
    return mean - margin, mean + margin
