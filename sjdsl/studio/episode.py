"""The episode on the board: every moment so far, and the one that is shown."""

from collections.abc import Mapping
from dataclasses import dataclass

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import counts_of
from sjdsl.interpreter.state import Outcome, Value, World, copied
from sjdsl.interpreter.step import reset, step
from sjdsl.interpreter.threefry import Threefry
from sjdsl.properties.trajectory import Scenario, draws_of
from sjdsl.render.moment import Moment as Drawn
from sjdsl.render.moment import moment_of
from sjdsl.trace.episode import Moment, begin, follow, take_step, trial_of
from sjdsl.trace.jax_random import keys_of

LONGEST = 5_000  # moments that are kept


class TooLong(Exception):
    """The episode has as many moments as the studio keeps."""


@dataclass
class Episode:
    """An episode of a seed, with the draws of `sjdsl play`.

    moments: all so far, the start first; returns: of each agent at each of them.
    at: the index of the moment that is shown.
    is_put: whether it begins with a state that the user built, not with the phase `start`.
    scenario: of a counterexample, which determines the draws of the start and of the first
      `written` steps.
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
        """The moment that is shown."""
        return self.moments[self.at]

    @property
    def steps_taken(self) -> int:
        """The steps of the episode up to the moment that is shown, over all trials."""
        return self.moments[0].world.step + self.at

    def step(self, actions: list[int], params: Mapping[str, Value]) -> None:
        """Plays a step from the moment that is shown; the moment after it is shown then.

        Moments that came after the one that was shown are dropped.

        Args:
          actions: the number of each agent's action.
          params: the game's parameters by name.
        Raises:
          TooLong: no more moments are kept.
          LeavesFloat32: a real of the game gets too large.
        """
        next_place = self.at + 1
        if next_place >= LONGEST:
            raise TooLong(
                f"the studio keeps {LONGEST} moments of an episode: go back, or begin it again"
            )
        before = self.now.world
        key = keys_of(self.seed).of_step(self.steps_taken)
        after, outcome = step(self.game, before, actions, params, Threefry(*key))
        moment = Moment(
            number=before.step,
            key=key,
            world=after,
            turns=(),
            actions=tuple(actions),
            outcome=outcome,
            trial=trial_of(self.game, before),
        )
        self.moments[next_place:] = [moment]
        self.returns[next_place:] = [with_reward(self.returns[self.at], outcome)]
        # This step doesn't follow the counterexample, even if the one that it replaces did.
        self.written = min(self.written, self.at)
        self.at = next_place

    def traced(self) -> Moment:
        """Returns the moment that is shown with an account of what led to it.

        The account follows the rules as they are now.
        """
        moment = self.now
        params = moment.world.params
        if moment.outcome is not None:
            before = self.moments[self.at - 1].world
            if self.scenario is not None and self.at <= self.written:
                draws = draws_of(self.scenario, self.at - 1, self.game, before)
                return take_step(self.game, before, params, draws, moment.actions)
            return follow(self.game, before, params, moment.key, moment.actions)
        if moment.world.step == 0 and not self.is_put:
            return begin(self.game, params, moment.key)
        return moment

    def go(self, number: int) -> None:
        """Shows another moment, the nearest there is."""
        self.at = min(max(0, number), len(self.moments) - 1)

    def drawn(self, number: int) -> Drawn:
        """Returns a moment as pictures and pages need it."""
        moment = self.moments[number]
        return moment_of(
            self.game, moment.world, self.returns[number], moment.actions, moment.outcome
        )


def with_reward(returns: list[float], outcome: Outcome) -> list[float]:
    """Returns the returns of the agents after a step."""
    return [before + float(paid) for before, paid in zip(returns, outcome.reward, strict=True)]


def metric_names(game: ir.Game) -> list[tuple[str, bool]]:
    """Returns the names of a game's metrics, each with whether it is an event, which is summed."""
    events = [(name, True) for event in game.events for _, name in counts_of(event)]
    return events + [(measure.name, False) for measure in game.measures]


def metric_values(game: ir.Game, outcome: Outcome | None) -> list[float]:
    """Returns the metrics of a step, in the order of `metric_names`; none without an outcome.

    Events are summed over the agents.
    """
    if outcome is None:
        return []
    values = []
    for event in game.events:
        counts = outcome.events[event.name]
        by_agent = counts if event.per_agent else [counts]
        for index, (word, _) in enumerate(counts_of(event)):
            values.append(sum(float(c if word is None else c[index]) for c in by_agent))
    return values + [float(outcome.measures[measure.name]) for measure in game.measures]


def begin_episode(game: ir.Game, params: Mapping[str, Value], seed: int) -> Episode:
    """Returns the start of an episode. Raises LeavesFloat32."""
    key = keys_of(seed).start()
    world = copied(reset(game, params, Threefry(*key)))
    return Episode(game, seed, [Moment(None, key, world, ())], [[0.0] * game.agents.number])


def continue_from(game: ir.Game, world: World, returns: list[float], seed: int) -> Episode:
    """Returns an episode that goes on from a state."""
    moment = Moment(None, keys_of(seed).start(), world, ())  # nothing reads its key
    return Episode(game, seed, [moment], [returns], is_put=True)
