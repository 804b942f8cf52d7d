"""Searches for counterexamples by random play on the game's own map.

First on the interpreter, then in thousands of worlds of the compiled game.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec
from random import Random

from sjdsl.compiler import ir
from sjdsl.properties.instances import GameFamily
from sjdsl.properties.monitors import FLOATS, Violation, find_violation
from sjdsl.properties.random_play import random_scenario
from sjdsl.properties.statements import StatementId
from sjdsl.properties.trajectory import Scenario, Trajectory, play, up_to
from sjdsl.properties.verdict import Effort, Progress

# Steps on the interpreter for each example of the effort.
ALONE = 10  # where nothing is compiled
BEFORE = 2  # before the compiled game is played
LENGTHS = (5, 10, 20, 50, 100)  # steps of a trajectory there
# Steps under policies of the file while needed statements have not run. Finding paths is slow, so
# they are few where nothing is compiled.
SCRIPTED = 400
SCRIPTED_ALONE = 20
# Steps that are played again, at most, to find actions that a counterexample doesn't need.
AGAIN = 2000


@dataclass(frozen=True)
class Counterexample:
    """A trajectory that violates a check.

    number: of the check among the game's, or FLOATS; where: it is violated.
    """

    number: int
    scenario: Scenario
    trajectory: Trajectory
    where: Violation


class Search:
    """Random play for checks of a game, until each has a counterexample or enough was played.

    left: checks without a counterexample; found: the counterexamples of the others.
    steps: taken by all engines. ran: the statements that ran. triggered: each `once` whose first
    condition has held.
    """

    def __init__(
        self,
        family: GameFamily,
        numbers: Collection[int],
        effort: Effort,
        needed: Mapping[int, Collection[StatementId]] | None = None,
        progress: Progress = lambda _: None,
        reals: bool = False,
    ):
        """Prepares the play; `run` does it.

        Args:
          numbers: of checks about states.
          needed: number of any check -> statements that it depends on. Play goes on until each of
            them has run.
          reals: whether it goes on until a real leaves float32.
        """
        self.family = family
        self.effort = effort
        self.left = list(numbers)
        self.found: dict[int, Counterexample] = {}
        self.steps = 0
        self.ran: set[StatementId] = set()
        self.triggered: set[int] = set()
        self._needed = needed or {}
        self._progress = progress
        self._reals = reals
        self._random = Random(effort.seed)
        self._is_compiled = effort.compiled and find_spec("jax") is not None

    def run(self) -> None:
        """Plays everything. If this is interrupted, what has been found so far is kept."""
        budget = self.effort.examples * (BEFORE if self._is_compiled else ALONE)
        while budget > 0 and self._goes_on():
            self._progress(f"{self.steps} steps of random play")
            steps = min(budget, self._random.choice(LENGTHS))
            scenario = random_scenario(self.family.own, steps, self._random)
            self._look_at(scenario, len(scenario.actions), self.left)
            budget -= len(scenario.actions)
        if self._is_compiled and self._goes_on():
            self._play_worlds()
        names = [policy.name for policy in self.family.own.policies]
        mixtures = [[name] for name in names]
        if len(names) > 1:
            mixtures += [names, names[::-1]]
        for mixture in mixtures:
            if self.missing():
                self._play_scripted(mixture)

    def _goes_on(self) -> bool:
        """Returns whether a check has no counterexample yet, or a statement is missing."""
        return bool(self.left) or not self._has_all(set())

    def _play_worlds(self) -> None:
        """Plays the compiled game, and violations that it finds again on the interpreter."""
        from sjdsl.properties.worlds import WorldSearch

        worlds = WorldSearch(self.family, self.left, self.effort, self._progress)
        for number, scenario in worlds.run(self._has_all):
            self._look_at(scenario, len(scenario.actions), [number])
        self.steps += worlds.steps
        self.ran |= worlds.ran
        self.triggered |= worlds.triggered

    def _play_scripted(self, names: Sequence[str]) -> None:
        """Plays policies of the file, dealt out to the agents in turn, while one is missing."""
        policies = tuple(
            ir.Policy(name="scripted", scripted=names[i % len(names)])
            for i in range(self.family.own.agents.number)
        )
        scenario = Scenario(self._random.randrange(2**16), policies=policies)
        steps = SCRIPTED if self._is_compiled else SCRIPTED_ALONE
        self._look_at(scenario, steps, self.left, self._has_all)

    def missing(self) -> set[StatementId]:
        """Returns the statements that never ran and that open checks depend on."""
        needed: set[StatementId] = set()
        for number, statements in self._needed.items():
            if number not in self.found:
                needed |= set(statements)
        return needed - self.ran

    def _has_all(self, ran: set[StatementId]) -> bool:
        """Returns whether nothing is missing once these statements have run, too."""
        return self.missing() <= ran and (FLOATS in self.found or not self._reals)

    def _look_at(
        self,
        scenario: Scenario,
        steps: int,
        numbers: Sequence[int],
        is_enough: Callable[[set[StatementId]], bool] = lambda _: False,
    ) -> None:
        """Plays a scenario on the interpreter.

        Notes the statements that ran, and what violates the checks with these numbers.
        """
        checks = {i: self.family.own.checks[i] for i in numbers if i != FLOATS}
        trajectory = play(self.family.own, scenario, steps, list(checks.values()), is_enough)
        self.steps += len(trajectory.outcomes)
        self.ran |= trajectory.ran
        for i, check in checks.items():
            if check.kind == "once" and any(values[0] for values in trajectory.values(check)[1:]):
                self.triggered.add(i)
        written = replace(scenario, actions=tuple(trajectory.actions), policies=())
        for number in {*numbers, FLOATS} - self.found.keys():
            counterexample = _counterexample(number, written, trajectory)
            if counterexample is not None:
                self.found[number] = simplified(counterexample)
        self.left = [number for number in self.left if number not in self.found]


def simplified(counterexample: Counterexample) -> Counterexample:
    """Returns a counterexample that is no longer, with fewer actions.

    It has the file's parameters if it can, and `stay` for actions that it doesn't need. All actions
    of each agent are left out in turn, then halves, quarters and so on of what remains, down to
    single actions. AGAIN steps are played at most, so some actions of a long counterexample may
    remain.
    """
    budget = AGAIN - len(counterexample.scenario.actions)
    with_params_of_file = replace(counterexample.scenario, params=())
    counterexample = _played_as(with_params_of_file, counterexample) or counterexample
    for agent in range(counterexample.trajectory.game.agents.number):
        of_agent = [(t, actor) for t, actor in _active(counterexample) if actor == agent]
        counterexample, budget = _without(of_agent, counterexample, budget)
    size = len(_active(counterexample)) // 2
    while size:
        active = _active(counterexample)
        for first in range(0, len(active), size):
            counterexample, budget = _without(active[first : first + size], counterexample, budget)
        if size > 1 or active == _active(counterexample):
            size //= 2
    return counterexample


def _active(counterexample: Counterexample) -> list[tuple[int, int]]:
    """Returns (step, agent) where an agent does something, in order."""
    stay = counterexample.trajectory.game.agents.actions.index("stay")
    active = []
    for t, actions in enumerate(counterexample.scenario.actions):
        active += [(t, agent) for agent, action in enumerate(actions) if action != stay]
    return active


def _without(
    active: Sequence[tuple[int, int]], counterexample: Counterexample, budget: int
) -> tuple[Counterexample, int]:
    """Returns a counterexample without some actions if it is one, else as it was.

    Args:
      active: (step, agent) of these actions, in order.
      budget: steps that may be played. What is left of it is returned, too.
    """
    steps = [list(actions) for actions in counterexample.scenario.actions]
    active = [(t, agent) for t, agent in active if t < len(steps)]
    since = active[0][0] if active else len(steps)  # steps before the first change are known
    cost = len(steps) - since
    if not 0 < cost <= budget:
        return counterexample, budget
    stay = counterexample.trajectory.game.agents.actions.index("stay")
    for t, agent in active:
        steps[t][agent] = stay
    scenario = replace(counterexample.scenario, actions=tuple(map(tuple, steps)))
    return _played_as(scenario, counterexample, since) or counterexample, budget - cost


def _played_as(
    scenario: Scenario, counterexample: Counterexample, since: int | None = None
) -> Counterexample | None:
    """Returns the counterexample that a changed scenario gives to the same check.

    Its steps before `since` are those of `counterexample`. None if it gives none, or isn't changed.
    """
    if scenario == counterexample.scenario:
        return None
    game = counterexample.trajectory.game
    checks = [] if counterexample.number == FLOATS else [game.checks[counterexample.number]]
    begun = None if since is None else counterexample.trajectory
    trajectory = play(game, scenario, checks=checks, begun=begun, since=since or 0)
    return _counterexample(counterexample.number, scenario, trajectory)


def _counterexample(
    number: int, scenario: Scenario, trajectory: Trajectory
) -> Counterexample | None:
    """Returns the counterexample that a trajectory gives to a check, cut off at the violation."""
    where = None
    if number == FLOATS:
        if trajectory.overflow is not None:
            where = Violation(len(trajectory.worlds))
    elif trajectory.worlds:
        check = trajectory.game.checks[number]
        where = find_violation(check, trajectory.values(check))
    if where is None:
        return None
    return Counterexample(number, up_to(scenario, where.at), trajectory, where)
