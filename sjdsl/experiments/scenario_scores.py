"""Returns of the focal agents in the scenarios of a game, and their score between random and the best scripted policy."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from sjdsl.compiler import ir
from sjdsl.experiments.lineups import Lineup
from sjdsl.experiments.playing import Experiment, Part
from sjdsl.trainers.policies.estimates import Estimate, estimate

FORMAT = 1  # of scenarios.json
RANDOM = "random"


@dataclass(frozen=True)
class ScenarioScore:
    """The per-capita returns in one scenario, of R replicates with E episodes each."""

    scenario: ir.Scenario
    focal_returns: np.ndarray  # [R, E] float64: the mean return of a focal agent
    background_returns: (
        np.ndarray | None
    )  # [R, E]: that of the other agents; None if there are none
    baselines: Mapping[
        str, np.ndarray
    ]  # [R, E]: that of focal agents who play `random`, the file's policies or `stay`

    @property
    def focal(self) -> Estimate:
        """The focal per-capita return, over training seeds if there are at least two, else over episodes."""
        return _over_units(self.focal_returns)

    @property
    def background(self) -> Estimate | None:
        """The background's per-capita return, over the same samples."""
        return None if self.background_returns is None else _over_units(self.background_returns)

    def baseline(self, name: str) -> Estimate:
        """Returns the focal per-capita return of an untrained policy, over all episodes."""
        return estimate(self.baselines[name].ravel())

    @property
    def best(self) -> str:
        """The scripted policy with the highest focal per-capita return; on a tie, the first in the file."""
        return max(
            (name for name in self.baselines if name != RANDOM),
            key=lambda name: self.baseline(name).mean,
        )

    @property
    def score(self) -> float | None:
        """`(focal - random) / (best - random)`; None if `best` is not above `random`."""
        random, best = self.baseline(RANDOM).mean, self.baseline(self.best).mean
        return None if best <= random else (self.focal.mean - random) / (best - random)

    @property
    def caution(self) -> str:
        """A warning that the score is undefined, or that its denominator may be 0; empty otherwise."""
        random, best = self.baseline(RANDOM).mean, self.baseline(self.best).mean
        if best <= random:
            return f"the score is undefined: the best scripted focal policy, {self.best}, earns {best:.4g}, no more than random with {random:.4g}"
        apart = estimate((self.baselines[self.best] - self.baselines[RANDOM]).ravel())
        if apart.low > 0:
            return ""
        interval = (
            f"[{apart.low:.4g}, {apart.high:.4g}]" if np.isfinite(apart.low) else "of unknown width"
        )
        return f"the score is uncertain: {self.best} minus random is {apart.mean:.4g}, with the interval {interval}; play more episodes"

    @property
    def number_focal(self) -> int:
        """The number of focal agents."""
        return sum(part.number for part in self.scenario.slots if not part.policy)


@dataclass(frozen=True)
class ScenarioScores:
    """The scores of the scenarios that were played, by name; iterating gives the names, as of a dict."""

    experiment: Experiment
    scenarios: Mapping[str, ScenarioScore]

    @property
    def policy(self) -> str:
        """The name of the focal policy."""
        return self.experiment.pools[0].name

    @property
    def unit(self) -> str:
        """The sampling unit of the intervals of focal and background returns."""
        return "training seed" if self.experiment.replicates > 1 else "episode"

    @property
    def population(self) -> str:
        """The samples of these intervals, in words."""
        if self.experiment.replicates > 1:
            return f"{self.experiment.replicates} training seeds"
        return f"{self.experiment.episodes} episodes, of this policy only"

    def __getitem__(self, name: str) -> ScenarioScore:
        """Returns a scenario by name."""
        return self.scenarios[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.scenarios)


def _over_units(returns: np.ndarray) -> Estimate:
    """Returns the mean of `[R, E]` returns with its interval over replicates if there are at least two, else over episodes."""
    return estimate(returns.mean(axis=1) if len(returns) > 1 else returns[0])


def line_up(scenario: ir.Scenario, focal: int, scripted: Mapping[str, int]) -> Lineup:
    """Returns the pools that play a scenario, slot by slot, with pool `focal` in the focal slots. `scripted`: pools by name."""
    return tuple(
        scripted[part.policy] if part.policy else focal
        for part in scenario.slots
        for _ in range(part.number)
    )


def score_of(
    scenario: ir.Scenario, scripted: Mapping[str, int], parts: Sequence[Part]
) -> ScenarioScore:
    """Returns the scores of a scenario with pool 0 and each scripted pool as focal agents."""
    is_focal = np.array([not part.policy for part in scenario.slots for _ in range(part.number)])

    def per_capita(pool: int, members: np.ndarray) -> np.ndarray:
        lineup = line_up(scenario, pool, scripted)
        return np.stack(
            [part.returns[:, members].mean(axis=1) for part in parts if part.lineup == lineup]
        )

    background = None if is_focal.all() else per_capita(0, ~is_focal)
    return ScenarioScore(
        scenario,
        per_capita(0, is_focal),
        background,
        {name: per_capita(pool, is_focal) for name, pool in scripted.items()},
    )


def slots_of(scenario: ir.Scenario) -> list[list[Any]]:
    """Returns the slots of a scenario as JSON values: their number and policy, null for focal ones."""
    return [[part.number, part.policy or None] for part in scenario.slots]


def report_of(found: ScenarioScores) -> dict[str, Any]:
    """Returns the results as JSON values."""
    return {
        "format": FORMAT,
        **found.experiment.describe(),
        "focal_policy": found.policy,
        "training_seeds": list(found.experiment.pools[0].seeds),
        "unit": found.unit,
        "units": found.experiment.replicates
        if found.experiment.replicates > 1
        else found.experiment.episodes,
        "scenarios": {name: _entry(score) for name, score in found.scenarios.items()},
    }


def _entry(score: ScenarioScore) -> dict[str, Any]:
    background = score.background
    return {
        "title": score.scenario.title,
        "slots": slots_of(score.scenario),
        "focal": asdict(score.focal),
        "background": None if background is None else asdict(background),
        "baselines": {name: asdict(score.baseline(name)) for name in score.baselines},
        "best": score.best,
        "score": score.score,
        "caution": score.caution or None,
        "returns": {"focal": score.focal_returns, "background": score.background_returns},
    }
