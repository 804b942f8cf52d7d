"""Cross-play: what policies earn in each other's company, line-up by line-up."""

import csv
import io
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from sjdsl.experiments.lineups import Lineup, all_mixtures, paired_mixtures, visiting
from sjdsl.experiments.playing import Experiment, Part, Tell, check_episodes, find_pools, play_experiment
from sjdsl.experiments.refusals import ExperimentError
from sjdsl.experiments.result_files import write_compact_json
from sjdsl.runtime.policy import Policy
from sjdsl.trainers.environment import Environment
from sjdsl.trainers.estimates import Estimate, estimate
from sjdsl.trainers.run_files import write_whole

FORMAT = 1  # of crossplay.json
Mix = Literal["all", "pairs"]


@dataclass(frozen=True)
class CrossPlay:
    """What was played, and what each policy earned in each mixture."""

    experiment: Experiment
    parts: tuple[Part, ...]
    mix: Mix | None  # None: one line-up that was given

    @property
    def names(self) -> tuple[str, ...]:
        """Of the policies, by their numbers."""
        return tuple(pool.name for pool in self.experiment.pools)

    @property
    def unit(self) -> str:
        """What the intervals are over: training seeds where there are two at least, else episodes, of these policies only."""
        return "training seed" if self.experiment.replicates > 1 else "episode"

    def mixture(self, lineup: Lineup) -> str:
        """Returns a line-up in words: `1 x runs/a, 2 x random`; one that was given slot by slot."""
        if self.mix is None:
            return ", ".join(self.names[number] for number in lineup)
        return ", ".join(f"{count} x {self.names[number]}" for number, count in sorted(Counter(lineup).items()))

    def estimates(self, lineup: Lineup) -> dict[int, Estimate]:
        """Returns the mean return of an agent of each policy in a mixture, by the policy's number, with its 95 % interval."""
        parts = [part for part in self.parts if part.lineup == lineup]
        found = {}
        for number in sorted(set(lineup)):
            members = [place for place, other in enumerate(lineup) if other == number]
            episodes = np.stack([part.returns[:, members].mean(axis=1) for part in parts])  # [R, E]
            found[number] = estimate(episodes.mean(axis=1) if len(parts) > 1 else episodes[0])
        return found

    def matrix(self) -> np.ndarray:
        """Returns `[P, P]`: the mean return of an agent of the row's policy where all others have the column's."""
        policies = range(len(self.names))
        slots = self.experiment.env.num_agents
        found = {lineup: self.estimates(lineup) for lineup in self.experiment.lineups}
        return np.array([[found[visiting(one, many, slots)][one].mean for many in policies] for one in policies])


def cross_play(
    env: Environment,
    *,
    slots: Sequence[str | Path | Policy] | None = None,
    policies: Sequence[str | Path | Policy] | None = None,
    mix: Mix = "all",
    episodes: int = 30,
    seed: int = 0,
    folder: Path | str | None = None,
    tell: Tell = lambda _: None,
) -> CrossPlay:
    """Plays policies with each other; a folder of several seeds is a pool, whose seed i plays with seed i of the others.

    Args:
      env: one environment of N agents.
      slots: N policies, one for each slot; the line-up is played as it is.
      policies: instead of `slots`: P policies whose mixtures are played; each episode draws who has which slot.
      mix: `all`: every mixture over N slots; `pairs`: one agent of a policy among N - 1 of another, and each with itself.
      episodes: E, of each mixture and replicate.
      seed: of the episodes. All mixtures begin alike; of one line-up they are those of `evaluate` with `evaluation_key(seed)`.
      folder: where the parts are kept as they are played, and looked for first; then the results. None: nothing is written.
      tell: called with a line before each line-up.
    Raises:
      ExperimentError, PolicyError: what does not fit. OSError: the disk is full; what was played stays.
    """
    experiment = plan_cross_play(env, slots, policies, mix, episodes, seed)
    asked = {"experiment": "crossplay", "mix": mix if slots is None else None, "lineups": experiment.lineups}
    parts = play_experiment(experiment, asked, None if folder is None else Path(folder), tell)
    found = CrossPlay(experiment, tuple(parts), mix if slots is None else None)
    if folder is not None:
        write_cross_play(found, Path(folder))
    return found


def plan_cross_play(
    env: Environment,
    slots: Sequence[str | Path | Policy] | None,
    policies: Sequence[str | Path | Policy] | None,
    mix: Mix,
    episodes: int,
    seed: int,
) -> Experiment:
    """Returns what would be played. Raises as `cross_play` does."""
    check_episodes(episodes)
    if (slots is None) == (policies is None):
        raise ExperimentError("give either slots, a policy for each agent, or policies, whose mixtures are played")
    number = env.num_agents
    if slots is not None:
        if len(slots) != number:
            raise ExperimentError(f"{env.name} has {number} slots, and {len(slots)} policies are given for them; name one for each slot")
        found = find_pools(slots, env)
        pools = tuple(dict.fromkeys(found))
        lineups: tuple[Lineup, ...] = (tuple(pools.index(pool) for pool in found),)
    else:
        assert policies is not None
        if not policies:
            raise ExperimentError("name one policy at least")
        lineups = all_mixtures(len(policies), number) if mix == "all" else paired_mixtures(len(policies), number)
        pools = find_pools(policies, env)
        if len(set(pools)) < len(pools):
            twice = next(pool.name for pool, count in Counter(pools).items() if count > 1)
            raise ExperimentError(f"`{twice}` is named twice; every mixture with itself is played anyway")
    experiment = Experiment(env, pools, lineups, episodes, seed, permuted=slots is None)
    _ = experiment.replicates  # unequal pools are refused here
    return experiment


def write_cross_play(found: CrossPlay, folder: Path) -> None:
    """Writes `crossplay.csv`, `crossplay.json` and, of pairs, `matrix.png`, each whole or not at all."""
    write_whole(folder / "crossplay.csv", _table(found).encode())
    write_compact_json(folder / "crossplay.json", report_of(found))
    if found.mix == "pairs":
        from sjdsl.experiments.pictures import draw_matrix, picture_bytes

        write_whole(folder / "matrix.png", picture_bytes(draw_matrix(found), "png"))


def report_of(found: CrossPlay) -> dict[str, Any]:
    """Returns the figures as JSON values."""
    mixtures = [
        {
            "mixture": found.mixture(lineup),
            "slots": [found.names[number] for number in lineup],
            "policies": {found.names[number]: asdict(figure) for number, figure in found.estimates(lineup).items()},
            "episodes": found.experiment.episodes * found.experiment.replicates,
        }
        for lineup in found.experiment.lineups
    ]
    return {"format": FORMAT, **found.experiment.describe(), "mix": found.mix, "unit": found.unit, "mixtures": mixtures}


def _table(found: CrossPlay) -> str:
    """Returns a row for each episode and slot, as CSV; counts of a whole episode are called `episode_event_NAME`."""
    text = io.StringIO()
    events = found.parts[0].played.events
    titles = [f"{'event' if counts.ndim == 2 else 'episode_event'}_{name}" for name, counts in events.items()]
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["mixture", "replicate", "episode", "slot", "policy", "seed", "return", *titles])
    writer.writerows(row for part in found.parts for row in _rows(found, part))
    return text.getvalue()


def _rows(found: CrossPlay, part: Part) -> Iterator[list[Any]]:
    mixture = found.mixture(part.lineup)
    pools = [found.experiment.pools[number] for number in part.lineup]
    players = [pool.players[part.replicate if len(pool.players) > 1 else 0] for pool in pools]
    for episode, order in enumerate(part.order.tolist()):
        for slot, member in sorted(zip(order, range(len(order)), strict=True)):
            player = players[member]
            counts = [counts[(episode, slot)[: counts.ndim]].item() for counts in part.played.events.values()]
            seed = "" if player.seed is None else player.seed
            yield [mixture, part.replicate, episode, slot, player.name, seed, part.played.returns[episode, slot].item(), *counts]
