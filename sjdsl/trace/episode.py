"""Plays an episode on the reference interpreter and keeps an account of every step.

The draws are those of the compiled game: a trace is the episode that `sjdsl render` and `sjdsl
play` show for the same seed.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from sjdsl.compiler import ir
from sjdsl.interpreter.account import Account, Tell
from sjdsl.interpreter.board import Board, board_of
from sjdsl.interpreter.state import Outcome, Value, World, copied
from sjdsl.interpreter.step import action_mask, reset, step
from sjdsl.interpreter.threefry import Draws, Threefry
from sjdsl.trace.choices import ByEpisode
from sjdsl.trace.effects import Effect, effects_of
from sjdsl.trace.jax_random import Key, RecordedDraws, keys_of


@dataclass(frozen=True)
class Turn:
    """One turn of the schedule, or the phase `start`. account: from which its effects follow."""

    label: str
    effects: tuple[Effect, ...]
    account: Account


@dataclass(frozen=True)
class Moment:
    """The start of an episode or one step of it.

    number: of the step in its trial, None at the start; trial: that number, None in a game without
      trials; key: of its draws; world: the state that it leads to.
    actions: those chosen, none at the start; forbidden: the agents whose action was forbidden.
    """

    number: int | None
    key: Key
    world: World
    turns: tuple[Turn, ...]
    actions: tuple[int, ...] = ()
    forbidden: frozenset[int] = frozenset()
    outcome: Outcome | None = None
    trial: int | None = None

    @property
    def is_over(self) -> bool:
        """Whether the episode ends with it."""
        return self.outcome is not None and (self.outcome.terminated or self.outcome.truncated)


def play(
    game: ir.Game, params: Mapping[str, Value], seed: int, steps: int, choices: ByEpisode
) -> Iterator[Moment]:
    """Yields the start of an episode and its steps; after its end, the episode of the next seed.

    Args:
      steps: how many, over all episodes.
    """
    played = 0
    while True:
        keys = keys_of(seed)
        choose = choices(seed, played)
        moment = begin(game, params, keys.start())
        yield moment
        for number in range(steps - played):
            if moment.is_over:
                break
            actions = choose(number, moment.world)
            moment = follow(game, moment.world, params, keys.of_step(number), actions)
            yield moment
            played += 1
        if played == steps:
            return
        seed += 1


def begin(game: ir.Game, params: Mapping[str, Value], key: Key) -> Moment:
    """Returns the start of an episode. `key`: of the environment's `reset`."""
    turns: list[Turn] = []
    draws = RecordedDraws(Threefry(*key))
    world = reset(game, params, draws, _listener(turns, board_of(game), draws))
    return Moment(None, key, copied(world), tuple(turns))


def follow(
    game: ir.Game, world: World, params: Mapping[str, Value], key: Key, actions: Sequence[int]
) -> Moment:
    """Returns the step that follows a state. `key`: of the environment's `step`."""
    return take_step(game, world, params, Threefry(*key), actions, key)


def take_step(
    game: ir.Game,
    world: World,
    params: Mapping[str, Value],
    draws: Draws,
    actions: Sequence[int],
    key: Key = (0, 0),
) -> Moment:
    """Returns the step that follows a state, with any draws. `key`: theirs, if they have one."""
    turns: list[Turn] = []
    recorded = RecordedDraws(draws)
    allowed = action_mask(game, world)
    forbidden = frozenset(
        agent for agent, action in enumerate(actions) if not allowed[agent][action]
    )
    listener = _listener(turns, board_of(game), recorded)
    after, outcome = step(game, world, actions, params, recorded, listener)
    trial = trial_of(game, world)
    return Moment(world.step, key, after, tuple(turns), tuple(actions), forbidden, outcome, trial)


def trial_of(game: ir.Game, world: World) -> int | None:
    """Returns the number of the trial that a state is in; None in a game without trials."""
    return None if game.trials is None else world.fields["trial"]


def _listener(turns: list[Turn], board: Board, draws: RecordedDraws) -> Tell:
    """Returns what adds the account of each turn to `turns`."""

    def add(account: Account) -> None:
        turns.append(turn_of(account, board, draws.numbers))
        draws.numbers.clear()

    return add


def turn_of(account: Account, board: Board, numbers: Mapping[tuple[int, int], int]) -> Turn:
    """Returns one turn with its effects. `numbers`: the random numbers drawn in it."""
    label = account.turn.label if isinstance(account.turn, ir.Phase) else "tick"
    return Turn(label, tuple(effects_of(account, board, numbers)), account)
