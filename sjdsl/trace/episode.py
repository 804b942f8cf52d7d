"""Plays an episode on the reference interpreter and keeps an account of every step.

The draws are those of the compiled game: a trace of a seed is the episode that `sjdsl render` and `sjdsl play` show for the same seed.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from sjdsl.compiler import ir
from sjdsl.interpreter.account import Account, Tell
from sjdsl.interpreter.board import Board, board_of
from sjdsl.interpreter.state import Outcome, Value, World, copied
from sjdsl.interpreter.step import action_mask, reset, step
from sjdsl.interpreter.threefry import Threefry
from sjdsl.trace.choices import ByEpisode
from sjdsl.trace.effects import Effect, effects_of
from sjdsl.trace.jax_random import Key, RecordedDraws, keys_of


@dataclass(frozen=True)
class Told:
    """One turn of the schedule, or the phase `start`. account: what its effects are told from."""

    label: str
    effects: tuple[Effect, ...]
    account: Account


@dataclass(frozen=True)
class Moment:
    """The start of an episode (`number` None) or one step of it, and the state it leads to.

    key: the two numbers that all its draws come from. actions: those chosen, none at the start; forbidden: agents whose action is forbidden.
    """

    number: int | None
    key: Key
    world: World
    turns: tuple[Told, ...]
    actions: tuple[int, ...] = ()
    forbidden: frozenset[int] = frozenset()
    outcome: Outcome | None = None

    @property
    def is_over(self) -> bool:
        """Whether the episode ends with it."""
        return self.outcome is not None and (self.outcome.terminated or self.outcome.truncated)


def play(
    game: ir.Game, params: Mapping[str, Value], seed: int, steps: int, choices: ByEpisode
) -> Iterator[Moment]:
    """Yields the start and so many steps; after the end of an episode comes the start of that of the next seed."""
    played = 0
    while True:
        keys, choose = keys_of(seed), choices(seed, played)
        moment = begin(game, params, keys.start())
        yield moment
        while played < steps and not moment.is_over:
            number = moment.world.step
            moment = follow(
                game, moment.world, params, keys.of_step(number), choose(number, moment.world)
            )
            yield moment
            played += 1
        if played == steps:
            return
        seed += 1


def begin(game: ir.Game, params: Mapping[str, Value], key: Key) -> Moment:
    """Returns the start of an episode. `key`: that of the environment's `reset`."""
    told: list[Told] = []
    recorded = RecordedDraws(Threefry(*key))
    world = reset(game, params, recorded, _listener(told, board_of(game), recorded))
    return Moment(None, key, copied(world), tuple(told))


def follow(
    game: ir.Game, world: World, params: Mapping[str, Value], key: Key, actions: list[int]
) -> Moment:
    """Returns the step that follows a state. `key`: that of the environment's `step`."""
    told: list[Told] = []
    recorded = RecordedDraws(Threefry(*key))
    allowed = action_mask(game, world)
    forbidden = frozenset(
        agent for agent, action in enumerate(actions) if not allowed[agent][action]
    )
    after, outcome = step(
        game, world, actions, params, recorded, _listener(told, board_of(game), recorded)
    )
    return Moment(world.step, key, after, tuple(told), tuple(actions), forbidden, outcome)


def _listener(told: list[Told], board: Board, recorded: RecordedDraws) -> Tell:
    def tell(account: Account) -> None:
        told.append(tell_of(account, board, recorded.numbers))
        recorded.numbers.clear()

    return tell


def tell_of(account: Account, board: Board, numbers: Mapping[tuple[int, int], int]) -> Told:
    """Returns what there is to tell of one turn. `numbers`: the random numbers taken in it."""
    label = account.turn.label if isinstance(account.turn, ir.Phase) else "tick"
    return Told(label, tuple(effects_of(account, board, numbers)), account)
