"""Verifies every check of a game: decides or proves it statically if possible, and otherwise tests it by play."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import counts_of, event_named
from sjdsl.compiler.lower.scope import NotSupported
from sjdsl.properties.confidence import least_share, mean_and_half
from sjdsl.properties.counterexample import describe_episode, names_of
from sjdsl.properties.effects import is_untouched
from sjdsl.properties.engines import Episode, EpisodeRunner
from sjdsl.properties.instances import GameFamily
from sjdsl.properties.intervals import decide
from sjdsl.properties.monitors import Violation
from sjdsl.properties.monotonicity import decide_monotone
from sjdsl.properties.scripted_policies import TooLarge
from sjdsl.properties.search import Progress
from sjdsl.properties.sizes import in_all_sizes
from sjdsl.properties.symmetry import names_agents, one_sided_action, order_of_sending, tells_apart, why_symmetric
from sjdsl.properties.trajectories import PlayedVerdicts, make_verdict, overflow_verdict, statement_lines
from sjdsl.properties.verdict import Effort, Verdict


@dataclass(frozen=True)
class Report:
    """The verdicts on a game's checks in the order written, and the lines of statements that never ran in any trajectory.

    faults: what is wrong whatever the checks say: a real that leaves float32; notes: the same, on another map than the game's own.
    """

    verdicts: tuple[Verdict, ...]
    trajectories: int
    idle: tuple[int, ...] = ()
    faults: tuple[Verdict, ...] = ()
    notes: tuple[Verdict, ...] = ()


class Verification:
    """The verification of one game's checks, each done when it is asked for; play that serves several checks is done once."""

    def __init__(
        self,
        family: GameFamily,
        effort: Effort | None = None,
        only: Collection[int] | None = None,
        progress: Progress = lambda _: None,
    ):
        """`only`: indices among the game's checks; None: all. `progress`: is told how far the play is, a few hundred times."""
        self.family, self.effort, self._progress = family, effort or Effort(), progress
        checks = family.own.checks
        self.numbers = [i for i in range(len(checks)) if only is None or i in only]
        self._faults: list[Verdict] = []
        self._static = {i: verdict for i in self.numbers if (verdict := decide_statically(family, i)) is not None}
        self._played = [i for i in self.numbers if i not in self._static and checks[i].sort != "expect"]
        self._expectations = dict[int, Verdict]()
        self._expected = [i for i in self.numbers if i not in self._static and checks[i].sort == "expect"]

    def verdict(self, number: int) -> Verdict:
        """Returns the verdict on a check. Raises CompileError for a game that cannot be compiled exactly."""
        if number in self._static:
            return self._static[number]
        if number in self._played:
            return self._verdicts[number]
        if number not in self._expectations:
            episodes = self.family.own.checks[number].episodes
            self._progress(f"{episodes} episodes of `{self.family.text_of(self.family.own.checks[number])}`")
            verdict, fault = check_expectation(self.family, self._runner, number)
            self._faults += fault
            self._expectations[number] = verdict
        verdict = self._expectations[number]
        return self._with_untested_lines(number, verdict) if verdict.passed else verdict

    def fail_elsewhere(self) -> set[int]:
        """Returns the checks without a verdict that fail on another map: the game's own was not searched to the end."""
        return self._trajectories.fail_elsewhere() - self.decided().keys()

    def _with_untested_lines(self, number: int, verdict: Verdict) -> Verdict:
        """Returns the verdict on an `expect` with the lines that ran in no trajectory; if all play at random, also in none of its episodes."""
        untested = self.trajectories.missing(number)
        unreached = tuple(line for line in verdict.unreached if line not in untested)
        if any(policy.name != "random" for policy in self.family.own.checks[number].policies):
            return replace(verdict, untested=untested, unreached=unreached)
        return replace(verdict, untested=(*untested, *(f"{line}  (in none of its own episodes)" for line in unreached)), unreached=())

    def decided(self) -> dict[int, Verdict]:
        """Returns the verdicts that are certain by now: after an interruption, what need not be played again."""
        played: dict[int, Verdict] = self._trajectories.failed() | vars(self).get("_verdicts", {})
        missed = {i: verdict for i, verdict in self._expectations.items() if not verdict.passed}
        return self._static | played | missed

    def report(self) -> Report:
        """Returns all verdicts."""
        verdicts = tuple(self.verdict(i) for i in self.numbers)
        played, idle = (self.trajectories.played, self.trajectories.idle()) if self.has_played else (0, ())
        return Report(verdicts, played, idle, self.faults, self.notes)

    @property
    def faults(self) -> tuple[Verdict, ...]:
        """What is wrong whatever the checks say, as far as it has come up; at most one."""
        return tuple([*self._trajectories.faults(), *self._faults][:1])

    @property
    def notes(self) -> tuple[Verdict, ...]:
        """A real that leaves float32 on another map than the game's own, if one did; at most one."""
        return tuple(self._trajectories.notes())

    @property
    def has_played(self) -> bool:
        """Whether trajectories were played: static verdicts, and an `expect` that its episodes violate, need none."""
        return "trajectories" in vars(self)

    @cached_property
    def trajectories(self) -> PlayedVerdicts:
        """The trajectories, all of them played."""
        self._trajectories.play()
        return self._trajectories

    @cached_property
    def _trajectories(self) -> PlayedVerdicts:
        return PlayedVerdicts(self.family, self.effort, self._played, self._expected, self._progress)

    @cached_property
    def _runner(self) -> EpisodeRunner:
        return EpisodeRunner(self.family, self.effort.seed)

    @cached_property
    def _verdicts(self) -> dict[int, Verdict]:
        """The verdicts on the checks about every trajectory."""
        return {i: self.trajectories.passed(i) for i in self._played} | self.trajectories.failed()


def verify_properties(family: GameFamily, effort: Effort | None = None, only: Collection[int] | None = None) -> Report:
    """Returns the verdicts on a game's checks. Raises CompileError for a game that cannot be compiled exactly."""
    return Verification(family, effort, only).report()


def decide_statically(family: GameFamily, number: int) -> Verdict | None:
    """Returns the verdict on a check that needs no playing; None if it does."""
    game, check = family.own, family.own.checks[number]
    match check.sort:
        case "require":
            return make_verdict(
                family, check, True, "decided", "it holds for the parameters of the file; others are checked when they are set"
            )
        case "symmetric" if one_sided_action(check, game):
            return make_verdict(family, check, False, "decided", one_sided_action(check, game))
        case "symmetric" if not tells_apart(check, game) and not (names_agents(game) and tells_apart(check, family.crowded)):
            return _symmetric(family, check)
        case "always" | "once" if _in_all_sizes(family, number, lambda game: bool(decide(game.checks[number].values[-1]))):
            return make_verdict(family, check, True, "proved", "the ranges of the values it reads imply it")
        case "conserved" if is_untouched(check.values[0], game, family.sends_later):
            return make_verdict(family, check, True, "proved", "no rule writes anything that it reads")
        case "monotone" if _in_all_sizes(family, number, lambda game: decide_monotone(game.checks[number], game)):
            return make_verdict(family, check, True, "proved", "every operation between the two is monotone")
        case _:
            return None


def _in_all_sizes(family: GameFamily, number: int, proves: Callable[[ir.Game], bool]) -> bool:
    """Returns whether a proof of a check succeeds for the game as it is, on its map twice, and in all sizes that it may depend on."""
    if not (proves(family.own) and proves(family.doubled)):
        return False
    others = in_all_sizes(family, family.own.checks[number])
    return others is not None and all(map(proves, others))


def _symmetric(family: GameFamily, check: ir.Check) -> Verdict:
    """Returns the verdict on a symmetry that no rule of a step breaks: it is proved unless who is sent first takes cells from the others."""
    because, (chosen, crowded) = why_symmetric(check, family.own), order_of_sending(check, family.own)
    if chosen:
        but = f"in line {chosen[0].span.line} some cells suit only some agents, and lower-numbered agents choose first: the effect of this is not tested"
        return make_verdict(family, check, True, "decided", f"{because}; but {but}")
    but = f" (should free cells run out in line {crowded[0].span.line}, lower numbers come first)" if crowded else ""
    return make_verdict(family, check, True, "proved", because + but)


def _overflow(family: GameFamily, runner: EpisodeRunner, episodes: Sequence[Episode], policies: Sequence[ir.Policy]) -> list[Verdict]:
    """Returns the verdict on the first episode in which a real leaves float32, if any."""
    episode = next((e for e in episodes if e.left is not None), None)
    if episode is None:
        return []
    opening = f"episode {episode.number} on the game's own map, the agents in turn: {names_of(family, policies)}"
    scenario = runner.written_out(policies, episode, len(episode.actions))
    return [overflow_verdict(family, runner.overflow(episode, policies), "episodes", [opening], scenario)]


def check_expectation(family: GameFamily, runner: EpisodeRunner, number: int) -> tuple[Verdict, list[Verdict]]:
    """Returns the verdict on an `expect`, whose condition must hold at the end of every one of its episodes; and what else is wrong in them."""
    check = family.own.checks[number]
    try:
        episodes = runner.play(check.policies, 0, check.episodes)
    except (NotSupported, TooLarge) as error:
        return make_verdict(family, check, None, "not decided", f"the compiled game cannot play this yet: {error}"), []
    fault = _overflow(family, runner, episodes, check.policies)
    if fault:
        return make_verdict(family, check, None, "not decided", "its episodes cannot be judged: a real leaves float32"), fault
    missed = [e for e in episodes if not e.values[number][-1][0]]
    figures = _figures(check, episodes, family.own)
    if not missed:
        share = (
            f"{len(episodes)} of {len(episodes)} episodes (at least {100 * least_share(len(episodes)):.1f}% of all, with 95% confidence)"
        )
        ran = frozenset().union(*(episode.ran for episode in episodes))
        verdict = make_verdict(family, check, True, "episodes", "; ".join([share, *figures]))
        return replace(verdict, unreached=tuple(statement_lines(family, runner.counted_for(number) - ran))), []
    said = "; ".join([f"{len(episodes) - len(missed)} of {len(episodes)} episodes", *figures])
    values = [value for (value,) in missed[0].values[number]]
    held = [t for t, value in enumerate(values) if value]
    where = Violation(max(held) + 1) if held else Violation(len(values) - 1)
    trace = describe_episode(family, runner, missed[0], check.policies, number, where)
    return make_verdict(family, check, False, "episodes", said, trace, runner.written_out(check.policies, missed[0], where.at)), []


def _figures(check: ir.Check, episodes: list[Episode], game: ir.Game) -> list[str]:
    """Returns the means of the events that a check reads, with half of their 95% confidence intervals."""
    found = []
    for total in dict.fromkeys((n.name, n.word) for n in ir.walk(check) if isinstance(n, ir.EventTotal)):
        name, word = total
        words = [word] if word else [word for word, _ in counts_of(event_named(game, name))]
        mean, half = mean_and_half([float(sum(e.totals[name, w] for w in words)) for e in episodes])
        found.append(f"{name}{f'[{word}]' if word else ''} {mean:.4g} ± {half:.2g}")
    return found
