"""Courses worth going on with: cut off where something happened, or was so, that had seldom been before."""

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
from sjdsl.properties.distance import Chains, Distances
from sjdsl.properties.preconditions import Goal
from sjdsl.properties.trajectory import Course, Played

SELDOM = 3  # so often something happens and still makes a course worth going on with
LONGEST = 48  # steps after which a course is not continued
LOOKED_AT = 24  # courses of which those that are asked are the first on a map where a goal seems possible
ASKED = 8  # courses of which one is chosen
TIRING = 4  # after so many courses in vain on its map, or twice as many that went on from it, a course counts as twice as far from a goal


@dataclass
class Kept:
    """A course that ends where something was new: as made, as played, what was new in it, and how often it was gone on with."""

    course: Course
    played: Played = field(compare=False, repr=False)
    new: tuple[Feature, ...] = field(compare=False, repr=False)
    chosen: int = 0
    distances: Distances | None = field(default=None, compare=False, repr=False)

    def distance(self, goal: Goal, chains: Chains) -> float:
        """Returns how far the last state is from what a goal asks for."""
        if self.distances is None:
            self.distances = Distances(chains, self.played.game, self.played.worlds[-1])
        return self.distances.of(goal.recipe, goal.many)


@dataclass
class Corpus:
    """The courses kept, and how often everything was seen.

    nearer: those that came nearer to a goal. vain: how often since then a course on a map, with a goal, has not: agents may be stuck there.
    hopeless: maps, numbers of agents and goals, where from some state on no way to the goal was seen.
    """

    kept: list[Kept] = field(default_factory=list)
    seen: Counter[Feature] = field(default_factory=Counter)
    nearer: dict[Goal, list[Kept]] = field(default_factory=dict)
    vain: Counter[tuple[str, ...]] = field(default_factory=Counter)
    hopeless: set[tuple[tuple[str, ...], int, Goal]] = field(default_factory=set)

    def add(self, course: Course, played: Played, since: int, promises: Sequence[int]) -> None:
        """Remembers a course, up to each of its steps from `since` on in which something new is to be seen."""
        before: set[Feature] = set()
        for t in range(since, len(played.outcomes)):
            found = set(played.happened[t]) | set(_so(played, t + 1, promises))
            new = found - before
            before |= found
            seldom = tuple(f for f in new if self.seen[f] < SELDOM)
            self.seen.update(new)
            over = played.outcomes[t].terminated or played.outcomes[t].truncated
            if seldom and not over and t < LONGEST:
                cut = replace(course, actions=tuple(played.actions[: t + 1]), luck=course.luck[: t + 1])
                self.kept.append(Kept(cut, played.cut(t + 1), seldom))

    def add_nearer(self, course: Course, played: Played, goal: Goal) -> None:
        """Remembers a course that came nearer to a goal than the one it went on from."""
        self.kept.append(Kept(course, played, ()))
        self.nearer.setdefault(goal, []).append(self.kept[-1])

    def choose(self, random: Random, chains: Chains, goal: Goal | None = None) -> Kept:
        """Returns a course to go on with, of some, rather one that was seldom gone on with.

        That in which the rarest happened; for a goal, the nearest to it, where those that came nearer to it before are always looked at.
        """
        some = [self.kept[random.randrange(len(self.kept))] for _ in range(ASKED if goal is None else LOOKED_AT)]
        if goal is None:
            best = min(some, key=lambda kept: (1 + kept.chosen) * min((self.seen[f] for f in kept.new), default=SELDOM))
        else:
            some = [kept for kept in some if (kept.course.rows, kept.course.agents, goal) not in self.hopeless][:ASKED] or some[:ASKED]
            some += self.nearer.get(goal, [])[-ASKED:]
            lost = [kept.course for kept in some if kept.distance(goal, chains) == math.inf]
            self.hopeless |= {(course.rows, course.agents, goal) for course in lost}
            best = min(
                some, key=lambda kept: (1 + kept.distance(goal, chains)) * (1 + (self.vain[kept.course.rows] + kept.chosen / 2) / TIRING)
            )
        best.chosen += 1
        return best


def _so(played: Played, at: int, promises: Sequence[int]) -> Iterator[Feature]:
    """Yields, roughly, what a state is like: how many have which value of a field, who stands where, what promises read; and all pairs."""
    world, board = played.worlds[at], board_of(played.game)
    fields = [*world.cells.items(), *world.agents.items(), *((name, [value]) for name, value in world.fields.items())]
    single: list[Feature] = []
    for name, values in fields:
        single += [("so", name, value, min(n, 2)) for value, n in Counter(map(rough, values)).items()]
    standing = Counter(board.kind_of[place] for place in world.position if place is not None)
    single += [("on", kind, min(n, 2)) for kind, n in standing.items()]
    single += [("away", min(2, sum(a is not None for a in world.away)))]
    for number in promises:
        check = played.game.checks[number]
        ends = zip(played.values(check)[0], played.values(check)[at], strict=True)
        single += [("read", number, place, rough(first), rough(value)) for place, (first, value) in enumerate(ends)]
    yield from single
    yield from _pairs(single)


def _pairs(single: Iterable[Feature]) -> Iterator[Feature]:
    yield from (("pair", a, b) for a, b in combinations(sorted(single, key=repr), 2))


def rough(value: Value) -> object:
    """Returns a value with whole numbers above 4, and reals above 2, taken together; those below -4 and -2, too."""
    if isinstance(value, tuple):
        return tuple(map(rough, value))
    if isinstance(value, frozenset):
        return min(len(value), 2)
    if isinstance(value, str | bool) or value is None:
        return value
    return int(np.sign(value)) * min(4 if isinstance(value, int) else 2, int(abs(value)))
