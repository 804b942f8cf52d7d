"""Verdicts from random trajectories: which checks fail, which pass, and which statements never ran.

What small maps refute is looked for on the game's own map. Only what fails there fails; the rest is a note.
"""

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import replace

from sjdsl.compiler import ir
from sjdsl.properties.counterexample import describe_asymmetry, describe_counterexample
from sjdsl.properties.episode_counterexample import describe_briefly
from sjdsl.properties.float_overflow import LARGEST, describe_overflow
from sjdsl.properties.instances import GameFamily
from sjdsl.properties.monitors import STATES, Violation, find_violation
from sjdsl.properties.own_map import OwnMapSearch
from sjdsl.properties.random_starts import SMALL
from sjdsl.properties.search import FLOATS, Counterexample, Progress, Search, SearchRecord
from sjdsl.properties.statements import StatementId, leaf_statements, statements_needed_by
from sjdsl.properties.symmetry import TransformedGame, compare_step, transformed_games
from sjdsl.properties.trajectory import Scenario, Trajectory, draws_of, up_to
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
    """Random trajectories, played for all checks together: on small maps, or on the own map alone where rules read rows or columns."""

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
        on_own_map = family.reads_places and not effort.any_map
        self._search = Search(family, numbers, effort, self._violation, self._needed, on_own_map, progress)
        self._on_own_map: OwnMapSearch | None = None

    def play(self) -> None:
        """Plays all trajectories. What has been found is there, too, if this is interrupted."""
        if self._needed:
            self._search.run()
        if leads := self._elsewhere():
            needed = {lead.number: self._needed[lead.number] for lead in leads if lead.number != FLOATS}
            self._on_own_map = OwnMapSearch(self.family, leads, self._effort, self._violation, needed, self._progress)
            self._on_own_map.run()

    @property
    def played(self) -> int:
        """How many trajectories were played."""
        return self._search.record.number + (0 if self._on_own_map is None else self._on_own_map.record.number)

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
        return [] if self.faults() else [self._overflow(c) for c in self._elsewhere() if c.number == FLOATS]

    def _found(self) -> list[Counterexample]:
        """Returns the counterexamples that count: those on the game's own map, unless all do."""
        found = [c for c in self._search.found if self._counts(c)]
        return found + ([] if self._on_own_map is None else self._on_own_map.found)

    def _elsewhere(self) -> list[Counterexample]:
        return [c for c in self._search.found if not self._counts(c)]

    def _counts(self, counterexample: Counterexample) -> bool:
        return self._effort.any_map or self.family.is_own(counterexample.scenario.rows)

    def missing(self, number: int) -> tuple[str, ...]:
        """Returns the lines that a check depends on and that never ran, with their text, in the order of the rules.

        Of a check that fails on another map: that never ran on the game's own.
        """
        record, rules = self._record(number), Rules(self.family.composition.sources)
        said = statement_lines(self.family, self._needed[number] - set(record.ran))
        check = self.family.own.checks[number]
        if check.sort == "once" and not record.triggers[number]:
            said.append(f"{rules.place(check)}  the first condition never held: {rules.text(check.values[0])}")
        return tuple(said)

    def passed(self, number: int) -> Verdict:
        """Returns the verdict on a check without a counterexample that counts."""
        check, record, note = self.family.own.checks[number], self._record(number), self._note(number)
        on_own_map = note is not None or (self.family.reads_places and not self._effort.any_map)
        said = f"{record.number - record.refused} trajectories on {OWN_MAP if on_own_map else 'small maps'}"
        if check.sort in STATES and self._effort.episodes:
            said += f", {self._effort.episodes} episodes of random play"
        if check.sort == "once":
            came = record.triggers[number]
            said += (
                f"; its first condition held in {came} of the trajectories"
                if came
                else "; its first condition never held in the trajectories"
            )
        return replace(make_verdict(self.family, check, True, "examples", said), untested=self.missing(number), note=note)

    def _note(self, number: int) -> Verdict | None:
        return next((self._verdict(c) for c in self._elsewhere() if c.number == number), None)

    def _record(self, number: int) -> SearchRecord:
        """Returns the trajectories from which the verdict on a check comes."""
        elsewhere = any(c.number == number for c in self._elsewhere())
        return self._on_own_map.record if elsewhere and self._on_own_map is not None else self._search.record

    def idle(self) -> tuple[int, ...]:
        """Returns the lines of statements that change something and never ran; none where nothing was played."""
        if not self._search.record.number:
            return ()
        ran = set(self._search.record.ran) | (set() if self._on_own_map is None else set(self._on_own_map.record.ran))
        lines = {leaf.statement.origin.line for leaf in self._leaves if leaf.statement.origin is not None and leaf.statement_id not in ran}
        return tuple(sorted(lines))

    def _overflow(self, c: Counterexample) -> Verdict:
        return overflow_verdict(self.family, c.trajectory, "examples", self._described(c), up_to(c.scenario, c.where.at))

    def _described(self, counterexample: Counterexample) -> list[str]:
        """Returns a counterexample in words: each step in full, or of a long one, or one on a large map, only the last."""
        rows = counterexample.scenario.rows
        brief = len(rows) * len(rows[0]) > SMALL or counterexample.where.at > LONG
        return (describe_briefly if brief else describe_counterexample)(self.family, counterexample)

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
