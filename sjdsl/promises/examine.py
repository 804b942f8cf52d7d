"""Puts every promise of a game to the test: decided or proved if that can be, else played."""

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property

from sjdsl.compiler import ir
from sjdsl.compiler.lower.context import NotSupported
from sjdsl.promises.bounds import least_share, mean_and_half
from sjdsl.promises.course import Course, Played, words_of
from sjdsl.promises.engines import Episode, Stretch
from sjdsl.promises.far import tell_episode
from sjdsl.promises.ground import Ground
from sjdsl.promises.ranges import decide
from sjdsl.promises.search import Broken, Tried, search
from sjdsl.promises.slopes import decide_monotone
from sjdsl.promises.story import tell_course, tell_symmetry
from sjdsl.promises.symmetry import Turned, compare_step, lonely_action, reason, turned
from sjdsl.promises.touches import is_untouched
from sjdsl.promises.verdict import Effort, How, Verdict
from sjdsl.promises.watch import STATES, Break, find_break
from sjdsl.promises.ways import TooLarge

RANDOM = (ir.Policy(name="random"),)


@dataclass(frozen=True)
class Report:
    """The verdicts of a game's promises in the order written, and the lines whose sentences never took place in the courses played."""

    verdicts: tuple[Verdict, ...]
    courses: int
    idle: tuple[int, ...] = ()


class Examination:
    """The promises of one game, put to the test as far as they are asked for; what serves several is played once."""

    def __init__(self, ground: Ground, effort: Effort | None = None, only: Collection[int] | None = None):
        """`only`: places of promises among the game's checks; None: all."""
        self.ground, self.effort = ground, effort or Effort()
        checks = ground.own.checks
        self.numbers = [i for i in range(len(checks)) if only is None or i in only]
        self._settled = {i: verdict for i in self.numbers if (verdict := settle(ground, i)) is not None}
        self._played = [i for i in self.numbers if i not in self._settled and checks[i].sort != "expect"]

    def verdict(self, number: int) -> Verdict:
        """Returns what becomes of a promise. Raises CompileError for a game that cannot be compiled exactly."""
        if number in self._settled:
            return self._settled[number]
        if number in self._played:
            return self._verdicts[number]
        return expect(self.ground, self._stretch, number)

    @cached_property
    def courses(self) -> "Courses":
        return Courses(self.ground, self.effort, self._played)

    @cached_property
    def _stretch(self) -> Stretch:
        return Stretch(self.ground, self.effort.seed)

    @cached_property
    def _verdicts(self) -> dict[int, Verdict]:
        """The verdicts on the promises about every course of play."""
        checks, found = self.ground.own.checks, self.courses.broken()
        left = [i for i in self._played if i not in found and checks[i].sort in STATES]
        found |= in_episodes(self.ground, self._stretch, self.effort, left)
        return {i: self.courses.kept(i) for i in self._played} | found


def examine(ground: Ground, effort: Effort | None = None, only: Collection[int] | None = None) -> Report:
    """Returns what becomes of a game's promises. Raises CompileError for a game that cannot be compiled exactly."""
    examination = Examination(ground, effort, only)
    verdicts = tuple(examination.verdict(i) for i in examination.numbers)
    return Report(verdicts, examination.courses.tried.played, examination.courses.idle())


def settle(ground: Ground, number: int) -> Verdict | None:
    """Returns the verdict on a promise that needs no playing; None if it does."""
    game, check = ground.own, ground.own.checks[number]
    match check.sort:
        case "require":
            return make_verdict(ground, check, True, "decided", "it holds for the file's numbers; others are asked when they are set")
        case "symmetric" if lonely_action(check, game):
            return make_verdict(ground, check, False, "decided", lonely_action(check, game))
        case "symmetric" if not turned(check, game):
            return make_verdict(ground, check, True, "proved", reason(check, game))
        case "always" | "once" if all(decide(wider.checks[number].values[-1]) for wider in (game, ground.doubled)):
            return make_verdict(ground, check, True, "proved", "the ranges of what it reads leave nothing else")
        case "conserved" if is_untouched(check.values[0], game):
            return make_verdict(ground, check, True, "proved", "no rule writes anything that it reads")
        case "monotone" if decide_monotone(check, game):
            return make_verdict(ground, check, True, "proved", "every operation between the two goes one way")
        case _:
            return None


def make_verdict(ground: Ground, check: ir.Check, kept: bool | None, how: How, said: str, trace: list[str] | None = None) -> Verdict:
    """Returns a verdict on a promise where it is written."""
    assert check.origin is not None
    return Verdict(ground.text_of(check), check.origin.file, check.origin.line, kept, how, said, tuple(trace or ()))


class Courses:
    """Random courses on small maps, played for all promises together."""

    def __init__(self, ground: Ground, effort: Effort, promises: list[int]):
        self.ground, self.promises, self._effort = ground, promises, effort
        self._turned: dict[tuple[int, int], list[Turned]] = {}
        self._found, self.tried = search(ground, promises, effort, self._breaks) if promises else ([], Tried())

    def broken(self) -> dict[int, Verdict]:
        """Returns the verdicts on the promises that a course breaks."""
        return {broken.promise: self._verdict(broken) for broken in self._found}

    def kept(self, number: int) -> Verdict:
        """Returns the verdict on a promise that no course breaks."""
        check, played = self.ground.own.checks[number], self.tried.played - self.tried.refused
        said = f"{played} courses on small maps"
        if check.sort in STATES and self._effort.episodes:
            said += f", {self._effort.episodes} episodes of random play"
        if check.sort == "once":
            came = self.tried.triggers[number]
            said += f"; the first condition came in {came} of the courses" if came else "; its first condition never came in the courses"
        return make_verdict(self.ground, check, True, "examples", said)

    def idle(self) -> tuple[int, ...]:
        """Returns the lines of sentences that change something and never took place; none if all promises broke, before many were played."""
        if len(self._found) == len(self.promises):
            return ()
        took_place = {feature[0] for feature in self.tried.happened if isinstance(feature, tuple) and feature[1:] == (-1,)}
        writing = (ir.Set, ir.Add, ir.Give, ir.Tally, ir.Send, ir.Remove, ir.End)
        found = {
            n.origin.line
            for turn in self.ground.own.schedule
            for n in ir.walk(turn)
            if isinstance(n, writing) and n.origin is not None and n.origin.start not in took_place
        }
        return tuple(sorted(found))

    def _verdict(self, broken: Broken) -> Verdict:
        check = self.ground.own.checks[broken.promise]
        said = f"broken after step {broken.where.at - 1}" if broken.where.at else "broken at the start"
        trace = tell_course(self.ground, broken)
        if check.sort == "symmetric":
            trace += tell_symmetry(self._differing(check, broken.played, broken.course, broken.where.at - 1))
        return make_verdict(self.ground, check, False, "examples", said, trace)

    def _breaks(self, check: ir.Check, played: Played, course: Course) -> Break | None:
        if check.sort != "symmetric":
            return find_break(check, played.values(check))
        steps = range(len(played.actions))
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


def in_episodes(ground: Ground, stretch: Stretch, effort: Effort, promises: list[int]) -> dict[int, Verdict]:
    """Returns the verdicts on the promises about states that whole episodes on the game's own map break."""
    if not promises or not effort.episodes:
        return {}
    found: dict[int, Verdict] = {}
    for episode in stretch.play(RANDOM, 0, effort.episodes):
        for number in promises:
            where = find_break(ground.own.checks[number], episode.values[number])
            if where is not None and number not in found:
                said = f"broken after step {where.at - 1} of an episode of random play"
                trace = tell_episode(ground, stretch, episode, RANDOM, number, where)
                found[number] = make_verdict(ground, ground.own.checks[number], False, "episodes", said, trace)
    return found


def expect(ground: Ground, stretch: Stretch, number: int) -> Verdict:
    """Returns the verdict on an `expect`: its condition must hold at the end of every one of its episodes."""
    check = ground.own.checks[number]
    try:
        episodes = stretch.play(check.policies, 0, check.episodes)
    except (NotSupported, TooLarge) as error:
        return make_verdict(ground, check, None, "not decided", f"the compiled game cannot play this yet: {error}")
    missed = [e for e in episodes if not e.values[number][-1][0]]
    figures = _figures(check, episodes, ground.own)
    if not missed:
        share = (
            f"{len(episodes)} of {len(episodes)} episodes (of all at least {100 * least_share(len(episodes)):.1f}%, with 95% confidence)"
        )
        return make_verdict(ground, check, True, "episodes", "; ".join([share, *figures]))
    said = "; ".join([f"{len(episodes) - len(missed)} of {len(episodes)} episodes", *figures])
    values = [value for (value,) in missed[0].values[number]]
    held = [t for t, value in enumerate(values) if value]
    where = Break(max(held) + 1) if held else Break(len(values) - 1)
    return make_verdict(ground, check, False, "episodes", said, tell_episode(ground, stretch, missed[0], check.policies, number, where))


def _figures(check: ir.Check, episodes: list[Episode], game: ir.Game) -> list[str]:
    """Returns the means of the events that a promise speaks of, with half of their 95% intervals."""
    found = []
    for total in dict.fromkeys((n.name, n.word) for n in ir.walk(check) if isinstance(n, ir.EventTotal)):
        name, word = total
        words = [word] if word else next(e.by for e in game.events if e.name == name) or [None]
        mean, half = mean_and_half([float(sum(e.totals[name, w] for w in words)) for e in episodes])
        found.append(f"{name}{f'[{word}]' if word else ''} {mean:.4g} ± {half:.2g}")
    return found
