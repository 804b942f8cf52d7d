"""Results of cross-play: returns by mixture and policy, as a matrix, as a table and as JSON
values.
"""

import csv
import io
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal, cast

import numpy as np

from sjdsl.experiments.lineups import Lineup, visiting
from sjdsl.experiments.players import Player, player_of
from sjdsl.experiments.playing import Experiment, Part, part_name
from sjdsl.experiments.usage import by_wording, describe_usage
from sjdsl.models.account import Account, Usage, name_of
from sjdsl.models.roles import wordings
from sjdsl.short_paths import short_names
from sjdsl.trainers.policies.estimates import Estimate, estimate

FORMAT = 1  # of crossplay.json
# Sampling units of intervals.
SEED = "training seed"
EPISODE = "episode"
Mix = Literal["all", "pairs"]
ASKED = ("calls", "invalid", "input", "cached", "output", "dollars")  # columns, of `Usage`


@dataclass(frozen=True)
class CrossPlay:
    """The episodes played, and the returns of each policy in each mixture."""

    experiment: Experiment
    parts: tuple[Part, ...]
    mix: Mix | None  # None: one fixed line-up
    account: Account | None = None  # of models

    @property
    def usage(self) -> dict[str, Usage]:
        """What models were asked, by their names."""
        return {} if self.account is None else self.account.by_policy()

    @property
    def wordings(self) -> dict[str, tuple[Estimate, ...]]:
        """What models earned, by the wordings of their roles."""
        return by_wording(self.experiment, self.parts)

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
        """The sampling unit of intervals: training seeds if there are at least two, else episodes
        of these policies."""
        return SEED if self.experiment.replicates > 1 else EPISODE

    def unit_of(self, lineup: Lineup) -> str:
        """Returns the sampling unit of one mixture: episodes if none of its policies was
        trained.
        """
        is_trained = any(self.experiment.pools[index].is_trained for index in lineup)
        return self.unit if is_trained else EPISODE

    def mixture(self, lineup: Lineup, names: Sequence[str] = ()) -> str:
        """Returns a mixture in words, `1 x runs/a, 2 x random`, or a fixed line-up slot by slot.

        `names` are other names of the policies.
        """
        names = names or self.names
        if self.mix is None:
            return ", ".join(names[index] for index in lineup)
        counts = sorted(Counter(lineup).items())
        return ", ".join(f"{count} x {names[index]}" for index, count in counts)

    def estimates(self, lineup: Lineup) -> dict[int, Estimate]:
        """Returns the mean return of an agent of each policy in a mixture, by the policy's index,
        with its 95 % interval."""
        parts = [part for part in self.parts if part.lineup == lineup]
        estimates = {}
        for index in sorted(set(lineup)):
            members = [member for member, policy in enumerate(lineup) if policy == index]
            returns = np.stack([part.returns[:, members].mean(axis=1) for part in parts])  # [R, E]
            is_over_seeds = self.unit_of(lineup) == SEED
            estimates[index] = estimate(returns.mean(axis=1) if is_over_seeds else returns.ravel())
        return estimates

    def matrix(self) -> np.ndarray:
        """Returns `[P, P]` float64: the mean return of an agent of the row's policy if all others
        have the column's."""
        slots = self.experiment.env.num_agents
        estimates = {lineup: self.estimates(lineup) for lineup in self.experiment.lineups}
        policies = len(self.names)
        matrix = np.empty((policies, policies))
        for one, many in np.ndindex(matrix.shape):
            matrix[one, many] = estimates[visiting(one, many, slots)][one].mean
        return matrix


def report_of(results: CrossPlay) -> dict[str, Any]:
    """Returns the results as JSON values."""
    experiment = results.experiment
    mixtures = []
    for lineup in experiment.lineups:
        estimates = results.estimates(lineup)
        mixtures.append(
            {
                "mixture": results.mixture(lineup),
                "slots": [results.names[index] for index in lineup],
                "policies": {
                    results.names[index]: asdict(figure) for index, figure in estimates.items()
                },
                "unit": results.unit_of(lineup),
                "episodes": experiment.episodes * experiment.replicates,
            }
        )
    return {
        "format": FORMAT,
        **experiment.describe(),
        "mix": results.mix,
        **describe_usage(results.usage, results.wordings),
        "unit": results.unit,
        "mixtures": mixtures,
    }


def table_of(results: CrossPlay) -> str:
    """Returns a table with a row for each episode and slot, as CSV.

    Events of an agent are in columns `event_NAME`, those of an episode in `episode_event_NAME`.
    If models play, each row ends with what its slot was asked, its server's name of the model, and
    the wording of its role, from 0.
    """
    text = io.StringIO()
    events = results.parts[0].played.events
    titles = [
        f"event_{name}" if counts.ndim == 2 else f"episode_event_{name}"
        for name, counts in events.items()
    ]
    if results.usage:
        titles += [*ASKED, "server_model", "wording"]
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(
        ["mixture", "replicate", "episode", "slot", "policy", "seed", "return", *titles]
    )
    for part in results.parts:
        writer.writerows(_table_rows(results, part))
    return text.getvalue()


def _table_rows(results: CrossPlay, part: Part) -> Iterator[list[Any]]:
    """Yields a row for each episode and slot of a part."""
    mixture = results.mixture(part.lineup)
    players = [player_of(results.experiment.pools[index], part.replicate) for index in part.lineup]
    for episode, order in enumerate(part.order):
        for slot, member in enumerate(np.argsort(order)):
            player = players[member]
            row = [
                mixture,
                part.replicate,
                episode,
                slot,
                player.name,
                "" if player.seed is None else player.seed,
                part.played.returns[episode, slot].item(),
            ]
            for counts in part.played.events.values():
                is_per_agent = counts.ndim == 2
                row.append((counts[episode, slot] if is_per_agent else counts[episode]).item())
            if results.usage:
                row += _asked(results, part, player, episode, slot)
            yield row


def _asked(results: CrossPlay, part: Part, player: Player, episode: int, slot: int) -> list[Any]:
    """Returns what a slot was asked, in columns; empty ones if it wasn't."""
    policy = player.host
    account = results.account
    if policy is None or account is None:
        return [""] * (len(ASKED) + 2)
    seat = (part_name(part.lineup, part.replicate), episode, slot)
    used = asdict(account.by_seat[seat])
    number = len(wordings(policy.role, cast(Any, results.experiment.env).game))
    model = account.server_names.get(name_of(policy), "")
    return [*(used[name] for name in ASKED), model, episode % number]
