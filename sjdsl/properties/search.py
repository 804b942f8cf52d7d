"""Searches for counterexamples by random play on the game's own map: some on the interpreter, then thousands of compiled worlds."""

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

ALONE, BEFORE = (
    10,
    2,
)  # steps on the interpreter for each example: where nothing is compiled, and before the compiled game is played
LENGTHS = (5, 10, 20, 50, 100)  # steps of its trajectories
SCRIPTED, FEW = (
    400,
    20,
)  # steps by policies of the file while statements have not run; where nothing is compiled (finding paths is slow)
AGAIN = (
    2000  # steps that are played again at most to find actions that a counterexample doesn't need
)


@dataclass(frozen=True)
class Counterexample:
    """A trajectory that violates a check: which one (its index among the game's checks, or FLOATS), and where."""

    number: int
    scenario: Scenario
    trajectory: Trajectory
    where: Violation


class Search:
    """Random play for some checks of a game together, until each has a counterexample or enough was played.

    left: checks without a counterexample; found: the counterexamples of the others. steps: taken by all engines. ran: the statements that
    ran. triggered: each `once` whose first condition has held.
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
        """`numbers`: of checks about states. `needed`: statements on which checks depend, also other checks: while one never ran, it is played on.

        `reals`: whether it is played on until a real leaves float32.
        """
        self.family, self.effort, self._needed, self._progress = (
            family,
            effort,
            needed or {},
            progress,
        )
        self._reals = reals
        self.left, self.found = list(numbers), dict[int, Counterexample]()
        self.steps, self.ran, self.triggered = 0, set[StatementId](), set[int]()
        self._random, self._is_compiled = (
            Random(effort.seed),
            effort.compiled and find_spec("jax") is not None,
        )

    def run(self) -> None:
        """Plays everything. What has been found is there, too, if this is interrupted."""
        budget = self.effort.examples * (BEFORE if self._is_compiled else ALONE)
        while budget > 0 and (self.left or not self._has_all(set())):
            self._progress(f"{self.steps} steps of random play")
            scenario = random_scenario(
                self.family.own, min(budget, self._random.choice(LENGTHS)), self._random
            )
            self._look_at(scenario, len(scenario.actions), self.left)
            budget -= len(scenario.actions)
        if self._is_compiled and (self.left or not self._has_all(set())):
            from sjdsl.properties.worlds import WorldSearch

            worlds = WorldSearch(self.family, self.left, self.effort, self._progress)
            for number, scenario in worlds.run(self._has_all):
                self._look_at(scenario, len(scenario.actions), [number])
            self.steps, self.ran, self.triggered = (
                self.steps + worlds.steps,
                self.ran | worlds.ran,
                self.triggered | worlds.triggered,
            )
        names, steps = (
            [policy.name for policy in self.family.own.policies],
            SCRIPTED if self._is_compiled else FEW,
        )
        for followed in [
            *([name] for name in names),
            *((names, names[::-1]) if len(names) > 1 else ()),
        ]:  # dealt out to the agents
            if self.missing():
                policies = (
                    ir.Policy(name="scripted", scripted=followed[i % len(followed)])
                    for i in range(self.family.own.agents.number)
                )
                self._look_at(
                    Scenario(self._random.randrange(2**16), policies=tuple(policies)),
                    steps,
                    self.left,
                    self._has_all,
                )

    def missing(self) -> set[StatementId]:
        """Returns the statements that checks without a counterexample depend on and that never ran."""
        return (
            set[StatementId]().union(
                *(needed for i, needed in self._needed.items() if i not in self.found)
            )
            - self.ran
        )

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
        """Plays a scenario on the interpreter, and notes the statements that ran and what violates checks."""
        checks = self.family.own.checks
        trajectory = play(
            self.family.own, scenario, steps, [checks[i] for i in numbers if i != FLOATS], is_enough
        )
        self.steps += len(trajectory.outcomes)
        self.ran |= trajectory.ran
        self.triggered |= {
            i
            for i in numbers
            if i != FLOATS
            and checks[i].sort == "once"
            and any(v[0] for v in trajectory.values(checks[i])[1:])
        }
        written = replace(scenario, actions=tuple(trajectory.actions), policies=())
        for number in {*numbers, FLOATS} - self.found.keys():
            if (found := _counterexample(number, written, trajectory)) is not None:
                self.found[number] = simplified(found)
        self.left = [number for number in self.left if number not in self.found]


def simplified(found: Counterexample) -> Counterexample:
    """Returns a counterexample, no longer, with the file's parameters if it can have them, and `stay` for actions that it doesn't need.

    Takes out all actions of each agent, then halves, quarters and so on of what is left, down to single actions. Plays `AGAIN` steps at
    most, so some actions of a long counterexample may be left.
    """
    left = AGAIN - len(found.scenario.actions)
    found = _played_as(replace(found.scenario, params=()), found) or found
    for agent in range(found.trajectory.game.agents.number):
        found, left = _without([(t, a) for t, a in _acting(found) if a == agent], found, left)
    size = len(_acting(found)) // 2
    while size:
        acting = _acting(found)
        for first in range(0, len(acting), size):
            found, left = _without(acting[first : first + size], found, left)
        if size > 1 or acting == _acting(found):
            size //= 2
    return found


def _acting(found: Counterexample) -> list[tuple[int, int]]:
    """Returns the steps and agents in which an agent does something, in order."""
    stay = found.trajectory.game.agents.actions.index("stay")
    return [
        (t, agent)
        for t, step in enumerate(found.scenario.actions)
        for agent, action in enumerate(step)
        if action != stay
    ]


def _without(
    acting: Sequence[tuple[int, int]], found: Counterexample, left: int
) -> tuple[Counterexample, int]:
    """Returns a counterexample without these actions if it is one, else as it was; and how many of `left` steps are left to play."""
    actions = [list(step) for step in found.scenario.actions]
    acting = [(t, agent) for t, agent in acting if t < len(actions)]
    since = acting[0][0] if acting else len(actions)
    cost = len(actions) - since
    if not 0 < cost <= left:
        return found, left
    for t, agent in acting:
        actions[t][agent] = found.trajectory.game.agents.actions.index("stay")
    scenario = replace(found.scenario, actions=tuple(map(tuple, actions)))
    return _played_as(scenario, found, since) or found, left - cost


def _played_as(
    scenario: Scenario, found: Counterexample, since: int | None = None
) -> Counterexample | None:
    """Returns the counterexample that a changed scenario gives to the same check; its steps before `since` are those of `found`."""
    if scenario == found.scenario:
        return None
    game, number = found.trajectory.game, found.number
    checks = [] if number == FLOATS else [game.checks[number]]
    begun = None if since is None else found.trajectory
    return _counterexample(
        number, scenario, play(game, scenario, checks=checks, begun=begun, since=since or 0)
    )


def _counterexample(
    number: int, scenario: Scenario, trajectory: Trajectory
) -> Counterexample | None:
    """Returns the counterexample that a trajectory gives to a check, cut off at the violation."""
    if number == FLOATS:
        where = None if trajectory.left is None else Violation(len(trajectory.worlds))
    else:
        check = trajectory.game.checks[number]
        where = find_violation(check, trajectory.values(check)) if trajectory.worlds else None
    return (
        None
        if where is None
        else Counterexample(number, up_to(scenario, where.at), trajectory, where)
    )
