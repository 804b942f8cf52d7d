"""The contrasts of a Schelling diagram, and whether they make a dilemma: pure statistics of
returns.

With N agents, C(l) is the mean return of a cooperator when l of the other N - 1 agents cooperate,
D(l) that of a defector. Source of the contrasts: Hughes et al. 2018, after Schelling 1973; the end
points stand for "sufficiently small" and "sufficiently large".
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from sjdsl.trainers.policies.estimates import Estimate, estimate

CONTRASTS = ("A", "B", "fear", "greed")
IN_WORDS = {
    "A": "C(N-1) - D(0): all cooperating against all defecting",
    "B": "C(N-1) - C(0): cooperating together against cooperating alone",
    "fear": "D(0) - C(0): defecting against cooperating where the others defect",
    "greed": "D(N-1) - C(N-1): defecting against cooperating where the others cooperate",
}
CONFIDENCE = 0.95
# Of each contrast, so that all four hold at 95 % together (Bonferroni).
JOINT_CONFIDENCE = 1 - (1 - CONFIDENCE) / len(CONTRASTS)


@dataclass(frozen=True)
class Returns:
    """Mean returns in K = N + 1 line-ups, R replicates and E episodes.

    The returns of all cooperators of an episode are averaged, and so are those of all defectors.
    """

    cooperators: np.ndarray  # [K, R, E] float64 by the number k of cooperators; NaN where k = 0
    defectors: np.ndarray  # [K, R, E] float64; NaN where k = N
    everybody: np.ndarray  # [K, R, E] float64, over all agents

    @property
    def cooperating(self) -> np.ndarray:
        """C(l), `[N, R, E]`: of cooperators in the line-up with l others, k = l + 1."""
        return self.cooperators[1:]

    @property
    def defecting(self) -> np.ndarray:
        """D(l), `[N, R, E]`: of defectors in the line-up with l others, k = l."""
        return self.defectors[:-1]

    @property
    def unit(self) -> str:
        """The sampling unit: the training seed if there are at least two, else the episode."""
        return "training seed" if self.cooperators.shape[1] > 1 else "episode"


def samples_of(returns: Returns, values: np.ndarray) -> np.ndarray:
    """Returns the samples `[..., units]` of values `[..., R, E]`.

    They are the means of the replicates, or the episodes of a single replicate. Episodes of one
    replicate share its policies, so they say nothing about other training seeds.
    """
    if returns.unit == "episode":
        return values[..., 0, :]
    means = [_mean(values[..., replicate, :]) for replicate in range(values.shape[-2])]
    return np.stack(means, -1)


def _mean(values: np.ndarray) -> np.ndarray:
    """Returns the mean over the last axis; if all values are equal, exactly that value."""
    are_equal = (values == values[..., :1]).all(axis=-1)
    return np.where(are_equal, values[..., 0], values.mean(axis=-1))


def contrast_samples(returns: Returns) -> dict[str, np.ndarray]:
    """Returns the samples `[units]` of each contrast.

    They are differences within an episode, averaged over the replicate.
    """
    cooperating = returns.cooperating
    defecting = returns.defecting
    differences = {
        "A": cooperating[-1] - defecting[0],
        "B": cooperating[-1] - cooperating[0],
        "fear": defecting[0] - cooperating[0],
        "greed": defecting[-1] - cooperating[-1],
    }
    return {name: samples_of(returns, values) for name, values in differences.items()}


def estimate_contrasts(samples: Mapping[str, np.ndarray]) -> dict[str, Estimate]:
    """Returns each contrast with its 98.75 % interval: all four hold at 95 % together."""
    return {name: estimate(values, JOINT_CONFIDENCE) for name, values in samples.items()}


def estimate_lines(returns: Returns, lines: np.ndarray) -> tuple[Estimate, ...]:
    """Returns the mean of each line-up of `[L, R, E]` values, with its own 95 % interval."""
    return tuple(estimate(values, CONFIDENCE) for values in samples_of(returns, lines))


def preferences(returns: Returns) -> tuple[tuple[Estimate, str], ...]:
    """Returns D(l) - C(l) for each l with its own 95 % interval, and what an agent prefers."""
    differences = estimate_lines(returns, returns.defecting - returns.cooperating)
    return tuple((difference, _preferred(difference)) for difference in differences)


def _preferred(difference: Estimate) -> str:
    """Returns `defect`, `cooperate`, `equal` or `undecided`."""
    if difference.low > 0:
        return "defect"
    if difference.high < 0:
        return "cooperate"
    return "equal" if difference.low == difference.high == 0 else "undecided"
