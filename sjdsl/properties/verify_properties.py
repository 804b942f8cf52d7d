"""Puts every promise of a game to the test: decided or proved if that can be, else played."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from sjdsl.compiler import ir
from sjdsl.compiler.lower.scope import NotSupported
from sjdsl.properties.confidence import least_share, mean_and_half
from sjdsl.properties.effects import is_untouched
from sjdsl.properties.engines import Episode, Stretch
from sjdsl.properties.episode_counterexample import names_of, tell_episode
from sjdsl.properties.instances import Ground
from sjdsl.properties.intervals import decide
from sjdsl.properties.monitors import STATES, Break, find_break
from sjdsl.properties.monotonicity import decide_monotone
from sjdsl.properties.shortest_paths import TooLarge
from sjdsl.properties.symmetry import lonely_action, reason, turned
from sjdsl.properties.trajectories import Courses, make_verdict, overflow_verdict
from sjdsl.properties.verdict import Effort, Verdict

RANDOM = (ir.Policy(name="random"),)


@dataclass(frozen=True)
class Report:
    """The verdicts of a game's promises in the order written, and the lines whose sentences never took place in the courses played.

    faults: what is wrong whatever was promised: a real that leaves float32.
    """

    verdicts: tuple[Verdict, ...]
    courses: int
    idle: tuple[int, ...] = ()
    faults: tuple[Verdict, ...] = ()


class Examination:
    """The promises of one game, put to the test as far as they are asked for; what serves several is played once."""

    def __init__(self, ground: Ground, effort: Effort | None = None, only: Collection[int] | None = None):
        """`only`: places of promises among the game's checks; None: all."""
        self.ground, self.effort = ground, effort or Effort()
        checks = ground.own.checks
        self.numbers = [i for i in range(len(checks)) if only is None or i in only]
        self._faults: list[Verdict] = []
        self._settled = {i: verdict for i in self.numbers if (verdict := settle(ground, i)) is not None}
        self._played = [i for i in self.numbers if i not in self._settled and checks[i].sort != "expect"]
        self._expected = [i for i in self.numbers if i not in self._settled and checks[i].sort == "expect"]

    def verdict(self, number: int) -> Verdict:
        """Returns what becomes of a promise. Raises CompileError for a game that cannot be compiled exactly."""
        if number in self._settled:
            return self._settled[number]
        if number in self._played:
            return self._verdicts[number]
        verdict, fault = expect(self.ground, self._stretch, number)
        self._faults += fault
        return replace(verdict, untested=self.courses.missing(number)) if verdict.kept else verdict

    @property
    def faults(self) -> tuple[Verdict, ...]:
        """What is wrong whatever was promised, as far as it came up; at most one."""
        return tuple([*(self.courses.faults() if self.has_played else ()), *self._faults][:1])

    @property
    def has_played(self) -> bool:
        """Whether courses were played: what is settled, and an `expect` that its episodes break, need none."""
        return "courses" in vars(self)

    @cached_property
    def courses(self) -> Courses:
        return Courses(self.ground, self.effort, self._played, self._expected)

    @cached_property
    def _stretch(self) -> Stretch:
        return Stretch(self.ground, self.effort.seed)

    @cached_property
    def _verdicts(self) -> dict[int, Verdict]:
        """The verdicts on the promises about every course of play."""
        checks, found = self.ground.own.checks, self.courses.broken()
        left = [i for i in self._played if i not in found and checks[i].sort in STATES]
        in_long, fault = in_episodes(self.ground, self._stretch, self.effort, left)
        self._faults += fault
        return {i: self.courses.kept(i) for i in self._played} | found | in_long


def examine(ground: Ground, effort: Effort | None = None, only: Collection[int] | None = None) -> Report:
    """Returns what becomes of a game's promises. Raises CompileError for a game that cannot be compiled exactly."""
    examination = Examination(ground, effort, only)
    verdicts = tuple(examination.verdict(i) for i in examination.numbers)
    played, idle = (examination.courses.tried.played, examination.courses.idle()) if examination.has_played else (0, ())
    return Report(verdicts, played, idle, examination.faults)


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


def in_episodes(ground: Ground, stretch: Stretch, effort: Effort, promises: list[int]) -> tuple[dict[int, Verdict], list[Verdict]]:
    """Returns the verdicts on the promises about states that whole episodes on the game's own map break, and what else is wrong in them."""
    if not promises or not effort.episodes:
        return {}, []
    found: dict[int, Verdict] = {}
    episodes = stretch.play(RANDOM, 0, effort.episodes)
    for episode in episodes:
        for number in promises:
            where = find_break(ground.own.checks[number], episode.values[number])
            if where is not None and number not in found:
                said = f"broken after step {where.at - 1} of an episode of random play"
                trace = tell_episode(ground, stretch, episode, RANDOM, number, where)
                found[number] = make_verdict(ground, ground.own.checks[number], False, "episodes", said, trace)
    return found, _overflow(ground, stretch, episodes, RANDOM)


def _overflow(ground: Ground, stretch: Stretch, episodes: Sequence[Episode], policies: Sequence[ir.Policy]) -> list[Verdict]:
    """Returns the verdict on the first episode in which a real leaves float32, if any."""
    episode = next((e for e in episodes if e.left is not None), None)
    if episode is None:
        return []
    opening = f"episode {episode.number} on the game's own map, the agents in turn: {names_of(ground, policies)}"
    return [overflow_verdict(ground, stretch.overflow(episode, policies), "episodes", [opening])]


def expect(ground: Ground, stretch: Stretch, number: int) -> tuple[Verdict, list[Verdict]]:
    """Returns the verdict on an `expect`: its condition must hold at the end of every one of its episodes; and what else is wrong in them."""
    check = ground.own.checks[number]
    try:
        episodes = stretch.play(check.policies, 0, check.episodes)
    except (NotSupported, TooLarge) as error:
        return make_verdict(ground, check, None, "not decided", f"the compiled game cannot play this yet: {error}"), []
    fault = _overflow(ground, stretch, episodes, check.policies)
    if fault:
        return make_verdict(ground, check, None, "not decided", "its episodes cannot be judged: a real leaves float32"), fault
    missed = [e for e in episodes if not e.values[number][-1][0]]
    figures = _figures(check, episodes, ground.own)
    if not missed:
        share = (
            f"{len(episodes)} of {len(episodes)} episodes (of all at least {100 * least_share(len(episodes)):.1f}%, with 95% confidence)"
        )
        return make_verdict(ground, check, True, "episodes", "; ".join([share, *figures])), []
    said = "; ".join([f"{len(episodes) - len(missed)} of {len(episodes)} episodes", *figures])
    values = [value for (value,) in missed[0].values[number]]
    held = [t for t, value in enumerate(values) if value]
    where = Break(max(held) + 1) if held else Break(len(values) - 1)
    trace = tell_episode(ground, stretch, missed[0], check.policies, number, where)
    return make_verdict(ground, check, False, "episodes", said, trace), []


def _figures(check: ir.Check, episodes: list[Episode], game: ir.Game) -> list[str]:
    """Returns the means of the events that a promise speaks of, with half of their 95% intervals."""
    found = []
    for total in dict.fromkeys((n.name, n.word) for n in ir.walk(check) if isinstance(n, ir.EventTotal)):
        name, word = total
        words = [word] if word else next(e.by for e in game.events if e.name == name) or [None]
        mean, half = mean_and_half([float(sum(e.totals[name, w] for w in words)) for e in episodes])
        found.append(f"{name}{f'[{word}]' if word else ''} {mean:.4g} ± {half:.2g}")
    return found
