"""Plays an episode on the reference interpreter and keeps an account of every step.

The draws are those of the compiled game: a trace of a seed is the episode that `sjdsl render` shows for the same seed.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

from sjdsl.compiler import ir
from sjdsl.interpreter.account import Account, Tell
from sjdsl.interpreter.board import Board, board_of
from sjdsl.interpreter.state import Outcome, Value, World, copied
from sjdsl.interpreter.step import action_mask, reset, step
from sjdsl.interpreter.threefry import Threefry
from sjdsl.trace.effects import Effect, effects_of
from sjdsl.trace.jax_random import Key, RecordedDraws, key_of, random_numbers, split

Choose = Callable[[int, Key, World], list[int]]  # number of the step in the trace, a key for it, state -> an action for each agent


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


def random_actions(game: ir.Game) -> Choose:
    """Returns the policy that draws every action with equal probability."""
    return lambda _number, key, _world: random_numbers(key, game.agents.number, len(game.agents.actions))


def play(game: ir.Game, params: Mapping[str, Value], seed: int, steps: int, choose: Choose) -> Iterator[Moment]:
    """Yields the start and so many steps; after the end of an episode comes the start of the next."""
    key, reset_key = split(key_of(seed), 2)
    moment = begin(game, params, reset_key)
    yield moment
    for number in range(steps):
        key, action_key, step_key, reset_key = split(key, 4)
        moment = follow(game, moment.world, params, step_key, choose(number, action_key, moment.world))
        yield moment
        ended = moment.outcome is not None and (moment.outcome.terminated or moment.outcome.truncated)
        if ended and number + 1 < steps:
            moment = begin(game, params, reset_key)
            yield moment


def begin(game: ir.Game, params: Mapping[str, Value], key: Key) -> Moment:
    """Returns the start of an episode. `key`: that of the environment's `reset`."""
    told: list[Told] = []
    recorded = RecordedDraws(Threefry(*key))
    world = reset(game, params, recorded, _listener(told, board_of(game), recorded))
    return Moment(None, key, copied(world), tuple(told))


def follow(game: ir.Game, world: World, params: Mapping[str, Value], key: Key, actions: list[int]) -> Moment:
    """Returns the step that follows a state. `key`: that of the environment's `step`."""
    told: list[Told] = []
    recorded = RecordedDraws(Threefry(*key))
    allowed = action_mask(game, world)
    forbidden = frozenset(agent for agent, action in enumerate(actions) if not allowed[agent][action])
    after, outcome = step(game, world, actions, params, recorded, _listener(told, board_of(game), recorded))
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
