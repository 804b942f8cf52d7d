"""What courses on small maps tell of promises: which break, which are kept, and which lines nothing was seen of."""

from collections.abc import Sequence
from dataclasses import replace

from sjdsl.compiler import ir
from sjdsl.properties.counterexample import tell_course, tell_symmetry
from sjdsl.properties.float_overflow import LARGEST, tell_overflow
from sjdsl.properties.instances import Ground
from sjdsl.properties.monitors import STATES, Break, find_break
from sjdsl.properties.search import FLOATS, Broken, Tried, search
from sjdsl.properties.statements import Place, leaves_of, needed_by
from sjdsl.properties.symmetry import Turned, compare_step, turned
from sjdsl.properties.trajectory import Course, Played, words_of
from sjdsl.properties.verdict import Effort, How, Verdict
from sjdsl.trace.rules import Rules


def make_verdict(ground: Ground, check: ir.Check, kept: bool | None, how: How, said: str, trace: list[str] | None = None) -> Verdict:
    """Returns a verdict on a promise where it is written."""
    assert check.origin is not None
    return Verdict(ground.text_of(check), check.origin.file, check.origin.line, kept, how, said, tuple(trace or ()))


def overflow_verdict(ground: Ground, played: Played, how: How, trace: Sequence[str]) -> Verdict:
    """Returns the verdict on a real that leaves float32 at the end of a course; `trace`: how it got there."""
    assert played.left is not None
    node = played.left.node
    file, line = ("", 0) if node.origin is None else (node.origin.file, node.origin.line)
    steps = played.left.before
    said = f"a real leaves float32, which ends at {LARGEST}, " + (f"in step {steps}" if played.worlds else "in phase start")
    told = list(trace) if how == "examples" else [*trace, *tell_overflow(ground, played)]
    return Verdict(ground.text_of(node), file, line, False, how, said, tuple(told))


class Courses:
    """Random courses on small maps, played for all promises together."""

    def __init__(self, ground: Ground, effort: Effort, promises: list[int], expected: Sequence[int] = ()):
        """`promises`: those to be broken by a course; `expected`: others, for which it only matters which lines ran."""
        self.ground, self.promises, self._effort = ground, promises, effort
        self._turned: dict[tuple[int, int], list[Turned]] = {}
        self._leaves = leaves_of(ground.own)
        checks = ground.own.checks
        self._needed = {i: needed_by(checks[i], ground.own, self._leaves) for i in (*promises, *expected)}
        self._found, self.tried = search(ground, promises, effort, self._breaks, self._needed) if self._needed else ([], Tried())

    def broken(self) -> dict[int, Verdict]:
        """Returns the verdicts on the promises that a course breaks."""
        return {broken.promise: self._verdict(broken) for broken in self._found if broken.promise != FLOATS}

    def faults(self) -> list[Verdict]:
        """Returns the verdict on a real that leaves float32 in a course, if one did."""
        found = (broken for broken in self._found if broken.promise == FLOATS)
        return [overflow_verdict(self.ground, b.played, "examples", tell_course(self.ground, b)) for b in found]

    def missing(self, number: int) -> tuple[str, ...]:
        """Returns the lines that a promise depends on and that never ran in a course, with what stands there, in the order of the rules."""
        needed, rules = self._needed[number], Rules(self.ground.composition.sources)
        never = [leaf for leaf in self._leaves if leaf.place in needed and not self.tried.ran[leaf.place]]
        said = [f"{rules.place(leaf.sentence)}  {rules.text(leaf.sentence)}{self._use(leaf.place)}" for leaf in never]
        check = self.ground.own.checks[number]
        if check.sort == "once" and not self.tried.triggers[number]:
            said.append(f"{rules.place(check)}  the first condition never held: {rules.text(check.values[0])}")
        return tuple(dict.fromkeys(said))

    def kept(self, number: int) -> Verdict:
        """Returns the verdict on a promise that no course breaks."""
        check, played = self.ground.own.checks[number], self.tried.played - self.tried.refused
        said = f"{played} courses on small maps"
        if check.sort in STATES and self._effort.episodes:
            said += f", {self._effort.episodes} episodes of random play"
        if check.sort == "once":
            came = self.tried.triggers[number]
            said += f"; its first condition held in {came} of the courses" if came else "; its first condition never held in the courses"
        return replace(make_verdict(self.ground, check, True, "examples", said), untested=self.missing(number))

    def idle(self) -> tuple[int, ...]:
        """Returns the lines of sentences that change something and never took place; none where no courses were played."""
        if not self.tried.played:
            return ()
        lines = {leaf.sentence.origin.line for leaf in self._leaves if leaf.sentence.origin is not None and not self.tried.ran[leaf.place]}
        return tuple(sorted(lines))

    def _use(self, place: Place) -> str:
        """Returns in which use of a phase a sentence stands, if its phase is used several times."""
        return f"  (in {place[0]})" if sum(leaf.place[1:] == place[1:] for leaf in self._leaves) > 1 else ""

    def _verdict(self, broken: Broken) -> Verdict:
        check = self.ground.own.checks[broken.promise]
        said = f"broken after step {broken.where.at - 1}" if broken.where.at else "broken at the start"
        trace = tell_course(self.ground, broken)
        if check.sort == "symmetric":
            trace += tell_symmetry(self._differing(check, broken.played, broken.course, broken.where.at - 1))
        return make_verdict(self.ground, check, False, "examples", said, trace)

    def _breaks(self, check: ir.Check, played: Played, course: Course, since: int) -> Break | None:
        if check.sort != "symmetric":
            return find_break(check, played.values(check))
        steps = range(since, len(played.outcomes))
        return next((Break(t + 1) for t in steps if self._differing(check, played, course, t)), None)

    def _differing(self, check: ir.Check, played: Played, course: Course, at: int) -> tuple[str, list[str]] | None:
        """Returns what differs in a step under the turned rules of a symmetry."""
        key = (id(played.game), id(check))
        if key not in self._turned:
            self._turned[key] = turned(check, played.game)
        for other in self._turned[key]:
            words = words_of(course, at)
            found = compare_step(played.game, other.game, played.worlds[at], played.actions[at], played.params, words)
            if found:
                return other.said, found
        return None
