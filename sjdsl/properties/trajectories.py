"""Verdicts from play: which checks fail, which pass, and which statements never ran.

The interpreter plays trajectories on small maps, and the compiled game thousands of worlds on the game's own map. Only a check that fails
there has failed; one that fails elsewhere is a note.
"""

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import replace
from importlib.util import find_spec

from sjdsl.compiler import ir
from sjdsl.properties.counterexample import LARGEST, describe_asymmetry, describe_counterexample, describe_overflow
from sjdsl.properties.instances import GameFamily, Sizes
from sjdsl.properties.monitors import STATES, Violation, find_violation
from sjdsl.properties.random_starts import SMALL
from sjdsl.properties.search import FLOATS, Counterexample, Progress, Search, first_counterexample, simplest_counterexample
from sjdsl.properties.statements import StatementId, leaf_statements, statements_needed_by
from sjdsl.properties.symmetry import TransformedGame, compare_step, transformed_games
from sjdsl.properties.trajectory import Scenario, Trajectory, draws_of, play, up_to
from sjdsl.properties.verdict import Effort, How, Verdict
from sjdsl.trace.rules import Rules

OWN_MAP = "the game's own map"
LONG = 10  # steps of a counterexample, beyond which only the last is told in full


def make_verdict(
    family: GameFamily,
    check: ir.Check,
    passed: bool | None,
    how: How,
    said: str,
    trace: list[str] | None = None,
    scenario: Scenario | None = None,
) -> Verdict:
    """Returns a verdict on a check, with the file and line where it is written."""
    assert check.origin is not None
    return Verdict(family.text_of(check), check.origin.file, check.origin.line, passed, how, said, tuple(trace or ()), scenario=scenario)


def overflow_verdict(family: GameFamily, trajectory: Trajectory, how: How, trace: Sequence[str], scenario: Scenario) -> Verdict:
    """Returns the verdict on a real that leaves float32 at the end of a trajectory; `trace`: the trajectory in words."""
    assert trajectory.left is not None
    node = trajectory.left.node
    file, line = ("", 0) if node.origin is None else (node.origin.file, node.origin.line)
    steps = trajectory.left.before
    said = f"a real leaves float32, which ends at {LARGEST}, " + (f"in step {steps}" if trajectory.worlds else "in phase start")
    told = list(trace) if how == "examples" else [*trace, *describe_overflow(family, trajectory)]
    return Verdict(family.text_of(node), file, line, False, how, said, tuple(told), scenario=scenario)


def statement_lines(family: GameFamily, statements: Collection[StatementId]) -> list[str]:
    """Returns the lines of statements, with their text, in the order of the rules; in which use, if their phase is used several times."""
    rules, leaves = Rules(family.composition.sources), leaf_statements(family.own)
    uses = Counter(leaf.statement_id[1:] for leaf in leaves)
    said = []
    for leaf in leaves:
        if leaf.statement_id in statements:
            use = f"  (in {leaf.statement_id[0]})" if uses[leaf.statement_id[1:]] > 1 else ""
            said.append(f"{rules.place(leaf.statement)}  {rules.text(leaf.statement)}{use}")
    return list(dict.fromkeys(said))


class PlayedVerdicts:
    """Play for all checks together: on small maps, unless rules read rows or columns, and on the game's own map."""

    def __init__(
        self,
        family: GameFamily,
        effort: Effort,
        numbers: list[int],
        expected: Sequence[int] = (),
        progress: Progress = lambda _: None,
    ):
        """`numbers`: checks to find counterexamples to; `expected`: others, for which only coverage matters."""
        self.family, self.numbers, self._effort, self._progress = family, numbers, effort, progress
        self._transformed: dict[tuple[int, int], list[TransformedGame]] = {}
        self._leaves = leaf_statements(family.own)
        checks = family.own.checks
        self._needed = {i: statements_needed_by(checks[i], family.own, self._leaves) for i in (*numbers, *expected)}
        self._on_own_map = family.reads_places and not effort.any_map
        self._search = Search(family, numbers, effort, self._violation, self._needed, self._on_own_map, progress)
        self._found_on_own_map: list[Counterexample] = []
        self._steps = 0

    def play(self) -> None:
        """Plays everything. What has been found is there, too, if this is interrupted."""
        if not self._needed:
            return
        own, checks, search = self.family.own, self.family.own.checks, self._search
        search.run(self._effort.examples)
        is_compiled = self._effort.episodes > 0 and find_spec("jax") is not None
        refuted = {c.number for c in self._found()}
        numbers = [i for i in self.numbers if i not in refuted and checks[i].sort in STATES]
        if is_compiled and (numbers or self._unrefuted_symmetries() or search.missing()):
            self._play_worlds(own, (), numbers)
        search.reach()
        for (agents, sizes), numbers in self._other_numbers().items() if is_compiled else ():
            game = self.family.on(own.rows, agents, sizes)
            if game is not None:
                self._play_worlds(game, sizes, numbers)
        if leads := [c.number for c in self._elsewhere()]:
            numbers = [number for number in leads if number != FLOATS]
            more = Search(self.family, numbers, self._effort, self._violation, {}, True, self._progress)
            try:
                more.run(self._effort.examples // (4 if self._steps else 1))
            finally:
                self._found_on_own_map += more.found

    def _other_numbers(self) -> dict[tuple[int, Sizes], list[int]]:
        """Returns the numbers of agents and the sizes, not the file's, with which checks about states fail on other maps; and which checks."""
        own, found = self.family.own, dict[tuple[int, Sizes], list[int]]()
        for c in self._elsewhere():
            numbers = (c.scenario.agents, c.scenario.sizes)
            if numbers != (own.agents.number, ()) and c.number != FLOATS and own.checks[c.number].sort in STATES:
                found.setdefault(numbers, []).append(c.number)
        return found

    def _unrefuted_symmetries(self) -> list[int]:
        """Returns the checks of symmetry without a counterexample that counts."""
        refuted = {c.number for c in self._found()}
        return [i for i in self.numbers if i not in refuted and self.family.own.checks[i].sort == "symmetric"]

    def _play_worlds(self, game: ir.Game, sizes: Sizes, numbers: Sequence[int]) -> None:
        """Plays the compiled game on its own map for some checks about states, and while statements that checks depend on never ran."""
        from sjdsl.properties.worlds import STEPS, WorldSearch

        worlds, record = WorldSearch(self.family, game, sizes, numbers, self._effort, self._progress), self._search.record

        def is_enough(ran: Collection[StatementId]) -> bool:
            return not self._search.missing() - set(ran) and not self.fail_elsewhere() & set(self._unrefuted_symmetries())

        for number, scenario in worlds.run(is_enough):
            refuted = {c.number for c in self._found()}
            looked_at = self._unrefuted_symmetries() if number is None else [number] if number not in refuted else []
            checks = [game.checks[i] for i in looked_at if i != FLOATS and game.checks[i].sort in STATES]
            trajectory = play(game, scenario, None if looked_at else 0, checks)
            since = 0 if number is not None else max(0, len(trajectory.outcomes) - STEPS)
            for i in looked_at:
                found = first_counterexample(trajectory, i, scenario, self._violation, since)
                if found is not None:
                    self._found_on_own_map.append(simplest_counterexample(self.family, found, self._violation, self._effort))
                    self._search.settle(i)
        self._steps += worlds.steps
        record.ran += worlds.ran
        record.triggers += worlds.triggers

    @property
    def played(self) -> int:
        """How many trajectories were played on the interpreter."""
        return self._search.record.number

    def failed(self) -> dict[int, Verdict]:
        """Returns the verdicts on the checks that have a counterexample that counts."""
        return {c.number: self._verdict(c) for c in self._found() if c.number != FLOATS}

    def fail_elsewhere(self) -> set[int]:
        """Returns the checks with a counterexample that does not count."""
        return {c.number for c in self._elsewhere() if c.number != FLOATS}

    def faults(self) -> list[Verdict]:
        """Returns the verdict on a real that leaves float32 in a trajectory, if one did."""
        return [self._overflow(c) for c in self._found() if c.number == FLOATS]

    def notes(self) -> list[Verdict]:
        """Returns the verdict on a real that leaves float32 on another map only, if one did."""
        return [self._overflow(c) for c in self._elsewhere() if c.number == FLOATS]

    def _found(self) -> list[Counterexample]:
        """Returns the counterexamples that count: those on the game's own map, unless all do."""
        return [c for c in self._search.found if self._counts(c)] + self._found_on_own_map

    def _elsewhere(self) -> list[Counterexample]:
        """Returns the counterexamples that do not count, to checks that have no other."""
        counted = {c.number for c in self._found()}
        return [c for c in self._search.found if c.number not in counted]

    def _counts(self, counterexample: Counterexample) -> bool:
        return self._effort.any_map or self.family.is_own(counterexample.scenario.rows)

    def missing(self, number: int) -> tuple[str, ...]:
        """Returns the lines that a check depends on and that never ran, with their text, in the order of the rules."""
        record, rules = self._search.record, Rules(self.family.composition.sources)
        said = statement_lines(self.family, self._needed[number] - set(record.ran))
        check = self.family.own.checks[number]
        if check.sort == "once" and not record.triggers[number]:
            said.append(f"{rules.place(check)}  the first condition never held: {rules.text(check.values[0])}")
        return tuple(said)

    def passed(self, number: int) -> Verdict:
        """Returns the verdict on a check without a counterexample that counts."""
        check, record = self.family.own.checks[number], self._search.record
        said = f"{record.number - record.refused} trajectories on {OWN_MAP if self._on_own_map else 'small maps'}"
        if check.sort in STATES and self._steps:
            said += f", {self._steps:,} steps on {OWN_MAP}"
        if check.sort == "once":
            times = record.triggers[number]
            said += f"; its first condition came to hold {times:,} times" if times else "; its first condition never held"
        note = next((self._verdict(c) for c in self._elsewhere() if c.number == number), None)
        return replace(make_verdict(self.family, check, True, "examples", said), untested=self.missing(number), note=note)

    def idle(self) -> tuple[int, ...]:
        """Returns the lines of statements that change something and never ran; none where nothing was played."""
        if not self._search.record.number:
            return ()
        ran = set(self._search.record.ran)
        idle = [leaf.statement.origin for leaf in self._leaves if leaf.statement_id not in ran]
        return tuple(sorted({origin.line for origin in idle if origin is not None}))

    def _overflow(self, c: Counterexample) -> Verdict:
        return overflow_verdict(self.family, c.trajectory, "examples", self._described(c), up_to(c.scenario, c.where.at))

    def _described(self, counterexample: Counterexample) -> list[str]:
        """Returns a counterexample in words: each step in full, or of a long one, or one on a large map, only the last."""
        rows = counterexample.scenario.rows
        brief = len(rows) * len(rows[0]) > SMALL or counterexample.where.at > LONG
        return describe_counterexample(self.family, counterexample, brief)

    def _verdict(self, counterexample: Counterexample) -> Verdict:
        check = self.family.own.checks[counterexample.number]
        said = f"fails after step {counterexample.where.at - 1}" if counterexample.where.at else "fails at the start"
        trace = self._described(counterexample)
        if check.sort == "symmetric":
            trace += describe_asymmetry(
                self._differing(check, counterexample.trajectory, counterexample.scenario, counterexample.where.at - 1)
            )
        return make_verdict(self.family, check, False, "examples", said, trace, up_to(counterexample.scenario, counterexample.where.at))

    def _violation(self, check: ir.Check, trajectory: Trajectory, scenario: Scenario, since: int) -> Violation | None:
        if check.sort != "symmetric":
            return find_violation(check, trajectory.values(check))
        steps = range(since, len(trajectory.outcomes))
        return next((Violation(t + 1) for t in steps if self._differing(check, trajectory, scenario, t)), None)

    def _differing(self, check: ir.Check, trajectory: Trajectory, scenario: Scenario, at: int) -> tuple[str, list[str]] | None:
        """Returns what differs in a step under the changed rules of a symmetry."""
        key = (id(trajectory.game), id(check))
        if key not in self._transformed:
            self._transformed[key] = transformed_games(check, trajectory.game)
        for other in self._transformed[key]:
            draws = draws_of(scenario, at)
            found = compare_step(trajectory.game, other, trajectory.worlds[at], trajectory.actions[at], trajectory.params, draws)
            if found:
                return other.said, found
        return None
