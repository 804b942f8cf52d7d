"""Verifies every check of a game: decides or proves it statically if possible, and otherwise tests it by play."""

from collections import Counter
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from functools import cached_property

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import counts_of, event_named
from sjdsl.compiler.ir.ranges import are_numbers
from sjdsl.compiler.lower.scope import NotSupported
from sjdsl.extras import is_installed
from sjdsl.properties.counterexample import (
    LARGEST,
    describe_counterexample,
    describe_episode,
    describe_overflow,
    episode_opening,
)
from sjdsl.properties.effects import is_untouched
from sjdsl.properties.engines import Episode, EpisodeRunner
from sjdsl.properties.instances import GameFamily
from sjdsl.properties.intervals import decide, may_leave_float32, rounds_only_numbers
from sjdsl.properties.monitors import CONFIDENCE, FLOATS, Violation, least_share
from sjdsl.properties.monotonicity import decide_monotone
from sjdsl.properties.search import Counterexample, Search
from sjdsl.properties.sizes import in_all_sizes
from sjdsl.properties.statements import leaf_statements, statements_needed_by
from sjdsl.properties.symmetry import order_of_sending, why_asymmetric, why_symmetric
from sjdsl.properties.trajectory import Trajectory
from sjdsl.properties.verdict import Effort, How, Progress, Verdict, make_verdict
from sjdsl.trace.rules import Rules


@dataclass(frozen=True)
class Report:
    """The verdicts on a game's checks in the order written.

    steps: of random play; idle: the lines of statements that never ran in it. faults: what is wrong whatever the checks say: a real that leaves float32.
    """

    verdicts: tuple[Verdict, ...]
    steps: int = 0
    idle: tuple[int, ...] = ()
    faults: tuple[Verdict, ...] = ()


class Verification:
    """The verification of one game's checks, each done when it is asked for; play that serves several checks is done once.

    has_played: whether random play was needed so far: static verdicts, and an `expect` that its episodes violate, need none.
    """

    def __init__(
        self,
        family: GameFamily,
        effort: Effort | None = None,
        only: Collection[int] | None = None,
        progress: Progress = lambda _: None,
    ):
        """`only`: indices among the game's checks; None: all. `progress`: is told how far the play is, a few hundred times."""
        self.family, self._progress, effort = family, progress, effort or Effort()
        checks, leaves = family.own.checks, leaf_statements(family.own)
        self.numbers = [i for i in range(len(checks)) if only is None or i in only]
        self._known = {
            i: verdict
            for i in self.numbers
            if (verdict := decide_statically(family, i)) is not None
        }
        played = [i for i in self.numbers if i not in self._known]
        self._needed = {i: statements_needed_by(checks[i], family.own, leaves) for i in played}
        states = [i for i in played if checks[i].sort != "expect"]
        self._reals_may_leave = only is None and may_leave_float32(family.own)
        self._search, self.has_played = (
            Search(family, states, effort, self._needed, progress, self._reals_may_leave),
            False,
        )
        self._runner, self._faults = EpisodeRunner(family, effort.seed), list[Verdict]()
        self._full = effort.full

    def verdict(self, number: int) -> Verdict:
        """Returns the verdict on a check. Raises CompileError for a game that cannot be compiled exactly."""
        if number not in self._known:
            check = self.family.own.checks[number]
            if check.sort == "expect":
                self._progress(f"{check.episodes} episodes of `{self.family.text_of(check)}`")
                verdict = self._expectation(number)
            else:
                verdict = (
                    self._passed(number)
                    if number not in self._finished_search.found
                    else self._failed(self._finished_search.found[number])
                )
            self._known[number] = (
                replace(verdict, untested=self._untested(number)) if verdict.passed else verdict
            )
        return self._known[number]

    def decided(self) -> dict[int, Verdict]:
        """Returns the verdicts that are certain by now: after an interruption, what need not be played again."""
        return self._known | {
            i: self._failed(found)
            for i, found in self._search.found.items()
            if i not in (FLOATS, *self._known)
        }

    def report(self) -> Report:
        """Returns all verdicts. A game whose reals may leave float32 is played for that, even if every check has a verdict without play."""
        verdicts = tuple(self.verdict(i) for i in self.numbers)
        if self._reals_may_leave and not self._faults:
            _ = self._finished_search
        ran, leaves = self._search.ran, leaf_statements(self.family.own) if self.has_played else ()
        idle = {
            leaf.statement.origin.line
            for leaf in leaves
            if leaf.statement_id not in ran and leaf.statement.origin is not None
        }
        return Report(verdicts, self._search.steps, tuple(sorted(idle)), self.faults)

    @property
    def faults(self) -> tuple[Verdict, ...]:
        """What is wrong whatever the checks say, as far as it has come up; at most one."""
        found = self._search.found.get(FLOATS)
        return tuple([*([] if found is None else [self._failed(found)]), *self._faults][:1])

    @cached_property
    def _finished_search(self) -> Search:
        """The search, when all is played."""
        if self._needed or self._reals_may_leave:
            self.has_played = True
            self._search.run()
        return self._search

    def _passed(self, number: int) -> Verdict:
        check, search = self.family.own.checks[number], self._finished_search
        never = (
            "; its first condition never held"
            if check.sort == "once" and number not in search.triggered
            else ""
        )
        return make_verdict(
            self.family, check, True, "examples", f"{search.steps:,} steps of random play{never}"
        )

    def _failed(self, found: Counterexample) -> Verdict:
        trace, scenario = describe_counterexample(self.family, found, self._full), found.scenario
        if found.number == FLOATS:
            return replace(
                self._overflow(found.trajectory, "examples"), trace=tuple(trace), scenario=scenario
            )
        said = f"fails after step {found.where.at - 1}" if found.where.at else "fails at the start"
        return make_verdict(
            self.family,
            self.family.own.checks[found.number],
            False,
            "examples",
            said,
            trace,
            scenario=scenario,
        )

    def _overflow(self, trajectory: Trajectory, how: How) -> Verdict:
        """Returns the verdict on a real that leaves float32 at the end of a trajectory."""
        assert trajectory.left is not None
        said = f"in step {trajectory.left.before}" if trajectory.worlds else "in phase start"
        return make_verdict(
            self.family,
            trajectory.left.node,
            False,
            how,
            f"a real leaves float32, which ends at {LARGEST}, {said}",
        )

    def _untested(self, number: int) -> tuple[str, ...]:
        """Returns the lines that a check depends on and that never ran, with their text; in which use, if their phase is used several times."""
        check, rules, leaves = (
            self.family.own.checks[number],
            Rules(self.family.composition.sources),
            leaf_statements(self.family.own),
        )
        uses, never = (
            Counter(leaf.statement_id[1:] for leaf in leaves),
            self._needed[number] - self._finished_search.ran,
        )
        lines = [
            f"{rules.place(leaf.statement)}  {rules.text(leaf.statement)}"
            + f"  (in {leaf.statement_id[0]})" * (uses[leaf.statement_id[1:]] > 1)
            for leaf in leaves
            if leaf.statement_id in never
        ]
        if check.sort == "once" and number not in self._finished_search.triggered:
            lines.append(
                f"{rules.place(check)}  the first condition never held: {rules.text(check.values[0])}"
            )
        return tuple(dict.fromkeys(lines))

    def _expectation(self, number: int) -> Verdict:
        """Returns the verdict on an `expect`, whose condition must hold at the end of every one of its episodes."""
        family, check, runner = self.family, self.family.own.checks[number], self._runner
        if runner.compiles(check.episodes) and not is_installed("jax"):
            reason = "its episodes are long, so they need the compiled game, and JAX isn't installed here; `sjdsl test` plays them"
            return make_verdict(family, check, None, "not decided", reason)
        try:
            episodes = runner.play(check.policies, 0, check.episodes)
        except NotSupported as error:
            return make_verdict(
                family,
                check,
                None,
                "not decided",
                f"the compiled game cannot play this yet: {error}",
            )
        if (gone := next((e for e in episodes if e.left is not None), None)) is not None:
            trajectory = runner.overflow(gone)
            told, scenario = (
                [
                    episode_opening(family, gone, check.policies),
                    *describe_overflow(family, trajectory),
                ],
                runner.written_out(gone, len(gone.actions)),
            )
            self._faults.append(
                replace(
                    self._overflow(trajectory, "episodes"), trace=tuple(told), scenario=scenario
                )
            )
            return make_verdict(
                family,
                check,
                None,
                "not decided",
                "its episodes cannot be judged: a real leaves float32",
            )
        missed, many = [e for e in episodes if not e.values[number][-1][0]], len(episodes)
        share = (
            ""
            if missed
            else f" (at least {100 * least_share(many):.1f}% of all, with {CONFIDENCE:.0%} confidence)"
        )
        said = "; ".join(
            [
                f"{many - len(missed)} of {many} episodes{share}",
                *_means(check, episodes, family.own),
            ]
        )
        if not missed:
            return make_verdict(family, check, True, "episodes", said)
        values = [value for (value,) in missed[0].values[number]]
        held = [t for t, value in enumerate(values) if value]
        where = Violation(max(held) + 1) if held else Violation(len(values) - 1)
        trace = describe_episode(
            family, runner, missed[0], check.policies, number, where, self._full
        )
        return make_verdict(
            family,
            check,
            False,
            "episodes",
            said,
            trace,
            scenario=runner.written_out(missed[0], where.at),
        )


def verify_properties(
    family: GameFamily, effort: Effort | None = None, only: Collection[int] | None = None
) -> Report:
    """Returns the verdicts on a game's checks. Raises CompileError for a game that cannot be compiled exactly."""
    return Verification(family, effort, only).report()


def decide_statically(family: GameFamily, number: int) -> Verdict | None:
    """Returns the verdict on a check that needs no playing; None if it does."""
    game, check = family.own, family.own.checks[number]
    match check.sort:
        case "require":
            return make_verdict(
                family,
                check,
                True,
                "decided",
                "it holds for the parameters of the file; others are checked when they are set",
            )
        case "symmetric":
            return _symmetric(family, check)
        case "always" | "once" if _in_all_sizes(
            family, number, lambda game: bool(decide(game.checks[number].values[-1]))
        ):
            return make_verdict(
                family, check, True, "proved", "the ranges of the values it reads imply it"
            )
        case "conserved" if is_untouched(check.values[0], game, family.sends_later) and are_numbers(
            check.values[0]
        ):
            return make_verdict(
                family, check, True, "proved", "no rule writes anything that the check reads"
            )
        case "monotone" if _in_all_sizes(
            family, number, lambda game: decide_monotone(game.checks[number], game)
        ):
            return make_verdict(
                family,
                check,
                True,
                "proved",
                "every operation that leads from one to the other is monotone",
            )
        case _:
            return None


def _in_all_sizes(family: GameFamily, number: int, proves: Callable[[ir.Game], bool]) -> bool:
    """Returns whether a proof of a check, by ranges, succeeds for the game as it is, on its map twice, and in all sizes that it may depend on."""

    def succeeds(game: ir.Game) -> bool:
        return rounds_only_numbers(game) and proves(game)

    if not (succeeds(family.own) and succeeds(family.doubled)):
        return False
    others = in_all_sizes(family, family.own.checks[number])
    return others is not None and all(map(succeeds, others))


def _symmetric(family: GameFamily, check: ir.Check) -> Verdict:
    """Returns the verdict on a symmetry: it is proved if no rule of a step reads a number, unless who is sent first takes cells from the others."""
    if told := why_asymmetric(check, family):
        return make_verdict(family, check, False, "decided", told)
    because, (chosen, crowded) = (
        why_symmetric(check, family.own),
        order_of_sending(check, family.own),
    )
    if chosen:
        but = f"in line {chosen[0].span.line} some cells suit only some agents, and lower-numbered agents choose first: the effect of this is not tested"
        return make_verdict(family, check, True, "decided", f"{because}; but {but}")
    but = (
        f" (should free cells run out in line {crowded[0].span.line}, lower numbers come first)"
        if crowded
        else ""
    )
    return make_verdict(family, check, True, "proved", because + but)


def _means(check: ir.Check, episodes: list[Episode], game: ir.Game) -> list[str]:
    """Returns the means over episodes of the events that a check reads."""
    found = []
    for name, word in dict.fromkeys(
        (n.name, n.word) for n in ir.walk(check) if isinstance(n, ir.EventTotal)
    ):
        words = [word] if word else [word for word, _ in counts_of(event_named(game, name))]
        mean = sum(e.totals[name, w] for e in episodes for w in words) / len(episodes)
        found.append(f"{name}{f'[{word}]' if word else ''} {mean:.4g} on average")
    return found
