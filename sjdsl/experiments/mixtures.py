"""Results of cross-play: returns by mixture and policy, as a matrix, as a table and as JSON values."""

import csv
import io
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from sjdsl.experiments.lineups import Lineup, visiting
from sjdsl.experiments.players import player_of
from sjdsl.experiments.playing import Experiment, Part
from sjdsl.short_paths import short_names
from sjdsl.trainers.policies.estimates import Estimate, estimate

FORMAT = 1  # of crossplay.json
SEED, EPISODE = "training seed", "episode"  # sampling units of intervals
Mix = Literal["all", "pairs"]


@dataclass(frozen=True)
class CrossPlay:
    """The episodes played, and the returns of each policy in each mixture."""

    experiment: Experiment
    parts: tuple[Part, ...]
    mix: Mix | None  # None: one given line-up

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the policies, by index."""
        return tuple(pool.name for pool in self.experiment.pools)

    @property
    def short_names(self) -> tuple[str, ...]:
        """Names that are short enough for tables and pictures, by index."""
        short = short_names(self.names)
        return tuple(short[name] for name in self.names)

    @property
    def unit(self) -> str:
        """The sampling unit of intervals: training seeds if there are at least two, else episodes of these policies."""
        return SEED if self.experiment.replicates > 1 else EPISODE

    def unit_of(self, lineup: Lineup) -> str:
        """Returns the sampling unit of one mixture: episodes if none of its policies was trained."""
        return (
            self.unit
            if any(self.experiment.pools[number].is_trained for number in lineup)
            else EPISODE
        )

    def mixture(self, lineup: Lineup, names: Sequence[str] = ()) -> str:
        """Returns a mixture in words, `1 x runs/a, 2 x random`; a given line-up slot by slot. names: other names of the policies."""
        names = names or self.names
        if self.mix is None:
            return ", ".join(names[number] for number in lineup)
        return ", ".join(
            f"{count} x {names[number]}" for number, count in sorted(Counter(lineup).items())
        )

    def estimates(self, lineup: Lineup) -> dict[int, Estimate]:
        """Returns the mean return of an agent of each policy in a mixture, by the policy's index, with its 95 % interval."""
        parts = [part for part in self.parts if part.lineup == lineup]
        found = {}
        for number in sorted(set(lineup)):
            members = [place for place, other in enumerate(lineup) if other == number]
            episodes = np.stack([part.returns[:, members].mean(axis=1) for part in parts])  # [R, E]
            found[number] = estimate(
                episodes.mean(axis=1) if self.unit_of(lineup) == SEED else episodes.ravel()
            )
        return found

    def matrix(self) -> np.ndarray:
        """Returns `[P, P]`: the mean return of an agent of the row's policy if all others have the column's."""
        policies = range(len(self.names))
        slots = self.experiment.env.num_agents
        found = {lineup: self.estimates(lineup) for lineup in self.experiment.lineups}
        return np.array(
            [[found[visiting(one, many, slots)][one].mean for many in policies] for one in policies]
        )


def report_of(found: CrossPlay) -> dict[str, Any]:
    """Returns the results as JSON values."""
    mixtures = [
        {
            "mixture": found.mixture(lineup),
            "slots": [found.names[number] for number in lineup],
            "policies": {
                found.names[number]: asdict(figure)
                for number, figure in found.estimates(lineup).items()
            },
            "unit": found.unit_of(lineup),
            "episodes": found.experiment.episodes * found.experiment.replicates,
        }
        for lineup in found.experiment.lineups
    ]
    return {
        "format": FORMAT,
        **found.experiment.describe(),
        "mix": found.mix,
        "unit": found.unit,
        "mixtures": mixtures,
    }


def table_of(found: CrossPlay) -> str:
    """Returns a row for each episode and slot, as CSV; counts per episode are named `episode_event_NAME`."""
    text = io.StringIO()
    events = found.parts[0].played.events
    titles = [
        f"{'event' if counts.ndim == 2 else 'episode_event'}_{name}"
        for name, counts in events.items()
    ]
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(
        ["mixture", "replicate", "episode", "slot", "policy", "seed", "return", *titles]
    )
    writer.writerows(row for part in found.parts for row in _rows(found, part))
    return text.getvalue()


def _rows(found: CrossPlay, part: Part) -> Iterator[list[Any]]:
    mixture = found.mixture(part.lineup)
    players = [player_of(found.experiment.pools[number], part.replicate) for number in part.lineup]
    for episode, order in enumerate(part.order.tolist()):
        for slot, member in sorted(zip(order, range(len(order)), strict=True)):
            player = players[member]
            counts = [
                counts[(episode, slot)[: counts.ndim]].item()
                for counts in part.played.events.values()
            ]
            seed = "" if player.seed is None else player.seed
            yield [
                mixture,
                part.replicate,
                episode,
                slot,
                player.name,
                seed,
                part.played.returns[episode, slot].item(),
                *counts,
            ]
