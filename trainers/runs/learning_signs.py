"""Signs in the rows of a run's updates that it learns nothing, and which settings to look at."""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from ..settings.config import Config
from .metrics_files import Row
from .seeds_in_words import seeds_in_words, seeds_of_each

# columns that say how learning goes, in words
FIGURES = {"entropy": "entropy", "kl": "KL", "explained_variance": "explained variance"}
SHARE = 0.1  # of a run's updates, after which it should have learnt something


def said_once(by_seed: Mapping[int, Sequence[str]]) -> list[str]:
    """Returns the warnings of a run's seeds, each once, with the seeds that it is about.

    Args:
      by_seed: the warnings of all seeds, also of those that have none.
    """
    pairs = [(seed, warning) for seed, warnings in by_seed.items() for warning in warnings]
    seeds_of = seeds_of_each(pairs)
    if len(by_seed) == 1:
        return list(seeds_of)
    return [f"{seeds_in_words(seeds)}: {warning}" for warning, seeds in seeds_of.items()]


@dataclass
class Signs:
    """Totals over the rows of one seed, up to `SHARE` of its run."""

    # collective return of the first episodes that ended, played by the policy that the run began
    # with
    before_learning: float = math.nan
    latest: float = math.nan  # of the last that ended
    paid: bool = False  # whether any agent ever got a reward
    explained: float = 0.0  # variance of the returns that the critic explained, summed over updates
    # name -> how often it happened, by agents and words together
    events: dict[str, float] = field(default_factory=dict)
    updates: int = 0

    def count(self, row: Row) -> None:
        """Counts an update."""
        self.updates += 1
        self.paid |= row.get("rewarded_steps") != 0
        self.explained += row.get("explained_variance", math.nan)
        if not row["episodes"] > 0:
            return
        self.latest = row["collective_return"]
        if math.isnan(self.before_learning):
            self.before_learning = self.latest
        for name, number in row.items():
            if name.startswith("event_"):
                event = re.split(r"\[|_agent_", name.removeprefix("event_"))[0]
                self.events[event] = self.events.get(event, 0.0) + number

    def warnings(self, config: Config) -> Iterator[str]:
        """Yields a warning for each sign that nothing is learnt, with what to change."""
        if not self.paid:
            yield (
                "no agent has been rewarded yet, so there is nothing to learn from. Try more "
                "environments (num_envs), a larger entropy_coefficient, or a game in which the "
                "first reward is easier to get"
            )
            return
        if config.reward == "common" and self.latest <= self.before_learning:
            # Agents that each seek their own reward may well earn less together than at random:
            # that is the dilemma.
            yield (
                f"the collective return, {self.latest:.1f}, is not above what it was before "
                f"learning, {self.before_learning:.1f}. Try more gradient steps (num_minibatches), "
                "longer rollouts (num_steps) or another learning_rate"
            )
        if self.explained < 0:
            is_sum = config.reward == "common" and config.common_reward == "sum"
            mean = "common_reward=mean, " if is_sum else ""
            yield (
                "the critic predicts returns worse than their mean would (explained_variance is "
                f"{self.explained / self.updates:.2f} on average). Try {mean}a smaller gamma, or "
                "more gradient steps (num_minibatches)"
            )
        never = [name for name, number in self.events.items() if number == 0]
        if never:
            yield (
                f"these events have never happened: {', '.join(never)}. "
                "Agents cannot learn from them: try a larger entropy_coefficient"
            )


def is_due(update: int, config: Config) -> bool:
    """Whether to look for signs after an update: once in a run, unless it is too short."""
    return config.num_updates > 1 and update == max(1, round(SHARE * config.num_updates))
