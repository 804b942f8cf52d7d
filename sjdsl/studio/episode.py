"""The episode on the board: every moment so far, and the one that is shown."""

from collections.abc import Mapping
from dataclasses import dataclass

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import counts_of
from sjdsl.interpreter.state import Outcome, Value, World, copied
from sjdsl.interpreter.step import reset, step
from sjdsl.interpreter.threefry import Threefry
from sjdsl.properties.counterexample import take_step
from sjdsl.properties.trajectory import Scenario, draws_of
from sjdsl.render.moment import Moment as Drawn
from sjdsl.render.moment import moment_of
from sjdsl.trace.episode import Moment, begin, follow
from sjdsl.trace.jax_random import keys_of

LONGEST = 5_000  # moments that are kept


class TooLong(Exception):
    """The episode has as many moments as the studio keeps."""


@dataclass
class Episode:
    """An episode of a seed, with the draws of `sjdsl play`.

    moments: all so far, the start first; returns: of each agent at each of them; at: the number of the one that is shown. is_put: it begins
      with a state that somebody has made, not with the phase `start`.
    scenario: that of a counterexample, whose draws the start and the first `written` steps have.
    """

    game: ir.Game
    seed: int
    moments: list[Moment]
    returns: list[list[float]]
    at: int = 0
    is_put: bool = False
    scenario: Scenario | None = None
    written: int = 0

    @property
    def now(self) -> Moment:
        return self.moments[self.at]

    def step(self, actions: list[int], params: Mapping[str, Value]) -> None:
        """Takes a step from the moment that is shown; what came after is forgotten.

        Raises TooLong, and LeavesFloat32.
        """
        if self.at + 1 >= LONGEST:
            raise TooLong(
                f"the studio keeps {LONGEST} moments of an episode: go back, or begin it again"
            )
        key = keys_of(self.seed).of_step(self.now.world.step)
        world, outcome = step(self.game, self.now.world, actions, params, Threefry(*key))
        moment, paid = (
            Moment(self.now.world.step, key, world, (), tuple(actions), frozenset(), outcome),
            map(float, outcome.reward),
        )
        del self.moments[self.at + 1 :], self.returns[self.at + 1 :]
        self.written = min(self.written, self.at)
        self.moments.append(moment)
        self.returns.append(
            [before + reward for before, reward in zip(self.returns[self.at], paid, strict=True)]
        )
        self.at += 1

    def traced(self) -> Moment:
        """Returns the moment that is shown with an account of what led to it, by the rules as they are written now."""
        moment = self.now
        if moment.outcome is not None:
            before = self.moments[self.at - 1].world
            if self.scenario is not None and self.at <= self.written:
                return take_step(
                    self.game,
                    before,
                    moment.actions,
                    moment.world.params,
                    draws_of(self.scenario, self.at - 1),
                )
            return follow(self.game, before, moment.world.params, moment.key, list(moment.actions))
        return (
            begin(self.game, moment.world.params, moment.key)
            if moment.world.step == 0 and not self.is_put
            else moment
        )

    def go(self, number: int) -> None:
        """Shows another moment; the nearest there is."""
        self.at = min(max(0, number), len(self.moments) - 1)

    def drawn(self, number: int) -> Drawn:
        """Returns a moment as pictures and pages have it."""
        moment = self.moments[number]
        return moment_of(
            self.game, moment.world, self.returns[number], moment.actions, moment.outcome
        )


def metric_names(game: ir.Game) -> list[tuple[str, bool]]:
    """Returns the metrics of a game by name, each with whether it is an event, whose counts add up."""
    return [(name, True) for event in game.events for _, name in counts_of(event)] + [
        (m.name, False) for m in game.measures
    ]


def measured(game: ir.Game, outcome: Outcome | None) -> list[float]:
    """Returns the metrics of a step, in the order of `metric_names`, events summed over the agents; nothing for the start of an episode."""
    if outcome is None:
        return []
    found = []
    for event in game.events:
        counts = outcome.events[event.name]
        for place, (word, _) in enumerate(counts_of(event)):
            by_agent = counts if event.per_agent else [counts]
            found.append(sum(float(count if word is None else count[place]) for count in by_agent))
    return found + [float(outcome.measures[m.name]) for m in game.measures]


def begun(game: ir.Game, params: Mapping[str, Value], seed: int) -> Episode:
    """Returns the start of an episode. Raises LeavesFloat32."""
    key = keys_of(seed).start()
    return Episode(
        game,
        seed,
        [Moment(None, key, copied(reset(game, params, Threefry(*key))), ())],
        [[0.0] * game.agents.number],
    )


def resumed(game: ir.Game, world: World, returns: list[float], seed: int) -> Episode:
    """Returns an episode that goes on from a state."""
    moment = Moment(None, keys_of(seed).start(), world, ())  # nothing reads its key
    return Episode(game, seed, [moment], [returns], is_put=True)
