"""Searches for counterexamples on the interpreter, by random play on random maps that is guided by coverage, and simplifies them."""

from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from random import Random

import numpy as np

from sjdsl.compiler import ir
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.state import Value
from sjdsl.properties.biased_draws import BIASES
from sjdsl.properties.instances import GameFamily
from sjdsl.properties.monitors import STATES, Violation, find_violation
from sjdsl.properties.random_starts import own_start, random_start, start_on_own_map
from sjdsl.properties.shrinking import shrink
from sjdsl.properties.statements import Feature, StatementId, statements_run
from sjdsl.properties.trajectory import Driver, Scenario, Trajectory, play, up_to
from sjdsl.properties.verdict import Effort
from sjdsl.runtime.actions import STEPS, TURNS

AGAIN = 0.75  # how often an earlier trajectory is continued
OWN = 0.05  # how often a trajectory for uncovered statements begins on the game's own map
FEW_STEPS = 10  # most steps of one continuation
HABIT = 0.5  # how often an agent takes its habitual action, and how often that is no move
SELDOM = 3  # a feature seen fewer times than this makes a trajectory worth keeping
LONGEST = 48  # steps after which a trajectory is not continued
ASKED = 8  # random entries of the corpus among which the one with the rarest features is chosen
SCRIPTED = 400  # steps of a trajectory by a policy of the file, on the game's own map, while statements are still uncovered
MIXED = 2  # trajectories, if there are several policies, in which each agent follows any of them
PLAYED = (
    2000  # cells times steps of a counterexample on which all tries are made to simplify it; of a larger one, which takes longer, fewer
)
PART = 50  # steps of such a trajectory that are played before it is looked whether they are covered now
FLOATS = -1  # stands for the check that every real stays inside float32
MOVES = {*STEPS, *TURNS, "stay"}
Progress = Callable[[str], None]  # is told now and then how far a test is
ViolationFinder = Callable[[ir.Check, Trajectory, Scenario, int], Violation | None]  # the last argument: the first new state


@dataclass(frozen=True)
class Counterexample:
    """A trajectory that violates a check: which one (its index among the game's checks, or FLOATS), and where."""

    number: int
    scenario: Scenario
    trajectory: Trajectory
    where: Violation


@dataclass
class CorpusEntry:
    """A trajectory that ends where something new happened, how to repeat it, what was new, and how often it was continued."""

    scenario: Scenario
    trajectory: Trajectory = field(compare=False, repr=False)
    new: tuple[Feature, ...] = field(compare=False, repr=False)
    chosen: int = 0


@dataclass
class SearchRecord:
    """How many trajectories were played, how many of them `refused` because the game does not take the map; `ran`: runs of each statement.

    triggers: for each `once`, how often its first condition came to hold. corpus: the trajectories kept; seen: how often each feature was.
    """

    number: int = 0
    refused: int = 0
    ran: Counter[StatementId] = field(default_factory=Counter)
    triggers: Counter[int] = field(default_factory=Counter)
    corpus: list[CorpusEntry] = field(default_factory=list)
    seen: Counter[Feature] = field(default_factory=Counter)

    def keep(self, scenario: Scenario, trajectory: Trajectory, since: int, numbers: Sequence[int]) -> None:
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
                self.corpus.append(CorpusEntry(up_to(scenario, t + 1), trajectory.cut(t + 1), seldom))

    def choose(self, random: Random) -> CorpusEntry:
        """Returns an entry to continue: of a random few the one with the rarest features; those continued before count less."""
        some = [random.choice(self.corpus) for _ in range(ASKED)]
        best = min(some, key=lambda entry: (1 + entry.chosen) * min((self.seen[f] for f in entry.new), default=SELDOM))
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


def violation_in_states(check: ir.Check, trajectory: Trajectory, scenario: Scenario, since: int) -> Violation | None:
    """Returns where a check about states is violated in a trajectory."""
    del scenario, since
    return find_violation(check, trajectory.values(check))


class Search:
    """Plays trajectories for some checks of a game together, until each has a counterexample or enough were played."""

    def __init__(
        self,
        family: GameFamily,
        numbers: list[int],
        effort: Effort,
        find: ViolationFinder = violation_in_states,
        needed: Mapping[int, Collection[StatementId]] | None = None,
        own_map: bool = False,
        progress: Progress = lambda _: None,
    ):
        """Takes up the checks.

        Args:
          numbers: their indices among the game's checks.
          find: returns where a check is violated in a trajectory.
          needed: statements on which checks depend, also checks not in `numbers`: while one never ran, trajectories are played.
          own_map: play on the game's own map only.
        """
        self.family, self.effort, self.find, self._progress = family, effort, find, progress
        self._start = start_on_own_map if own_map else random_start
        self._where = "on the game's own map" if own_map else "on small maps"
        self.left, self.found, self.record = list(numbers), list[Counterexample](), SearchRecord()
        self._needed, self._random = dict(needed or {}), Random(effort.seed)

    def run(self, most: int) -> None:
        """Plays up to so many trajectories."""
        while self.record.number < most and (self.left or self.missing()):
            self.one()

    def reach(self) -> None:
        """Plays as many again, with more agents on the maps, and by the policies of the file, while needed statements never ran."""
        most = self.record.number + self.effort.examples
        while self.record.number < most and self.missing():
            self.one(crowded=True)
        names = [policy.name for policy in self.family.own.policies]
        for followed in [[name] for name in names] + [names] * (MIXED if len(names) > 1 else 0):
            if self.missing():
                self._by_policies(followed)

    def missing(self) -> set[StatementId]:
        """Returns the statements that checks depend on and that never ran."""
        return set[StatementId]().union(*self._needed.values()) - set(self.record.ran)

    def settle(self, number: int) -> None:
        """Leaves a check aside that has a counterexample."""
        self.left = [left for left in self.left if left != number]
        self._needed.pop(number, None)

    def one(self, crowded: bool = False) -> None:
        """Plays one new or continued trajectory."""
        random, record = self._random, self.record
        record.number += 1
        self._progress(f"trajectory {record.number} of {self.effort.examples} {self._where}")
        if record.corpus and random.random() < AGAIN:
            older = record.choose(random)
            scenario, since = older.scenario, older.trajectory
        else:
            own = own_start(self.family, random) if crowded and random.random() < OWN else None
            start = own or self._start(self.family, random, crowded)
            game = None if start is None else self.family.on(start.rows, start.agents, start.sizes)
            if start is None or game is None:
                record.refused += 1
                return
            scenario, since = start, play(game, start, 0, self._checks(game))
        game, trajectory, first = since.game, since, len(since.outcomes)
        if since.worlds and not since.is_over:
            steps = random.randint(1, FEW_STEPS)
            scenario = replace(scenario, bias=scenario.bias + (random.choice(BIASES),) * steps)
            trajectory = play(game, scenario, first + steps, self._checks(game), since, _habitual(game, random))
            scenario = replace(scenario, actions=tuple(trajectory.actions), bias=scenario.bias[: len(trajectory.actions)])
        self._count(scenario, trajectory, first)
        record.keep(scenario, trajectory, first, [n for n in self.left if game.checks[n].sort in STATES])

    def _by_policies(self, names: Sequence[str]) -> None:
        """Plays one trajectory on the game's own map, each agent by one of some policies of the file, until nothing needed is uncovered."""
        own, checks = self.family.own, self._checks(self.family.own)
        scenario = own_start(self.family, self._random)
        led = replace(
            scenario, policies=tuple(ir.Policy(name="scripted", scripted=self._random.choice(names)) for _ in range(scenario.agents))
        )
        trajectory = play(own, led, 0, checks)
        self.record.number += 1
        while trajectory.worlds and not trajectory.is_over and len(trajectory.outcomes) < SCRIPTED and self.missing():
            first = len(trajectory.outcomes)
            trajectory = play(own, led, first + PART, checks, trajectory)
            self._count(replace(scenario, actions=tuple(trajectory.actions)), trajectory, first)

    def _checks(self, game: ir.Game) -> list[ir.Check]:
        return [game.checks[number] for number in self.left if game.checks[number].sort in STATES]

    def _count(self, scenario: Scenario, trajectory: Trajectory, first: int) -> None:
        """Counts the statements that ran in the new steps of a trajectory, and looks for violations in them."""
        self.record.ran.update(s for features in trajectory.features[first:] for s in statements_run(features))
        if not first:
            self.record.ran.update(statements_run(trajectory.start_features))
        checks = trajectory.game.checks
        for number in self.left:
            if checks[number].sort == "once":
                held = [bool(trigger) for trigger, _ in trajectory.values(checks[number])[1:]]
                self.record.triggers[number] += any(held) and not any(held[:first])
        for number in [*self.left, *([] if any(b.number == FLOATS for b in self.found) else [FLOATS])]:
            counterexample = first_counterexample(trajectory, number, scenario, self.find, first)
            if counterexample is not None:
                self.found.append(simplest_counterexample(self.family, counterexample, self.find, self.effort))
                self.settle(number)


def _habitual(game: ir.Game, random: Random) -> Driver:
    """Returns what chooses random actions; each agent often repeats one of them, more often one that is no move."""
    actions = range(len(game.agents.actions))
    special = [action for action in actions if game.agents.actions[action] not in MOVES]
    habits = [random.choice((special if special and random.random() < HABIT else None) or actions) for _ in range(game.agents.number)]
    return lambda *_: tuple(habit if random.random() < HABIT else random.choice(actions) for habit in habits)


def simplest_counterexample(family: GameFamily, counterexample: Counterexample, find: ViolationFinder, effort: Effort) -> Counterexample:
    """Returns the simplest counterexample that shrinking makes of one; one on the game's own map stays there."""
    number, on_own = counterexample.number, family.is_own(counterexample.scenario.rows) and not effort.any_map

    def attempt(scenario: Scenario) -> Counterexample | None:
        game = family.on(scenario.rows, scenario.agents, scenario.sizes)
        if game is None or scenario.agents not in (*family.few_agents, counterexample.scenario.agents):
            return None
        checks = [game.checks[number]] if number != FLOATS and game.checks[number].sort in STATES else []
        return first_counterexample(play(game, scenario, None, checks), number, scenario, find, 0)

    def shorter(scenario: Scenario) -> Scenario | None:
        found = attempt(scenario)
        return None if found is None else up_to(scenario, max(1, found.where.at))

    first = shorter(counterexample.scenario)
    assert first is not None, "a scenario that is played again leads elsewhere"
    played = len(first.rows) * len(first.rows[0]) * len(first.actions)
    tries = effort.tries * min(played, PLAYED) // max(1, played)
    found = attempt(shrink(first, family.own, None if on_own else family.glyphs[0], shorter, tries))
    assert found is not None
    return found


def first_counterexample(
    trajectory: Trajectory, number: int, scenario: Scenario, find: ViolationFinder, since: int
) -> Counterexample | None:
    """Returns the first counterexample that a trajectory gives to a check, if any."""
    if number == FLOATS:
        where = None if trajectory.left is None else Violation(len(trajectory.worlds))
    else:
        where = find(trajectory.game.checks[number], trajectory, scenario, since)
    return None if where is None else Counterexample(number, scenario, trajectory, where)
