"""Looks on a game's own map for a counterexample like one that was found on another map: the same statements are to run, in that order."""

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

from sjdsl.compiler import ir
from sjdsl.properties.biased_draws import BIASES, Bias
from sjdsl.properties.coverage import MANY, statements_run
from sjdsl.properties.effects import reads
from sjdsl.properties.instances import GameFamily
from sjdsl.properties.monitors import STATES
from sjdsl.properties.preconditions import Goal
from sjdsl.properties.random_starts import own_start
from sjdsl.properties.search import FLOATS, Counterexample, Progress, Search, ViolationFinder
from sjdsl.properties.statements import StatementId
from sjdsl.properties.trajectory import Scenario, Trajectory, play
from sjdsl.properties.verdict import Effort

REPEATED = 0.5  # how often the statements of a counterexample are repeated; else they are goals, among others
LONG_ONES = 6  # long trajectories for a `once`, whose first condition may need many steps on a large map; for other checks one
LONGEST = 400  # steps of these
ALIKE = 0.5  # how often goals are statements of a counterexample, and how often its parameters and number of agents are taken


class OwnMapSearch(Search):
    """Plays on the game's own map, led by counterexamples to its checks on other maps."""

    def __init__(
        self,
        family: GameFamily,
        leads: Sequence[Counterexample],
        effort: Effort,
        find: ViolationFinder,
        needed: Mapping[int, Collection[StatementId]],
        progress: Progress,
    ):
        numbers = [lead.number for lead in leads if lead.number != FLOATS]
        super().__init__(family, numbers, effort, find, needed, True, progress)
        self._leads = [(lead, self._script(lead.trajectory)) for lead in leads]

    def run(self) -> None:
        """Plays as many trajectories as asked for, until each check has a counterexample."""
        for lead, _ in self._leads:
            if lead.number != FLOATS and self.family.own.checks[lead.number].sort in STATES:
                once = self.family.own.checks[lead.number].sort == "once"
                for _ in range(LONG_ONES if once else 1):
                    if lead.number in self.left:
                        self._for_long(self.family.own.checks[lead.number], ("bad",) if once else ("good",))
        while self._open() and self.record.number < self.effort.examples:
            self.one()
        if self._open():
            self.follow_policies()

    def one(self, missing: Collection[StatementId] = ()) -> None:
        """Plays one trajectory: at times the statements of a counterexample, one after the other."""
        lead, script = self._random.choice(self._open() or self._leads)
        if not script or self._random.random() >= REPEATED:
            super().one(missing)
            return
        self.record.number += 1
        scenario = self._like(lead.scenario)
        game = self.family.on(scenario.rows, scenario.agents, scenario.sizes)
        assert game is not None
        trajectory = play(game, scenario, 0, self._checks(game))
        for goal in script:
            if not trajectory.worlds or trajectory.is_over:
                break
            scenario, trajectory = self._go_on(scenario, trajectory, goal)
        self._look(scenario, trajectory, 0)

    def _for_long(self, check: ir.Check, biases: Sequence[Bias]) -> None:
        """Plays a long trajectory in which agents change what a check reads; with some biases of the draws, for a `once` until it applies."""
        about = set(reads(check.values[0]))
        changing = [Goal(i, MANY) for i in self._aims if self.preconditions[i].writes & about and self.preconditions[i].agents]
        goals = changing or [Goal(i, 1) for i in self._aims]
        self.record.number += 1
        game, scenario = self.family.own, own_start(self.family, self._random)
        trajectory = play(game, scenario, 0, self._checks(game))
        while goals and trajectory.worlds and not trajectory.is_over and check in self._checks(game):
            first = len(trajectory.outcomes)
            applies = check.sort == "once" and any(trigger for trigger, _ in trajectory.values(check)[1:])
            self._biases = BIASES if applies else biases
            scenario, trajectory = self._go_on(scenario, trajectory, self._random.choice(goals))
            self._count(scenario, trajectory, first)
            if len(trajectory.outcomes) == first or len(trajectory.outcomes) >= LONGEST:
                break
        self._biases = BIASES

    def _open(self) -> list[tuple[Counterexample, list[Goal]]]:
        """Returns the leads to checks that have no counterexample on the own map yet."""
        found = {counterexample.number for counterexample in self.found}
        return [(lead, script) for lead, script in self._leads if lead.number not in found]

    def _like(self, other: Scenario) -> Scenario:
        """Returns a start on the own map; half of them with the numbers of another scenario, where the game takes them."""
        start = self._start(self.family, self._random, False) or own_start(self.family, self._random)
        if self._random.random() < ALIKE and self.family.on(start.rows, other.agents, other.sizes) is not None:
            return replace(start, agents=other.agents, params=other.params, sizes=other.sizes, policies=(None,) * other.agents)
        return start

    def _choose_goal(self, missing: Collection[StatementId]) -> Goal:
        goals = [goal for _, script in self._open() for goal in script]
        return self._random.choice(goals) if goals and self._random.random() < ALIKE else super()._choose_goal(missing)

    def _script(self, trajectory: Trajectory) -> list[Goal]:
        """Returns a goal for each step of a trajectory in which a statement ran for agents: the one that ran in the fewest steps."""
        steps = Counter(statement for features in trajectory.features for statement in statements_run(features))
        script = []
        for features in trajectory.features:
            ran = statements_run(features)
            aims = [i for i in self._aims if self.preconditions[i].statement_id in ran and self.preconditions[i].agents]
            if aims:
                aim = min(aims, key=lambda i: steps[self.preconditions[i].statement_id])
                name = self.preconditions[aim].statement_id
                script.append(Goal(aim, max([1, *(many for many in range(2, MANY + 1) if ("times", name, many) in features)])))
        return script
