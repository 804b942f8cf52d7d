"""Whether a Schelling diagram shows a dilemma, by the intervals of its four contrasts; and how many
samples would settle it."""

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
# Probability of settling each deciding contrast if the means and deviations of the samples were the
# true ones.
POWER = 0.9
MAX_SAMPLES = 10**4  # more are out of reach in practice


@dataclass(frozen=True)
class Verdict:
    """Whether there is a dilemma, by the intervals."""

    outcome: Outcome
    fear: bool  # by its lower bound
    greed: bool  # by its lower bound
    reason: str  # which bounds decide, in a sentence
    # Total samples that would probably settle it; None if it is settled, or if no number would.
    wanted: int | None = None
    # Contrasts it rests on whose samples are all equal, so that their intervals have no width.
    without_spread: tuple[str, ...] = ()

    @property
    def shape(self) -> str:
        """Which of fear and greed are present by their lower bounds: `fear and greed`, `fear`,
        `greed` or `neither`."""
        if self.fear:
            return "fear and greed" if self.greed else "fear"
        return "greed" if self.greed else "neither"


def judge(samples: Mapping[str, np.ndarray]) -> Verdict:
    """Returns the verdict, at 95 % confidence, on the samples `[units]` of the contrasts A, B, fear
    and greed."""
    contrasts = estimate_contrasts(samples)
    outcome = outcome_of(contrasts)
    return Verdict(
        outcome,
        fear=contrasts["fear"].low > 0,
        greed=contrasts["greed"].low > 0,
        reason=_reason(outcome, contrasts),
        wanted=samples_wanted(samples) if outcome == "undecided" else None,
        without_spread=_without_spread(outcome, contrasts, samples),
    )


def outcome_of(contrasts: Mapping[str, Estimate]) -> Outcome:
    """Returns the verdict on intervals: a dilemma by lower bounds, none by upper bounds, else
    undecided."""
    a, b, fear, greed = (contrasts[name] for name in ("A", "B", "fear", "greed"))
    if a.low > 0 and b.low > 0 and (fear.low > 0 or greed.low > 0):
        return "dilemma"
    if a.high <= 0 or b.high <= 0 or (fear.high <= 0 and greed.high <= 0):
        return "no dilemma"
    return "undecided"


def _without_spread(
    outcome: Outcome, contrasts: Mapping[str, Estimate], samples: Mapping[str, np.ndarray]
) -> tuple[str, ...]:
    """Returns the contrasts with all-equal samples that a verdict rests on.

    There are none if the verdict would be the same whatever these contrasts are.
    """
    equal = {
        name for name, values in samples.items() if len(values) > 1 and _deviation(values) == 0
    }
    unknown = Estimate(math.nan, -math.inf, math.inf)
    without_equal = dict(contrasts) | dict.fromkeys(equal, unknown)
    if outcome == "undecided" or outcome_of(without_equal) == outcome:
        return ()
    above, below = _decided(contrasts)
    deciding = above if outcome == "dilemma" else below
    return tuple(name for name in deciding if name in equal)


def _decided(contrasts: Mapping[str, Estimate]) -> tuple[list[str], list[str]]:
    """Returns the contrasts whose lower bounds are above 0, and those whose upper bounds aren't."""
    above = [name for name, figure in contrasts.items() if figure.low > 0]
    below = [name for name, figure in contrasts.items() if figure.high <= 0]
    return above, below


def share_that_may_differ(number: int) -> float:
    """Returns the 95 % upper bound of the share of further samples that may differ, after `number`
    equal ones.

    Source: the exact binomial bound after no events, Clopper and Pearson 1934.
    """
    return float(1 - (1 - CONFIDENCE) ** (1 / number))


def _reason(outcome: Outcome, contrasts: Mapping[str, Estimate]) -> str:
    """Returns which bounds decide an outcome, in a sentence."""
    above, below = _decided(contrasts)
    if outcome == "dilemma":
        return f"the lower bounds of {listed(above)} are above 0"
    if outcome == "no dilemma":
        if len(below) == 1:
            return f"the upper bound of {below[0]} is not above 0"
        return f"{listed(below)} are not above 0 by upper bounds"
    undecided = [name for name in contrasts if name not in (*above, *below)]
    return f"0 is inside the interval of {listed(undecided)}"


def listed(names: Sequence[str]) -> str:
    """Returns `A`, `A and B` or `A, B and fear`."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def samples_wanted(samples: Mapping[str, np.ndarray]) -> int | None:
    """Returns how many samples in total would probably settle the verdict; None if their spread is
    unknown, or if no number would.

    With that many samples, each deciding contrast would be settled with probability 0.9 if the
    means and standard deviations of the samples were the true ones.
    """
    number = len(samples["A"])
    if number < 2:
        return None

    def is_settled(count: int) -> bool:
        estimates = {name: _probable_estimate(values, count) for name, values in samples.items()}
        return outcome_of(estimates) != "undecided"

    # Bisection: if some number of samples settles the verdict, so does any larger number.
    low = number
    high = number + 1
    while not is_settled(high):
        low = high
        high = 2 * high
        if low > MAX_SAMPLES:
            return None
    return low + 1 + bisect_left(range(low + 1, high), True, key=is_settled)


def _deviation(values: np.ndarray) -> float:
    """Returns the standard deviation; exactly 0 if all values are equal."""
    return 0.0 if (values == values[0]).all() else float(values.std(ddof=1))


def _probable_estimate(samples: np.ndarray, count: int) -> Estimate:
    """Returns the estimate whose bounds `count` samples would probably reach or improve on.

    It has the mean and the standard deviation of `samples`.
    """
    mean = float(samples.mean())
    deviations = stats.t.ppf(0.5 + JOINT_CONFIDENCE / 2, count - 1) + stats.norm.ppf(POWER)
    margin = float(deviations) * _deviation(samples) / math.sqrt(count)
    return Estimate(mean, mean - margin, mean + margin)
