"""Plays the line-ups of an experiment one by one."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from sjdsl.experiments.folder import record_experiment
from sjdsl.experiments.lineups import (
    Lineup,
    fixed_orders,
    key_bits,
    orders_of,
    play_key,
    rotated_orders,
)
from sjdsl.experiments.players import (
    Player,
    Pool,
    find_pool,
    pair_pools,
    player_of,
    replicates_of,
)
from sjdsl.experiments.refusals import ExperimentError
from sjdsl.experiments.stacks import make_player_of_lineups
from sjdsl.experiments.tapes import save_tape
from sjdsl.models import Limits, Talks
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
    rotated: bool = False  # whether they move on by one slot with each episode

    @property
    def title(self) -> str:
        """The title of the game, or its name if it has none."""
        return getattr(self.env, "title", "") or self.env.name

    @property
    def replicates(self) -> int:
        """R."""
        return replicates_of(self.pools)

    @property
    def hosts(self) -> list[Pool]:
        """The pools that are asked in words."""
        return [pool for pool in self.pools if pool.players[0].host is not None]

    @property
    def notes(self) -> list[str]:
        """Warnings about the policies."""
        return list(dict.fromkeys(note for pool in self.pools for note in pool.notes))

    def describe(self) -> dict[str, Any]:
        """Returns everything that the results depend on, as JSON values."""
        keys = [play_key(self.seed, replicate) for replicate in range(self.replicates)]
        return {
            "game": describe_game(self.env),
            "versions": versions(),
            "policies": [pool.describe() for pool in self.pools],
            "episodes": self.episodes,
            "seed": self.seed,
            "keys": [key_bits(key) for key in keys],
            "permuted": self.permuted,
            "notes": self.notes,
            **({"rotated": True} if self.rotated else {}),
        }

    def orders(self, replicate: int) -> np.ndarray:
        """Returns the slot `[E, N]` int32 of each member of a line-up, in each episode."""
        if self.permuted:
            return orders_of(self.seed, replicate, self.episodes, self.env.num_agents)
        if self.rotated:
            return rotated_orders(self.episodes, self.env.num_agents)
        return fixed_orders(self.episodes, self.env.num_agents)

    def players(self, lineup: Lineup, replicate: int) -> tuple[Player, ...]:
        """Returns the players of a line-up, member by member."""
        return tuple(player_of(self.pools[index], replicate) for index in lineup)


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
    """Returns the pool of each policy, paired seed by seed; a policy that is named twice gets the
    same pool.

    Raises:
      ExperimentError, PolicyError: as `find_pool` and `pair_pools`.
    """
    by_policy: dict[Any, Pool] = {}
    pools = []  # the pool of each policy
    for policy in policies:
        key = policy if isinstance(policy, str) else id(policy)
        if key not in by_policy:
            by_policy[key] = find_pool(policy, env)
        pools.append(by_policy[key])
    distinct = tuple(by_policy.values())
    paired = dict(zip(distinct, pair_pools(distinct), strict=True))
    return tuple(paired[pool] for pool in pools)


def play_experiment(experiment: Experiment, tell: Tell, talks: Talks | None = None) -> list[Part]:
    """Returns each line-up as every replicate played it, line-up by line-up.

    Args:
      tell: called with a line before each line-up that is played.
      talks: asks those who are asked in words; None: they are asked, and nothing is recorded.
    Raises:
      ExperimentError: a return is not finite.
      ModelError: a model can't be asked, or a limit is reached.
    """
    episodes = experiment.episodes
    replicates = range(experiment.replicates)
    orders = [experiment.orders(replicate) for replicate in replicates]
    lineups = [
        experiment.players(lineup, replicate)
        for lineup in experiment.lineups
        for replicate in replicates
    ]
    play = make_player_of_lineups(experiment.env, lineups, episodes)
    talks = talks or Talks()
    parts = []
    for number, lineup in enumerate(experiment.lineups, start=1):
        for replicate in replicates:
            seed = f", seed {replicate + 1} of {len(replicates)}" if len(replicates) > 1 else ""
            tell(
                f"playing {episodes} episodes of line-up {number} of "
                f"{len(experiment.lineups)}{seed}"
            )
            key = play_key(experiment.seed, replicate)
            players = experiment.players(lineup, replicate)
            part = part_name(lineup, replicate)
            ask = talks.part(part)
            played, tape = play(key, players, orders[replicate], ask, talks.limits.parallel)
            for episode, agent in np.argwhere(~np.isfinite(played.returns)):
                raise ExperimentError(
                    f"the return of agent {agent} in episode {episode} of line-up {number}{seed} "
                    "is not finite, so there is no mean"
                )
            parts.append(Part(lineup, replicate, played, orders[replicate]))
            if tape is not None and talks.folder is not None:
                names = [
                    [players[member].name for member in np.argsort(order)]
                    for order in orders[replicate]
                ]
                save_tape(tape, experiment.env, experiment.seed, played, names, talks.folder / part)
    return parts


def part_name(lineup: Lineup, replicate: int) -> str:
    """Returns the name of a part's folder of calls."""
    return f"lineup_{'-'.join(map(str, lineup))}_seed_{replicate}"


def open_talks(
    experiment: Experiment,
    folder: Path | None,
    description: Mapping[str, Any],
    limits: Limits | None,
    tell: Tell,
) -> Talks:
    """Returns what asks the models of an experiment, to be used in a `with` block.

    The description of the experiment is in its folder before they are asked.
    """
    if folder is None or not experiment.hosts:
        return Talks(None, limits, tell)
    record_experiment(folder, description)
    return Talks(folder, limits, tell)


def check_episodes(episodes: int) -> None:
    """Raises ExperimentError unless there is an episode to play."""
    if episodes < 1:
        raise ExperimentError(f"at least one episode must be played, not {episodes}")
