"""Searches for counterexamples on the interpreter, guided by coverage and by distance from goals, and shrinks them."""

import math
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from random import Random

from sjdsl.compiler import ir
from sjdsl.interpreter.state import World
from sjdsl.properties.biased_draws import BIASES, Bias
from sjdsl.properties.corpus import Corpus, CorpusEntry
from sjdsl.properties.coverage import MANY, statements_run
from sjdsl.properties.distance import Achievers, Distances
from sjdsl.properties.goals import guided_driver
from sjdsl.properties.instances import GameFamily
from sjdsl.properties.monitors import STATES, Violation, find_violation
from sjdsl.properties.multiplicity import is_always_once
from sjdsl.properties.preconditions import NEVER, Goal, Precondition, preconditions_of
from sjdsl.properties.random_starts import own_start, random_start, start_on_own_map
from sjdsl.properties.shrinking import shrink
from sjdsl.properties.statements import STARTING, StatementId, leaf_statements
from sjdsl.properties.trajectory import Scenario, Trajectory, play
from sjdsl.properties.verdict import Effort

AGAIN = 0.75  # how often an earlier trajectory is continued
GUIDED = 0.75  # how often agents work towards a goal
CLOSEST = 0.6  # how often these continue the trajectory nearest to their goal
OWN = 0.05  # how often, while statements are uncovered after all trajectories asked for, one begins on the game's own map
MOST_STEPS = 18  # of one continuation towards a goal
FEW_STEPS = 10  # of one without a goal, or with a goal that was often reached or often missed
LEAST_STEPS = 10  # of the others
SELDOM = 10  # distances are measured for a goal until it was reached so often
GIVEN_UP = 24  # and until it was missed so often since a trajectory came nearest to it
VAIN = 1.0  # how fast a goal is given up, the more often trajectories came no nearer to it
NEARER = 0.5  # a trajectory comes nearer to a goal by so much if it did something towards it, and did not only go there
STARTS = 4  # random starts, of which the first with a path to the goal is taken
GOALS = 4  # goals that are tried until one has a path to it
LONGEST = 64  # steps added to a trajectory while it comes nearer to a goal
SCRIPTED = 400  # steps of a trajectory by a policy of the file, on the game's own map, while statements are still uncovered
MIXED = 2  # trajectories, if there are several policies, in which each agent follows any of them
QUICK = 100  # cells of a map on which all tries are made to simplify a counterexample; on larger ones, which take longer, fewer
PART = 50  # of which so many are played before it is looked whether they are covered now
FLOATS = -1  # stands for the check that every real stays inside float32
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
class SearchRecord:
    """How many trajectories were played, how many of them `refused` because the game does not take the map; `ran`: runs of each statement.

    triggers: for each `once`, in how many trajectories its first condition held.
    """

    number: int = 0
    refused: int = 0
    ran: Counter[StatementId] = field(default_factory=Counter)
    corpus: Corpus = field(default_factory=Corpus)
    triggers: Counter[int] = field(default_factory=Counter)


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
        find: ViolationFinder,
        needed: Mapping[int, Collection[StatementId]],
        own_map: bool = False,
        progress: Progress = lambda _: None,
    ):
        """`own_map`: play on the game's own map only; for the others see `search`."""
        self.family, self.effort, self.find, self._progress = family, effort, find, progress
        self._start = start_on_own_map if own_map else random_start
        self._where = "on the game's own map" if own_map else "on small maps"
        self.left, self.found, self.record = list(numbers), list[Counterexample](), SearchRecord()
        self.preconditions = preconditions_of(leaf_statements(family.own), family.own)
        self._needed, self._random = dict(needed), Random(effort.seed)
        self._achievers = Achievers(self.preconditions)
        self._beside = _blocks(self.preconditions)
        self._aims = [i for i in self._beside if self.preconditions[i].statement_id[0] != STARTING] or list(self._beside)
        self._latest: tuple[World, Distances] | None = None
        self._biases: Sequence[Bias] = BIASES
        self._nearest = dict[Goal, float]()
        self._vain = Counter[Goal | None]()

    def run(self) -> None:
        """Plays as many trajectories as asked for, and up to as many again while statements that checks depend on never ran."""
        while self.record.number < 2 * self.effort.examples:
            missing = self._missing()
            if not missing and (not self.left or self.record.number >= self.effort.examples):
                break
            self.one(missing if self.record.number >= self.effort.examples else set())
        self.follow_policies()

    def follow_policies(self) -> None:
        """Plays by the policies of the file on the game's own map while statements that checks depend on never ran."""
        names = [policy.name for policy in self.family.own.policies]
        for followed in [[name] for name in names] + [names] * (MIXED if len(names) > 1 else 0):
            if self._missing():
                self._by_policies(followed)

    def _missing(self) -> set[StatementId]:
        """Returns the statements that checks depend on and that never ran."""
        return set[StatementId]().union(*self._needed.values()) - set(self.record.ran)

    def _by_policies(self, names: Sequence[str]) -> None:
        """Plays one trajectory on the game's own map, each agent by one of some policies of the file, until nothing needed is uncovered."""
        own, checks = self.family.own, self._checks(self.family.own)
        scenario = own_start(self.family, self._random)
        led = replace(
            scenario, policies=tuple(ir.Policy(name="scripted", scripted=self._random.choice(names)) for _ in range(scenario.agents))
        )
        trajectory = play(own, led, 0, checks)
        self.record.number += 1
        while trajectory.worlds and not trajectory.is_over and len(trajectory.outcomes) < SCRIPTED:
            first = len(trajectory.outcomes)
            trajectory = play(own, led, first + PART, checks, trajectory)
            self._count(replace(scenario, actions=tuple(trajectory.actions)), trajectory, first)
            if not self._missing():
                break

    def one(self, missing: Collection[StatementId] = ()) -> None:
        """Plays one new or continued trajectory."""
        self.record.number += 1
        self._progress(f"trajectory {self.record.number} of {self.effort.examples} {self._where}")
        random = self._random
        goal = self._choose_goal(missing) if self.preconditions and random.random() < GUIDED else None
        begun = self._begin(bool(missing), goal, random.random() < CLOSEST)
        if begun is None:
            self.record.refused += 1
            return
        scenario, since = begun
        if self._is_hot(goal) and self.record.corpus.entries and self._distance(since, goal) == math.inf:
            older = self.record.corpus.choose(random, self._achievers, goal)
            scenario, since = older.scenario, older.trajectory
        trajectory = since
        if since.worlds and not since.is_over:
            for _ in range(GOALS):
                if not self._is_hot(goal) or self._distance(since, goal) < math.inf:
                    break
                goal = self._choose_goal(missing)
            scenario, trajectory = self._go_on(scenario, since, goal)
        self._look(scenario, trajectory, len(since.outcomes))

    def _go_on(self, scenario: Scenario, trajectory: Trajectory, goal: Goal | None) -> tuple[Scenario, Trajectory]:
        """Returns a trajectory continued once, or several times as long as it comes nearer to the goal each time."""
        game, random, corpus = trajectory.game, self._random, self.record.corpus
        hot = self._is_hot(goal)
        near, most = self._distance(trajectory, goal) if hot else math.inf, LONGEST
        steps = random.randint(LEAST_STEPS, MOST_STEPS) if hot else random.randint(1, FEW_STEPS)
        while steps > 0 and most > 0:
            first = len(trajectory.outcomes)
            driver = guided_driver(game, self.preconditions, goal, self.record.ran, steps, random)
            scenario = replace(scenario, bias=scenario.bias + (random.choice(self._biases),) * steps)
            trajectory = play(game, scenario, first + steps, self._checks(game), trajectory, driver)
            scenario = replace(scenario, actions=tuple(trajectory.actions), bias=scenario.bias[: len(trajectory.actions)])
            taken = len(trajectory.outcomes) - first
            steps, most = steps - max(1, taken), most - max(1, taken)
            if goal is None or trajectory.is_over:
                break
            now = self._distance(trajectory, goal) if hot else math.inf
            if now < near - NEARER:
                near, steps, corpus.vain[scenario.rows] = now, MOST_STEPS, 0
                corpus.add_nearer(scenario, trajectory, goal)
                if now < self._nearest.get(goal, math.inf) - NEARER:
                    self._nearest[goal], self._vain[goal] = now, 0
            elif steps <= 0:
                corpus.vain[scenario.rows] += hot and 0 < near < math.inf
                self._vain[goal] += 1
        return scenario, trajectory

    def _distance(self, trajectory: Trajectory, goal: Goal | None) -> float:
        if goal is None or trajectory.is_over:
            return math.inf
        world = trajectory.worlds[-1]
        if self._latest is None or self._latest[0] is not world:
            self._latest = (world, Distances(self._achievers, trajectory.game, world))
        return self._latest[1].of(goal.precondition, goal.many)

    def _times(self, goal: Goal) -> int:
        """Returns how often a goal was reached, as far as that is counted."""
        statement = self.preconditions[goal.precondition].statement_id
        return self.record.ran[statement] if goal.many == 1 else self.record.corpus.seen["times", statement, goal.many]

    def _is_hot(self, goal: Goal | None) -> bool:
        """Returns whether distances are measured for a goal: seldom reached, and not often missed since a trajectory came nearest to it."""
        return goal is not None and self._times(goal) < SELDOM and self._vain[goal] < GIVEN_UP

    def _choose_goal(self, missing: Collection[StatementId]) -> Goal:
        """Returns a random goal, more often one seldom reached and seldom tried; of the uncovered statements, if any can be a goal."""
        goals = dict[Goal, float]()
        wanted = [i for i in self._aims if any(self.preconditions[j].statement_id in missing for j in self._beside[i])] or self._aims
        for i in wanted:
            for many in range(1, 2 if is_always_once(self.preconditions[i].quantifiers) else MANY + 1):
                times = self._times(Goal(i, many))
                goals[Goal(i, many)] = (1 / (1 + times) ** 0.5 if times else NEVER) / (1 + self._vain[Goal(i, many)]) ** VAIN
                if not times:
                    break
        return self._random.choices(list(goals), list(goals.values()))[0]

    def _begin(self, on_own: bool, goal: Goal | None, closest: bool) -> tuple[Scenario, Trajectory] | None:
        """Returns the trajectory to continue, an earlier one or a new start; None if the game does not take its map.

        A start with a path to the goal, if one is soon found; with `closest`, more often the entry nearest to the goal.
        """
        random, entries = self._random, self.record.corpus.entries
        if entries and random.random() < AGAIN:
            older: CorpusEntry = self.record.corpus.choose(random, self._achievers, goal if closest and self._is_hot(goal) else None)
            return older.scenario, older.trajectory
        found: tuple[Scenario, Trajectory] | None = None
        for _ in range(STARTS):
            start = own_start(self.family, random) if on_own and random.random() < OWN else None
            scenario = start or self._start(self.family, random, on_own)
            game = None if scenario is None else self.family.on(scenario.rows, scenario.agents, scenario.sizes)
            if scenario is None or game is None:
                return found
            found = scenario, play(game, scenario, 0, self._checks(game))
            if not self._is_hot(goal) or self._distance(found[1], goal) < math.inf:
                break
        return found

    def _checks(self, game: ir.Game) -> list[ir.Check]:
        return [game.checks[number] for number in self.left if game.checks[number].sort in STATES]

    def _look(self, scenario: Scenario, trajectory: Trajectory, first: int) -> None:
        """Counts the features of the new steps of a trajectory, looks for violations, and keeps it if it has new features."""
        self._count(scenario, trajectory, first)
        checks = trajectory.game.checks
        self.record.corpus.add(scenario, trajectory, first, [n for n in self.left if checks[n].sort in STATES])

    def _count(self, scenario: Scenario, trajectory: Trajectory, first: int) -> None:
        """Counts the statements that ran in the new steps of a trajectory, and looks for violations in them."""
        self.record.ran.update(s for t in range(first, len(trajectory.features)) for s in statements_run(trajectory.features[t]))
        if not first:
            self.record.ran.update(statements_run(trajectory.start_features))
        checks = trajectory.game.checks
        for number in self.left:
            if checks[number].sort == "once":
                self.record.triggers[number] += any(trigger for trigger, _ in trajectory.values(checks[number])[first + 1 :])
        unrefuted = [*self.left, *([] if any(b.number == FLOATS for b in self.found) else [FLOATS])]
        for number in unrefuted:
            counterexample = first_counterexample(trajectory, [number], scenario, self.find, first)
            if counterexample is not None:
                self.found.append(simplest_counterexample(self.family, counterexample, self.find, self.effort))
                self.left = [left for left in self.left if left != number]
                self._needed.pop(number, None)


def search(
    family: GameFamily,
    numbers: list[int],
    effort: Effort,
    find: ViolationFinder = violation_in_states,
    needed: Mapping[int, Collection[StatementId]] | None = None,
) -> tuple[list[Counterexample], SearchRecord]:
    """Returns the simplest counterexample found to each check that has one, and a record of the search.

    Args:
      numbers: indices among the game's checks.
      find: returns where a check is violated in a trajectory.
      needed: statements on which checks depend, also checks not in `numbers`: while one never ran, more trajectories are played.
    """
    searching = Search(family, numbers, effort, find, needed or {})
    searching.run()
    return searching.found, searching.record


def simplest_counterexample(family: GameFamily, counterexample: Counterexample, find: ViolationFinder, effort: Effort) -> Counterexample:
    """Returns the simplest counterexample that shrinking makes of one; one on the game's own map stays there."""
    on_own = family.is_own(counterexample.scenario.rows) and not effort.any_map

    def attempt(scenario: Scenario) -> Counterexample | None:
        game = family.on(scenario.rows, scenario.agents, scenario.sizes)
        if game is None or scenario.agents not in (*family.few_agents, counterexample.scenario.agents):
            return None
        checks = (
            [game.checks[counterexample.number]]
            if counterexample.number != FLOATS and game.checks[counterexample.number].sort in STATES
            else []
        )
        return first_counterexample(play(game, scenario, None, checks), [counterexample.number], scenario, find, 0)

    def shorter(scenario: Scenario) -> Scenario | None:
        found = attempt(scenario)
        return (
            None
            if found is None
            else replace(found.scenario, actions=scenario.actions[: _length(found)], bias=scenario.bias[: _length(found)])
        )

    first = shorter(counterexample.scenario)
    assert first is not None, "a scenario that is played again leads elsewhere"
    cells = len(first.rows) * len(first.rows[0])
    tries = effort.tries * min(cells, QUICK) // cells
    found = attempt(shrink(first, family.own, None if on_own else family.glyphs[0], shorter, tries))
    assert found is not None
    return found


def _blocks(preconditions: Sequence[Precondition]) -> dict[int, list[int]]:
    """Returns the statements that always run together, by the first of them: one goal."""
    firsts: dict[tuple[object, ...], int] = {}
    found: dict[int, list[int]] = {}
    for i, precondition in enumerate(preconditions):
        found.setdefault(firsts.setdefault(precondition.block, i), []).append(i)
    return found


def _length(counterexample: Counterexample) -> int:
    return max(1, counterexample.where.at)


def first_counterexample(
    trajectory: Trajectory, numbers: Collection[int], scenario: Scenario, find: ViolationFinder, since: int
) -> Counterexample | None:
    """Returns the first counterexample that a trajectory gives to one of the checks, if any."""
    for number in numbers:
        if number == FLOATS:
            where = None if trajectory.left is None else Violation(len(trajectory.worlds))
        else:
            where = find(trajectory.game.checks[number], trajectory, scenario, since)
        if where is not None:
            return Counterexample(number, scenario, trajectory, where)
    return None
