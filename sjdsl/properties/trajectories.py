"""Verdicts from trajectories on small maps: which checks fail, which pass, and which statements never ran."""

from collections.abc import Sequence
from dataclasses import replace

from sjdsl.compiler import ir
from sjdsl.properties.counterexample import describe_asymmetry, describe_counterexample
from sjdsl.properties.float_overflow import LARGEST, describe_overflow
from sjdsl.properties.instances import GameFamily
from sjdsl.properties.monitors import STATES, Violation, find_violation
from sjdsl.properties.search import FLOATS, Counterexample, SearchRecord, search
from sjdsl.properties.statements import StatementId, leaf_statements, statements_needed_by
from sjdsl.properties.symmetry import TransformedGame, compare_step, transformed_games
from sjdsl.properties.trajectory import Scenario, Trajectory, draws_of, up_to
from sjdsl.properties.verdict import Effort, How, Verdict
from sjdsl.trace.rules import Rules


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


class SmallMapVerdicts:
    """Random trajectories on small maps, played for all checks together."""

    def __init__(self, family: GameFamily, effort: Effort, numbers: list[int], expected: Sequence[int] = ()):
        """`numbers`: checks to find counterexamples to; `expected`: others, for which only coverage matters."""
        self.family, self.numbers, self._effort = family, numbers, effort
        self._transformed: dict[tuple[int, int], list[TransformedGame]] = {}
        self._leaves = leaf_statements(family.own)
        checks = family.own.checks
        self._needed = {i: statements_needed_by(checks[i], family.own, self._leaves) for i in (*numbers, *expected)}
        self._found, self.record = search(family, numbers, effort, self._violation, self._needed) if self._needed else ([], SearchRecord())

    def failed(self) -> dict[int, Verdict]:
        """Returns the verdicts on the checks that have a counterexample."""
        return {counterexample.number: self._verdict(counterexample) for counterexample in self._found if counterexample.number != FLOATS}

    def faults(self) -> list[Verdict]:
        """Returns the verdict on a real that leaves float32 in a trajectory, if one did."""
        found = (counterexample for counterexample in self._found if counterexample.number == FLOATS)
        return [
            overflow_verdict(self.family, b.trajectory, "examples", describe_counterexample(self.family, b), up_to(b.scenario, b.where.at))
            for b in found
        ]

    def missing(self, number: int) -> tuple[str, ...]:
        """Returns the lines that a check depends on and that never ran, with their text, in the order of the rules."""
        needed, rules = self._needed[number], Rules(self.family.composition.sources)
        never = [leaf for leaf in self._leaves if leaf.statement_id in needed and not self.record.ran[leaf.statement_id]]
        said = [f"{rules.place(leaf.statement)}  {rules.text(leaf.statement)}{self._use(leaf.statement_id)}" for leaf in never]
        check = self.family.own.checks[number]
        if check.sort == "once" and not self.record.triggers[number]:
            said.append(f"{rules.place(check)}  the first condition never held: {rules.text(check.values[0])}")
        return tuple(dict.fromkeys(said))

    def passed(self, number: int) -> Verdict:
        """Returns the verdict on a check without a counterexample."""
        check, played = self.family.own.checks[number], self.record.number - self.record.refused
        said = f"{played} trajectories on small maps"
        if check.sort in STATES and self._effort.episodes:
            said += f", {self._effort.episodes} episodes of random play"
        if check.sort == "once":
            came = self.record.triggers[number]
            said += (
                f"; its first condition held in {came} of the trajectories"
                if came
                else "; its first condition never held in the trajectories"
            )
        return replace(make_verdict(self.family, check, True, "examples", said), untested=self.missing(number))

    def idle(self) -> tuple[int, ...]:
        """Returns the lines of statements that change something and never ran; none where nothing was played."""
        if not self.record.number:
            return ()
        lines = {
            leaf.statement.origin.line
            for leaf in self._leaves
            if leaf.statement.origin is not None and not self.record.ran[leaf.statement_id]
        }
        return tuple(sorted(lines))

    def _use(self, statement: StatementId) -> str:
        """Returns in which use of a phase a statement stands, if its phase is used several times."""
        return f"  (in {statement[0]})" if sum(leaf.statement_id[1:] == statement[1:] for leaf in self._leaves) > 1 else ""

    def _verdict(self, counterexample: Counterexample) -> Verdict:
        check = self.family.own.checks[counterexample.number]
        said = f"fails after step {counterexample.where.at - 1}" if counterexample.where.at else "fails at the start"
        trace = describe_counterexample(self.family, counterexample)
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
