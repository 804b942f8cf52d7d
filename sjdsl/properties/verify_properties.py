"""Verifies every check of a game: decides or proves it statically if possible, else by play."""

from collections import Counter
from collections.abc import Callable, Collection, Sequence
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
    when,
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
from sjdsl.properties.trajectory import Scenario, Trajectory
from sjdsl.properties.verdict import Effort, How, Progress, Verdict, make_verdict
from sjdsl.trace.rules import Rules


@dataclass(frozen=True)
class Report:
    """The verdicts on a game's checks in the order written.

    steps: of random play; idle: the lines of statements that never ran in it.
    faults: what is wrong whatever the checks say, namely a real that leaves float32.
    """

    verdicts: tuple[Verdict, ...]
    steps: int = 0
    idle: tuple[int, ...] = ()
    faults: tuple[Verdict, ...] = ()


class Verification:
    """The verification of one game's checks, each done when it is asked for.

    Play that serves several checks is done once.
    numbers: of the checks that are verified.
    has_played: whether random play was needed so far: static verdicts, and an `expect` that its
    episodes violate, need none.
    """

    def __init__(
        self,
        family: GameFamily,
        effort: Effort | None = None,
        only: Collection[int] | None = None,
        progress: Progress = lambda _: None,
    ):
        """Decides what can be decided without play.

        Args:
          only: indices among the game's checks; None: all.
          progress: called with how far the play is, a few hundred times.
        """
        effort = effort or Effort()
        checks = family.own.checks
        self.family = family
        self.numbers = [i for i in range(len(checks)) if only is None or i in only]
        self.has_played = False
        self._progress = progress
        self._full = effort.full
        self._reals_may_leave = only is None and may_leave_float32(family.own)
        self._faults: list[Verdict] = []  # of episodes
        self._known: dict[int, Verdict] = {}
        for i in self.numbers:
            verdict = decide_statically(family, i)
            if verdict is not None:
                self._known[i] = verdict

        # The other checks are decided by play: an `expect` by episodes, all others by a search.
        to_play = [i for i in self.numbers if i not in self._known]
        leaves = leaf_statements(family.own)
        self._needed = {i: statements_needed_by(checks[i], family.own, leaves) for i in to_play}
        searched = [i for i in to_play if checks[i].kind != "expect"]
        self._search = Search(
            family, searched, effort, self._needed, progress, self._reals_may_leave
        )
        self._runner = EpisodeRunner(family, effort.seed)

    def verdict(self, number: int) -> Verdict:
        """Returns the verdict on a check.

        Raises:
          CompileError: the game cannot be compiled exactly.
        """
        if number not in self._known:
            verdict = self._played_verdict(number)
            if verdict.passed:
                verdict = replace(verdict, untested=self._untested(number))
            self._known[number] = verdict
        return self._known[number]

    def _played_verdict(self, number: int) -> Verdict:
        """Returns the verdict on a check that play decides."""
        check = self.family.own.checks[number]
        if check.kind == "expect":
            self._progress(f"{check.episodes} episodes of `{self.family.text_of(check)}`")
            return self._expectation(number)
        search = self._finished_search
        if number in search.found:
            return self._failed(search.found[number])
        reason = f"{search.steps:,} steps of random play"
        if check.kind == "once" and number not in search.triggered:
            reason += "; its first condition never held"
        return make_verdict(self.family, check, True, "examples", reason)

    def decided(self) -> dict[int, Verdict]:
        """Returns the verdicts that are certain by now.

        After an interruption, these checks need not be played again.
        """
        verdicts = dict(self._known)
        for i, counterexample in self._search.found.items():
            if i != FLOATS and i not in verdicts:
                verdicts[i] = self._failed(counterexample)
        return verdicts

    def report(self) -> Report:
        """Returns all verdicts.

        A game whose reals may leave float32 is played for that, even if every check has a verdict
        without play.
        """
        verdicts = tuple(self.verdict(i) for i in self.numbers)
        if self._reals_may_leave and not self._faults:
            _ = self._finished_search
        idle: set[int] = set()
        if self.has_played:
            for leaf in leaf_statements(self.family.own):
                origin = leaf.statement.origin
                if leaf.statement_id not in self._search.ran and origin is not None:
                    idle.add(origin.line)
        return Report(verdicts, self._search.steps, tuple(sorted(idle)), self.faults)

    @property
    def faults(self) -> tuple[Verdict, ...]:
        """What is wrong whatever the checks say, as far as it has come up; at most one."""
        counterexample = self._search.found.get(FLOATS)
        if counterexample is not None:
            return (self._failed(counterexample),)
        return tuple(self._faults[:1])

    @cached_property
    def _finished_search(self) -> Search:
        """The search, when all is played."""
        if self._needed or self._reals_may_leave:
            self.has_played = True
            self._search.run()
        return self._search

    def _failed(self, counterexample: Counterexample) -> Verdict:
        """Returns the verdict that a counterexample gives."""
        trace = describe_counterexample(self.family, counterexample, self._full)
        scenario = counterexample.scenario
        if counterexample.number == FLOATS:
            return self._overflow(counterexample.trajectory, "examples", trace, scenario)
        check = self.family.own.checks[counterexample.number]
        reason = f"fails {when(counterexample.where.at)}"
        return make_verdict(
            self.family, check, False, "examples", reason, trace=trace, scenario=scenario
        )

    def _overflow(
        self, trajectory: Trajectory, how: How, trace: Sequence[str], scenario: Scenario
    ) -> Verdict:
        """Returns the verdict on a real that leaves float32 at the end of a trajectory."""
        overflow = trajectory.overflow
        assert overflow is not None
        where = f"in step {overflow.before}" if trajectory.worlds else "in phase start"
        reason = f"a real leaves float32, which ends at {LARGEST}, {where}"
        return make_verdict(
            self.family, overflow.node, False, how, reason, trace=trace, scenario=scenario
        )

    def _untested(self, number: int) -> tuple[str, ...]:
        """Returns the lines that a check depends on and that never ran, with their text.

        And in which use of their phase, if it has several.
        """
        check = self.family.own.checks[number]
        rules = Rules(self.family.composition.sources)
        leaves = leaf_statements(self.family.own)
        uses = Counter(leaf.statement_id[1:] for leaf in leaves)
        never_ran = self._needed[number] - self._finished_search.ran
        lines = []
        for leaf in leaves:
            if leaf.statement_id in never_ran:
                statement = leaf.statement
                is_reused = uses[leaf.statement_id[1:]] > 1
                use = f"  (in {leaf.statement_id[0]})" if is_reused else ""
                lines.append(f"{rules.place(statement)}  {rules.text(statement)}{use}")
        if check.kind == "once" and number not in self._finished_search.triggered:
            condition = rules.text(check.values[0])
            lines.append(f"{rules.place(check)}  the first condition never held: {condition}")
        return tuple(dict.fromkeys(lines))

    def _expectation(self, number: int) -> Verdict:
        """Returns the verdict on an `expect`.

        Its condition must hold at the end of every one of its episodes.
        """
        family = self.family
        check = family.own.checks[number]
        runner = self._runner
        if runner.compiles(check.episodes) and not is_installed("jax"):
            return self._undecided(
                check,
                "its episodes are long, so they need the compiled game, and JAX isn't installed "
                "here; `sjdsl test` plays them",
            )
        try:
            episodes = runner.play(check.policies, 0, check.episodes)
        except NotSupported as error:
            return self._undecided(check, f"the compiled game cannot play this yet: {error}")
        for episode in episodes:
            if episode.overflow is not None:
                self._add_fault(check, episode)
                return self._undecided(
                    check, "its episodes cannot be judged: a real leaves float32"
                )
        missed = [episode for episode in episodes if not episode.values[number][-1][0]]
        means = "".join(f"; {mean}" for mean in _means(check, episodes, family.own))
        held = f"{len(episodes) - len(missed)} of {len(episodes)} episodes"
        if not missed:
            share = 100 * least_share(len(episodes))
            bound = f" (at least {share:.1f}% of all, with {CONFIDENCE:.0%} confidence)"
            return make_verdict(family, check, True, "episodes", held + bound + means)
        episode = missed[0]
        holds = [value for (value,) in episode.values[number]]
        # After the last state in which it holds; if it never does, at the end.
        last = max((t for t, value in enumerate(holds) if value), default=None)
        where = Violation(len(holds) - 1 if last is None else last + 1)
        trace = describe_episode(family, runner, episode, check.policies, number, where, self._full)
        scenario = runner.written_out(episode, where.at)
        return make_verdict(
            family, check, False, "episodes", held + means, trace=trace, scenario=scenario
        )

    def _undecided(self, check: ir.Check, reason: str) -> Verdict:
        return make_verdict(self.family, check, None, "not decided", reason)

    def _add_fault(self, check: ir.Check, episode: Episode) -> None:
        """Notes that a real leaves float32 in an episode of an `expect`."""
        trajectory = self._runner.play_overflow(episode)
        trace = [
            episode_opening(self.family, episode, check.policies),
            *describe_overflow(self.family, trajectory),
        ]
        scenario = self._runner.written_out(episode, len(episode.actions))
        self._faults.append(self._overflow(trajectory, "episodes", trace, scenario))


def verify_properties(
    family: GameFamily, effort: Effort | None = None, only: Collection[int] | None = None
) -> Report:
    """Returns the verdicts on a game's checks.

    Raises:
      CompileError: the game cannot be compiled exactly.
    """
    return Verification(family, effort, only).report()


def decide_statically(family: GameFamily, number: int) -> Verdict | None:
    """Returns the verdict on a check that needs no playing; None if it does."""
    game = family.own
    check = game.checks[number]

    def is_implied(game: ir.Game) -> bool:
        return bool(decide(game.checks[number].values[-1]))

    def is_monotone(game: ir.Game) -> bool:
        return decide_monotone(game.checks[number], game)

    match check.kind:
        case "require":
            reason = "it holds for the parameters of the file; others are checked when they are set"
            return make_verdict(family, check, True, "decided", reason)
        case "symmetric":
            return _symmetric(family, check)
        case "always" | "once" if _in_all_sizes(family, number, is_implied):
            reason = "the ranges of the values it reads imply it"
        case "conserved" if is_untouched(check.values[0], game, family.sends_later) and are_numbers(
            check.values[0]
        ):
            reason = "no rule writes anything that the check reads"
        case "monotone" if _in_all_sizes(family, number, is_monotone):
            reason = "every operation that leads from one to the other is monotone"
        case _:
            return None
    return make_verdict(family, check, True, "proved", reason)


def _in_all_sizes(family: GameFamily, number: int, proves: Callable[[ir.Game], bool]) -> bool:
    """Returns whether a proof by ranges of a check succeeds.

    For the game as it is, on its map twice, and in all sizes that the check may depend on.
    """

    def succeeds(game: ir.Game) -> bool:
        return rounds_only_numbers(game) and proves(game)

    if not (succeeds(family.own) and succeeds(family.doubled)):
        return False
    others = in_all_sizes(family, family.own.checks[number])
    return others is not None and all(map(succeeds, others))


def _symmetric(family: GameFamily, check: ir.Check) -> Verdict:
    """Returns the verdict on a symmetry: it is proved if no rule of a step reads a number.

    Unless those who are sent first take cells that others can't do without.
    """
    asymmetry = why_asymmetric(check, family)
    if asymmetry:
        return make_verdict(family, check, False, "decided", asymmetry)
    reason = why_symmetric(check, family.own)
    choosy, crowded = order_of_sending(check, family.own)
    if choosy:
        reason += (
            f"; but in line {choosy[0].span.line} some cells suit only some agents, and "
            "lower-numbered agents choose first: the effect of this is not tested"
        )
        return make_verdict(family, check, True, "decided", reason)
    if crowded:
        line = crowded[0].span.line
        reason += f" (should free cells run out in line {line}, lower numbers come first)"
    return make_verdict(family, check, True, "proved", reason)


def _means(check: ir.Check, episodes: list[Episode], game: ir.Game) -> list[str]:
    """Returns the means over episodes of the events that a check reads."""
    totals = [node for node in ir.walk(check) if isinstance(node, ir.EventTotal)]
    texts = []
    for name, word in dict.fromkeys((total.name, total.word) for total in totals):
        words = [word] if word else [word for word, _ in counts_of(event_named(game, name))]
        mean = sum(e.totals[name, w] for e in episodes for w in words) / len(episodes)
        event = f"{name}[{word}]" if word else name
        texts.append(f"{event} {mean:.4g} on average")
    return texts
