"""A Schelling diagram of N agents: both lines, the contrasts, the verdict, and all of it as JSON
values.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
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
from sjdsl.experiments.usage import describe_usage, too_many_invalid
from sjdsl.experiments.verdict import Verdict, judge, listed, share_that_may_differ
from sjdsl.models.account import Usage
from sjdsl.trainers.policies.estimates import Estimate, stack_estimates

FORMAT = 1  # of schelling.json
ENOUGH = 300  # equal samples after which at most 1 % of further ones may differ


@dataclass(frozen=True)
class Diagram:
    """A Schelling diagram of N agents.

    C(l) is the mean return of a cooperator when l of the other agents cooperate, D(l) that of a
    defector.
    """

    experiment: Experiment
    returns: Returns
    usage: Mapping[str, Usage] = field(default_factory=dict)  # of models, by their names
    wordings: Mapping[str, tuple[Estimate, ...]] = field(default_factory=dict)  # of their roles

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
        """D(l) - C(l) for each l, and the agent's preference: `defect`, `cooperate`, `equal` or
        `undecided`."""
        return preferences(self.returns)

    @property
    def contrasts(self) -> dict[str, Estimate]:
        """A, B, fear and greed, whose intervals hold at 95 % together."""
        return estimate_contrasts(contrast_samples(self.returns))

    @property
    def verdict(self) -> Verdict:
        """Whether it is a dilemma; undecided if too many replies of a model couldn't be used."""
        verdict = judge(contrast_samples(self.returns))
        reason = too_many_invalid(self.usage)
        if not reason:
            return verdict
        return replace(verdict, outcome="undecided", reason=reason, wanted=None, without_spread=())

    @property
    def units(self) -> int:
        """The number of samples of each interval."""
        is_episode = self.returns.unit == "episode"
        return self.experiment.episodes if is_episode else self.experiment.replicates

    @property
    def population(self) -> str:
        """The samples of the intervals, in words."""
        if self.returns.unit == "episode":
            return f"{self.units} episodes, of these policies only"
        return f"{self.units} training seeds"

    @property
    def caution(self) -> str | None:
        """A warning about a verdict that rests on samples without spread, and how to check it; None
        for any other verdict."""
        equal = self.verdict.without_spread
        if not equal:
            return None
        unit = self.returns.unit
        share = f"{100 * share_that_may_differ(self.units):.2g} %"
        contrasts = equal[0] if len(equal) == 1 else f"each of {listed(equal)}"
        if unit == "episode":
            episodes = max(ENOUGH, 10 * self.units)
            check = f"play more, with --episodes {episodes} and another folder"
        else:
            check = (
                "train more seeds of each pool, or play one seed of each, such as RUN/seed_0, "
                f"with --episodes {ENOUGH}"
            )
        return (
            f"This rests on samples without spread: {contrasts} has the same value in all "
            f"{self.units} {unit}s. The intervals have no width, but up to {share} of further "
            f"{unit}s may differ (95 % upper bound). To check it, {check}."
        )


def returns_of(parts: Sequence[Part], slots: int, replicates: int) -> Returns:
    """Returns the mean returns of both kinds of agents in the line-ups k = 0 .. N.

    Args:
      parts: for each k in turn, each replicate; the first k members cooperate.
      slots: N.
    """
    stacked = np.stack([part.returns for part in parts])
    by_member = stacked.reshape(slots + 1, replicates, -1, slots)  # [K, R, E, N]
    cooperators = np.full(by_member.shape[:-1], np.nan)
    defectors = np.full(by_member.shape[:-1], np.nan)
    for k in range(1, slots + 1):
        cooperators[k] = by_member[k, ..., :k].mean(axis=-1)
    for k in range(slots):
        defectors[k] = by_member[k, ..., k:].mean(axis=-1)
    return Returns(cooperators, defectors, by_member.mean(axis=-1))


def report_of(diagram: Diagram) -> dict[str, Any]:
    """Returns the results as JSON values."""
    verdict = diagram.verdict
    differences = tuple(difference for difference, _ in diagram.preferences)
    preferred = [preference for _, preference in diagram.preferences]
    return {
        "format": FORMAT,
        "cooperators": diagram.experiment.pools[0].name,
        "defectors": diagram.experiment.pools[1].name,
        **diagram.experiment.describe(),
        **describe_usage(diagram.usage, diagram.wordings),
        "unit": diagram.returns.unit,
        "units": diagram.units,
        "returns": {
            "axes": ["k", "replicate", "episode"],
            "cooperators": diagram.returns.cooperators,
            "defectors": diagram.returns.defectors,
            "everybody": diagram.returns.everybody,
        },
        "confidence": CONFIDENCE,
        "C": _columns(diagram.cooperating),
        "D": _columns(diagram.defecting),
        "everybody": _columns(diagram.everybody),
        "D-C": {**_columns(differences), "preferred": preferred},
        "joint_confidence": JOINT_CONFIDENCE,
        "contrasts": {
            contrast: {"what": IN_WORDS[contrast], **asdict(figure)}
            for contrast, figure in diagram.contrasts.items()
        },
        "verdict": {**asdict(verdict), "shape": verdict.shape, "caution": diagram.caution},
    }


def _columns(figures: tuple[Estimate, ...]) -> dict[str, list[float]]:
    mean, low, high = stack_estimates(figures)
    return {"mean": mean.tolist(), "low": low.tolist(), "high": high.tolist()}
