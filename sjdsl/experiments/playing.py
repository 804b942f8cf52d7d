"""Plays the line-ups of an experiment one by one."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from sjdsl.experiments.lineups import Lineup, as_given, key_words, orders_of, play_key
from sjdsl.experiments.players import Pool, find_pool, pair_pools, player_of, replicates_of
from sjdsl.experiments.refusals import ExperimentError
from sjdsl.experiments.stacks import make_player_of_lineups
from sjdsl.runtime.policy import Policy
from sjdsl.trainers.environment import Environment
from sjdsl.trainers.policies.evaluation import Evaluation
from sjdsl.trainers.runs.run_folder import describe_game, versions

Tell = Callable[[str], None]


@dataclass(frozen=True)
class Experiment:
    """Line-ups of pools, to be played by R replicates for E episodes each."""

    env: Environment
    pools: tuple[Pool, ...]
    lineups: tuple[Lineup, ...]  # indices of pools
    episodes: int
    seed: int
    permuted: bool  # whether each episode draws which member has which slot

    @property
    def title(self) -> str:
        """The title of the game, or its name if it has none."""
        return getattr(self.env, "title", "") or self.env.name

    @property
    def replicates(self) -> int:
        """R."""
        return replicates_of(self.pools)

    @property
    def notes(self) -> list[str]:
        """Warnings about the policies."""
        return list(dict.fromkeys(note for pool in self.pools for note in pool.notes))

    def describe(self) -> dict[str, Any]:
        """Returns everything that the results depend on, as JSON values."""
        return {
            "game": describe_game(self.env),
            "versions": versions(),
            "policies": [pool.describe() for pool in self.pools],
            "episodes": self.episodes,
            "seed": self.seed,
            "keys": [
                key_words(play_key(self.seed, replicate)) for replicate in range(self.replicates)
            ],
            "permuted": self.permuted,
            "notes": self.notes,
        }


@dataclass(frozen=True)
class Part:
    """E episodes of a line-up, played by one replicate."""

    lineup: Lineup
    replicate: int
    played: Evaluation
    order: np.ndarray  # [E, N] int32: entry j is the slot of member j

    @property
    def returns(self) -> np.ndarray:
        """`[E, N]` float64: the return of each member of the line-up, in the line-up's order."""
        return self.by_member(self.played.returns).astype(np.float64)

    def by_member(self, of_slots: np.ndarray) -> np.ndarray:
        """Returns values `[E, N]` by slot as values by member."""
        return np.take_along_axis(of_slots, self.order, axis=1)


def find_pools(policies: Sequence[str | Path | Policy], env: Environment) -> tuple[Pool, ...]:
    """Returns the pool of each policy, paired seed by seed; a policy that is named twice gets the same pool.

    Raises:
      ExperimentError, PolicyError: as `find_pool` and `pair_pools`.
    """
    found: list[tuple[Any, Pool]] = []
    for policy in policies:
        same = next(
            (
                pool
                for other, pool in found
                if policy is other or (isinstance(policy, str) and policy == other)
            ),
            None,
        )
        found.append((policy, same or find_pool(policy, env)))
    pools = tuple(dict.fromkeys(pool for _, pool in found))
    paired = dict(zip(pools, pair_pools(pools), strict=True))
    return tuple(paired[pool] for _, pool in found)


def play_experiment(experiment: Experiment, tell: Tell) -> list[Part]:
    """Returns each line-up as every replicate played it, line-up by line-up.

    Args:
      tell: called with a line before each line-up that is played.
    Raises:
      ExperimentError: a return is not finite.
    """
    env, slots = experiment.env, experiment.env.num_agents
    replicates = range(experiment.replicates)
    orders = [
        orders_of(experiment.seed, replicate, experiment.episodes, slots)
        if experiment.permuted
        else as_given(experiment.episodes, slots)
        for replicate in replicates
    ]

    def players(lineup: Lineup, replicate: int) -> tuple[Any, ...]:
        return tuple(player_of(experiment.pools[number], replicate) for number in lineup)

    everyone = [
        players(lineup, replicate) for lineup in experiment.lineups for replicate in replicates
    ]
    play = make_player_of_lineups(env, everyone, experiment.episodes)
    parts = []
    for number, lineup in enumerate(experiment.lineups, start=1):
        for replicate in replicates:
            which = f", seed {replicate + 1} of {len(replicates)}" if len(replicates) > 1 else ""
            tell(
                f"playing {experiment.episodes} episodes of line-up {number} of {len(experiment.lineups)}{which}"
            )
            played = play(
                play_key(experiment.seed, replicate), players(lineup, replicate), orders[replicate]
            )
            wrong = np.argwhere(~np.isfinite(played.returns))
            if len(wrong):
                episode, agent = wrong[0]
                raise ExperimentError(
                    f"the return of agent {agent} in episode {episode} of line-up {number}{which} is not finite, so there is no mean"
                )
            parts.append(Part(lineup, replicate, played, orders[replicate]))
    return parts


def check_episodes(episodes: int) -> None:
    """Raises ExperimentError unless there is an episode to play."""
    if episodes < 1:
        raise ExperimentError(f"at least one episode must be played, not {episodes}")
