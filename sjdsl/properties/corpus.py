"""The corpus of the coverage-guided search: trajectories that reached something rare, kept to be continued."""

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from random import Random

import numpy as np

from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.state import Value
from sjdsl.properties.coverage import Feature
from sjdsl.properties.distance import Achievers, Distances
from sjdsl.properties.preconditions import Goal
from sjdsl.properties.trajectory import Scenario, Trajectory

SELDOM = 3  # a feature seen fewer times than this makes a trajectory worth keeping
LONGEST = 48  # steps after which a trajectory is not continued
LOOKED_AT = 24  # entries looked at; the first few on a map where a goal seems possible compete
ASKED = 8  # random entries among which the best is chosen
TIRING = 4  # after so many failed attempts on its map, or twice as many continuations, an entry counts as twice as far from a goal


@dataclass
class CorpusEntry:
    """A trajectory that ends where something new happened, how to repeat it, what was new, and how often it was continued."""

    scenario: Scenario
    trajectory: Trajectory = field(compare=False, repr=False)
    new: tuple[Feature, ...] = field(compare=False, repr=False)
    chosen: int = 0
    distances: Distances | None = field(default=None, compare=False, repr=False)

    def distance(self, goal: Goal, achievers: Achievers) -> float:
        """Returns the distance of its last state from a goal."""
        if self.distances is None:
            self.distances = Distances(achievers, self.trajectory.game, self.trajectory.worlds[-1])
        return self.distances.of(goal.precondition, goal.many)


@dataclass
class Corpus:
    """The trajectories kept, and how often every feature was seen.

    nearer: entries that came nearer to a goal. vain: for each map, how many attempts since then did not: its agents may be stuck.
    hopeless: maps, numbers of agents and goals, where no way to the goal was seen from some state.
    """

    entries: list[CorpusEntry] = field(default_factory=list)
    seen: Counter[Feature] = field(default_factory=Counter)
    nearer: dict[Goal, list[CorpusEntry]] = field(default_factory=dict)
    vain: Counter[tuple[str, ...]] = field(default_factory=Counter)
    hopeless: set[tuple[tuple[str, ...], int, Goal]] = field(default_factory=set)

    def add(self, scenario: Scenario, trajectory: Trajectory, since: int, numbers: Sequence[int]) -> None:
        """Keeps the trajectory up to each of its steps from `since` on that shows a rare feature."""
        before: set[Feature] = set()
        for t in range(since, len(trajectory.outcomes)):
            found = set(trajectory.features[t]) | set(_state_features(trajectory, t + 1, numbers))
            new = found - before
            before |= found
            seldom = tuple(f for f in new if self.seen[f] < SELDOM)
            self.seen.update(new)
            over = trajectory.outcomes[t].terminated or trajectory.outcomes[t].truncated
            if seldom and not over and t < LONGEST:
                cut = replace(scenario, actions=tuple(trajectory.actions[: t + 1]), bias=scenario.bias[: t + 1])
                self.entries.append(CorpusEntry(cut, trajectory.cut(t + 1), seldom))

    def add_nearer(self, scenario: Scenario, trajectory: Trajectory, goal: Goal) -> None:
        """Keeps a trajectory that came nearer to a goal than the one it continued."""
        self.entries.append(CorpusEntry(scenario, trajectory, ()))
        self.nearer.setdefault(goal, []).append(self.entries[-1])

    def choose(self, random: Random, achievers: Achievers, goal: Goal | None = None) -> CorpusEntry:
        """Returns an entry to continue: of a random few the one with the rarest features, or the nearest to the goal.

        Entries continued before count less. For a goal, the latest entries that came nearer to it are always looked at.
        """
        some = [self.entries[random.randrange(len(self.entries))] for _ in range(ASKED if goal is None else LOOKED_AT)]
        if goal is None:
            best = min(some, key=lambda entry: (1 + entry.chosen) * min((self.seen[f] for f in entry.new), default=SELDOM))
        else:
            some = [entry for entry in some if (entry.scenario.rows, entry.scenario.agents, goal) not in self.hopeless][:ASKED] or some[
                :ASKED
            ]
            some += self.nearer.get(goal, [])[-ASKED:]
            lost = [entry.scenario for entry in some if entry.distance(goal, achievers) == math.inf]
            self.hopeless |= {(scenario.rows, scenario.agents, goal) for scenario in lost}
            best = min(
                some,
                key=lambda entry: (
                    (1 + entry.distance(goal, achievers)) * (1 + (self.vain[entry.scenario.rows] + entry.chosen / 2) / TIRING)
                ),
            )
        best.chosen += 1
        return best


def _state_features(trajectory: Trajectory, at: int, numbers: Sequence[int]) -> Iterator[Feature]:
    """Yields features of a state: counts of field values, kinds stood on, values that checks read; and all pairs of them."""
    world, board = trajectory.worlds[at], board_of(trajectory.game)
    fields = [*world.cells.items(), *world.agents.items(), *((name, [value]) for name, value in world.fields.items())]
    fields += [((sort, name), values) for sort, herd in world.movers.items() for name, values in herd.fields.items()]
    single: list[Feature] = []
    for name, values in fields:
        single += [("so", name, value, min(n, 2)) for value, n in Counter(map(bucket, values)).items()]
    standing = Counter(board.kind_of[cell] for cell in world.position if cell is not None)
    single += [("on", kind, min(n, 2)) for kind, n in standing.items()]
    single += [("away", min(2, sum(a is not None for a in world.away)))]
    for sort, herd in world.movers.items():
        under = Counter(board.kind_of[cell] for cell in herd.position if cell is not None)
        single += [("on", sort, kind, min(n, 2)) for kind, n in under.items()]
        single += [("away", sort, min(2, sum(a is not None for a in herd.away)))]
    for number in numbers:
        check = trajectory.game.checks[number]
        ends = zip(trajectory.values(check)[0], trajectory.values(check)[at], strict=True)
        single += [("read", number, index, bucket(first), bucket(value)) for index, (first, value) in enumerate(ends)]
    yield from single
    yield from _pairs(single)


def _pairs(single: Iterable[Feature]) -> Iterator[Feature]:
    yield from (("pair", a, b) for a, b in combinations(sorted(single, key=repr), 2))


def bucket(value: Value) -> object:
    """Returns a value with large numbers put into one bucket: whole numbers beyond 4 either way, reals beyond 2."""
    if isinstance(value, tuple):
        return tuple(map(bucket, value))
    if isinstance(value, frozenset):
        return min(len(value), 2)
    if isinstance(value, str | bool) or value is None:
        return value
    return int(np.sign(value)) * min(4 if isinstance(value, int) else 2, int(abs(value)))
