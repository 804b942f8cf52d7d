"""A Schelling diagram of N agents: both lines, the contrasts, the verdict, and all of it as JSON values."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from sjdsl.experiments.contrasts import (
    CONFIDENCE,
    IN_WORDS,
    JOINT_CONFIDENCE,
    Returns,
    contrast_samples,
    estimate_contrasts,
    estimate_lines,
    preferences,
)
from sjdsl.experiments.playing import Experiment, Part
from sjdsl.experiments.verdict import Verdict, judge, listed, share_that_may_differ
from sjdsl.trainers.policies.estimates import Estimate

FORMAT = 1  # of schelling.json
ENOUGH = 300  # equal samples after which at most 1 % of further ones may differ


@dataclass(frozen=True)
class Diagram:
    """A Schelling diagram of N agents. C(l), D(l): mean return of a cooperator, of a defector, when l of the other agents cooperate."""

    experiment: Experiment
    returns: Returns

    @property
    def cooperating(self) -> tuple[Estimate, ...]:
        """C(0) .. C(N-1), each with its own 95 % interval."""
        return estimate_lines(self.returns, self.returns.cooperating)

    @property
    def defecting(self) -> tuple[Estimate, ...]:
        """D(0) .. D(N-1), each with its own 95 % interval."""
        return estimate_lines(self.returns, self.returns.defecting)

    @property
    def everybody(self) -> tuple[Estimate, ...]:
        """Mean return of all agents, by k = 0 .. N."""
        return estimate_lines(self.returns, self.returns.everybody)

    @property
    def preferences(self) -> tuple[tuple[Estimate, str], ...]:
        """D(l) - C(l) for each l, and which an agent prefers: `defect`, `cooperate`, `equal` or `undecided`."""
        return preferences(self.returns)

    @property
    def contrasts(self) -> dict[str, Estimate]:
        """A, B, fear and greed, whose intervals hold at 95 % together."""
        return estimate_contrasts(contrast_samples(self.returns))

    @property
    def verdict(self) -> Verdict:
        """Whether it is a dilemma."""
        return judge(contrast_samples(self.returns))

    @property
    def units(self) -> int:
        """The number of samples of each interval."""
        return (
            self.experiment.replicates
            if self.returns.unit == "training seed"
            else self.experiment.episodes
        )

    @property
    def population(self) -> str:
        """The samples of the intervals, in words."""
        return (
            f"{self.units} training seeds"
            if self.returns.unit == "training seed"
            else f"{self.units} episodes, of these policies only"
        )

    @property
    def caution(self) -> str | None:
        """A warning about a verdict that rests on samples without spread, and how to check it; None for any other."""
        equal, unit = self.verdict.without_spread, self.returns.unit
        if not equal:
            return None
        share = f"{100 * share_that_may_differ(self.units):.2g} %"
        each = equal[0] if len(equal) == 1 else f"each of {listed(equal)}"
        if unit == "episode":
            check = f"play more, with --episodes {max(ENOUGH, 10 * self.units)} and another folder"
        else:
            check = f"train more seeds of each pool, or play one seed of each, such as RUN/seed_0, with --episodes {ENOUGH}"
        return (
            f"This rests on samples without spread: {each} has the same value in all {self.units} {unit}s. "
            f"The intervals have no width, but up to {share} of further {unit}s may differ (95 % upper bound). To check it, {check}."
        )


def returns_of(parts: Sequence[Part], slots: int, replicates: int) -> Returns:
    """Returns the mean returns of both kinds of agents in the line-ups k = 0 .. N."""
    by_member = np.stack([part.returns for part in parts]).reshape(
        slots + 1, replicates, -1, slots
    )  # [K, R, E, N]

    def mean(own: np.ndarray) -> np.ndarray:
        return own.mean(axis=-1) if own.shape[-1] else np.full(own.shape[:-1], np.nan)

    cooperators = np.stack([mean(by_member[k, ..., :k]) for k in range(slots + 1)])
    defectors = np.stack([mean(by_member[k, ..., k:]) for k in range(slots + 1)])
    return Returns(cooperators, defectors, by_member.mean(axis=-1))


def report_of(found: Diagram) -> dict[str, Any]:
    """Returns the results as JSON values."""
    verdict = found.verdict
    return {
        "format": FORMAT,
        "cooperators": found.experiment.pools[0].name,
        "defectors": found.experiment.pools[1].name,
        **found.experiment.describe(),
        "unit": found.returns.unit,
        "units": found.units,
        "returns": {
            "axes": ["k", "replicate", "episode"],
            "cooperators": found.returns.cooperators,
            "defectors": found.returns.defectors,
            "everybody": found.returns.everybody,
        },
        "confidence": CONFIDENCE,
        "C": _columns(found.cooperating),
        "D": _columns(found.defecting),
        "everybody": _columns(found.everybody),
        "D-C": _columns(tuple(figure for figure, _ in found.preferences))
        | {"preferred": [sign for _, sign in found.preferences]},
        "joint_confidence": JOINT_CONFIDENCE,
        "contrasts": {
            contrast: {"what": IN_WORDS[contrast], **asdict(figure)}
            for contrast, figure in found.contrasts.items()
        },
        "verdict": {**asdict(verdict), "shape": verdict.shape, "caution": found.caution},
    }


def _columns(figures: tuple[Estimate, ...]) -> dict[str, list[float]]:
    return {key: [getattr(figure, key) for figure in figures] for key in ("mean", "low", "high")}
