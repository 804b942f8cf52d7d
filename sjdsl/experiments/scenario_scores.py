"""Returns of the focal agents in the scenarios of a game, and their score between random and the
best scripted policy."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from sjdsl.compiler import ir
from sjdsl.experiments.lineups import Lineup
from sjdsl.experiments.playing import Experiment, Part
from sjdsl.experiments.usage import by_wording, describe_usage
from sjdsl.models.account import Usage
from sjdsl.trainers.policies.estimates import Estimate, estimate

FORMAT = 1  # of scenarios.json
RANDOM = "random"


@dataclass(frozen=True)
class ScenarioScore:
    """The per-capita returns in one scenario, of R replicates with E episodes each."""

    scenario: ir.Scenario
    # [R, E] float64: the mean return of a focal agent.
    focal_returns: np.ndarray
    # [R, E] float64: that of the other agents; None if there are none.
    background_returns: np.ndarray | None
    # [R, E] float64: that of focal agents who play `random`, a policy of the file, or `stay`.
    baselines: Mapping[str, np.ndarray]
    # Of `focal`, over the episodes with each wording of the focal policy's role, if it plays one.
    by_wording: tuple[Estimate, ...] = ()

    @property
    def focal(self) -> Estimate:
        """The focal per-capita return, over training seeds if there are at least two, else over
        episodes."""
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
        """The scripted policy with the highest focal per-capita return; on a tie, the first in the
        file."""
        scripted = [name for name in self.baselines if name != RANDOM]
        return max(scripted, key=lambda name: self.baseline(name).mean)

    @property
    def score(self) -> float | None:
        """`(focal - random) / (best - random)`; None if `best` is not above `random`."""
        random = self.baseline(RANDOM).mean
        best = self.baseline(self.best).mean
        if best <= random:
            return None
        return (self.focal.mean - random) / (best - random)

    @property
    def caution(self) -> str:
        """A warning that the score is undefined, or that its denominator may be 0; empty
        otherwise.
        """
        random = self.baseline(RANDOM).mean
        best = self.baseline(self.best).mean
        if best <= random:
            return (
                f"the score is undefined: the best scripted focal policy, {self.best}, earns "
                f"{best:.4g}, no more than random with {random:.4g}"
            )
        margin = estimate((self.baselines[self.best] - self.baselines[RANDOM]).ravel())
        if margin.low > 0:
            return ""
        interval = "of unknown width"
        if np.isfinite(margin.low):
            interval = f"[{margin.low:.4g}, {margin.high:.4g}]"
        return (
            f"the score is uncertain: {self.best} minus random is {margin.mean:.4g}, with the "
            f"interval {interval}; play more episodes"
        )

    @property
    def number_focal(self) -> int:
        """The number of focal agents."""
        return sum(slots.number for slots in self.scenario.slots if not slots.policy)


@dataclass(frozen=True)
class ScenarioScores:
    """The scores of the scenarios that were played, by name; iterating gives the names, as for a
    dict."""

    experiment: Experiment
    scenarios: Mapping[str, ScenarioScore]
    usage: Mapping[str, Usage] = field(default_factory=dict)  # of models, by their names

    @property
    def policy(self) -> str:
        """The name of the focal policy."""
        return self.experiment.pools[0].name

    @property
    def unit(self) -> str:
        """The sampling unit of the intervals of focal and background returns."""
        return "training seed" if self.experiment.replicates > 1 else "episode"

    @property
    def units(self) -> int:
        """The number of samples of these intervals."""
        replicates = self.experiment.replicates
        return replicates if replicates > 1 else self.experiment.episodes

    @property
    def population(self) -> str:
        """The samples of these intervals, in words."""
        if self.experiment.replicates > 1:
            return f"{self.units} training seeds"
        return f"{self.units} episodes, of this policy only"

    def __getitem__(self, name: str) -> ScenarioScore:
        """Returns a scenario by name."""
        return self.scenarios[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.scenarios)


def _over_units(returns: np.ndarray) -> Estimate:
    """Returns the mean of `[R, E]` returns with its interval over replicates if there are at least
    two, else over episodes."""
    return estimate(returns.mean(axis=1) if len(returns) > 1 else returns[0])


def line_up(scenario: ir.Scenario, focal: int, scripted: Mapping[str, int]) -> Lineup:
    """Returns the pools that play a scenario, slot by slot, with pool `focal` in the focal slots.

    `scripted` has the pools of the scripted policies by name.
    """
    lineup: Lineup = ()
    for slots in scenario.slots:
        pool = scripted[slots.policy] if slots.policy else focal
        lineup += (pool,) * slots.number
    return lineup


def score_of(
    scenario: ir.Scenario,
    experiment: Experiment,
    scripted: Mapping[str, int],
    parts: Sequence[Part],
) -> ScenarioScore:
    """Returns the scores of a scenario with pool 0 and each scripted pool as focal agents."""
    numbers = [slots.number for slots in scenario.slots]
    is_focal = np.repeat([not slots.policy for slots in scenario.slots], numbers)  # [N] bool

    def per_capita(pool: int, members: np.ndarray) -> np.ndarray:
        """Returns the mean return `[R, E]` of some members, bool `[N]`, with a pool as focal agents."""
        lineup = line_up(scenario, pool, scripted)
        returns = [part.returns for part in parts if part.lineup == lineup]
        return np.stack([values[:, members].mean(axis=1) for values in returns])

    focal_lineup = line_up(scenario, 0, scripted)
    focal_parts = [part for part in parts if part.lineup == focal_lineup]
    of_roles = by_wording(experiment, focal_parts)
    return ScenarioScore(
        scenario,
        focal_returns=per_capita(0, is_focal),
        background_returns=None if is_focal.all() else per_capita(0, ~is_focal),
        baselines={name: per_capita(pool, is_focal) for name, pool in scripted.items()},
        by_wording=of_roles.get(experiment.pools[0].name, ()),
    )


def slots_of(scenario: ir.Scenario) -> list[list[Any]]:
    """Returns the slots of a scenario as JSON values: their number and policy, null for focal
    ones.
    """
    return [[slots.number, slots.policy or None] for slots in scenario.slots]


def report_of(scores: ScenarioScores) -> dict[str, Any]:
    """Returns the results as JSON values."""
    return {
        "format": FORMAT,
        **scores.experiment.describe(),
        "focal_policy": scores.policy,
        "training_seeds": list(scores.experiment.pools[0].seeds),
        **describe_usage(scores.usage),
        "unit": scores.unit,
        "units": scores.units,
        "scenarios": {name: _describe_score(score) for name, score in scores.scenarios.items()},
    }


def _describe_score(score: ScenarioScore) -> dict[str, Any]:
    """Returns the results of one scenario as JSON values."""
    background = score.background
    return {
        "title": score.scenario.title,
        "slots": slots_of(score.scenario),
        "focal": asdict(score.focal),
        **({"wordings": list(map(asdict, score.by_wording))} if score.by_wording else {}),
        "background": None if background is None else asdict(background),
        "baselines": {name: asdict(score.baseline(name)) for name in score.baselines},
        "best": score.best,
        "score": score.score,
        "caution": score.caution or None,
        "returns": {"focal": score.focal_returns, "background": score.background_returns},
    }
