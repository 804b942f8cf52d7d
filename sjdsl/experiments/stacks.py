"""Many policies as one program: networks of one shape are stacked, and each slot acts by its own."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from sjdsl.experiments.players import Player
from sjdsl.trainers.environment import Environment
from sjdsl.trainers.evaluation import Evaluation, make_evaluator
from sjdsl.trainers.policies import MemoryPolicy, with_memory

PlayLineup = Callable[[Array, Sequence[Player], np.ndarray], Evaluation]


@dataclass(frozen=True)
class Stack:
    """G players of one kind, of whom a line-up has M at most."""

    players: tuple[Player, ...]
    at_once: int

    @property
    def parameters(self) -> Any:
        """Leaves `[G, ...]`."""
        return jax.tree.map(lambda *leaves: jnp.stack(leaves), *(player.parameters for player in self.players))

    def example(self) -> MemoryPolicy:
        """Returns the policy of its first player: all start with the same memory and read the same."""
        return with_memory(self.players[0].policy_of(self.players[0].parameters))


@dataclass(frozen=True)
class Seats:
    """Who plays: of each stack the players `[M]` int32 that are computed, and the column of all of them that each member has, `[N]`."""

    chosen: tuple[np.ndarray, ...]
    columns: np.ndarray

    @property
    def alone(self) -> np.int32:
        """The column of the only player of a line-up; -1 where there are several."""
        return self.columns[0] if (self.columns == self.columns[0]).all() else np.int32(-1)


def make_stacks(lineups: Sequence[Sequence[Player]]) -> tuple[Stack, ...]:
    """Returns the players of line-ups, those of one kind together."""
    kinds: dict[Any, dict[Player, None]] = {}
    for player in (player for lineup in lineups for player in lineup):
        kinds.setdefault(player.kind, {})[player] = None
    most = {kind: max(len({player for player in lineup if player.kind == kind}) for lineup in lineups) for kind in kinds}
    return tuple(Stack(tuple(players), most[kind]) for kind, players in kinds.items())


def find_seats(stacks: Sequence[Stack], lineup: Sequence[Player]) -> Seats:
    """Returns where the members of a line-up are computed; a stack that has fewer than M of them computes its first player besides."""
    column_of: dict[Player, int] = {}
    chosen, first = [], 0
    for stack in stacks:
        present = [number for number, player in enumerate(stack.players) if player in lineup]
        column_of |= {stack.players[number]: first + place for place, number in enumerate(present)}
        chosen.append(np.array(present + [0] * (stack.at_once - len(present)), np.int32))
        first += stack.at_once
    return Seats(tuple(chosen), np.array([column_of[player] for player in lineup], np.int32))


def make_player_of_lineups(env: Environment, lineups: Sequence[Sequence[Player]], episodes: int) -> PlayLineup:
    """Returns a function that plays E episodes of one of the line-ups, and compiles once for all of them.

    Args:
      env: one environment of N agents.
      lineups: of N players each, all that are to be played.
    Returns:
      a function of a typed key, a line-up and the order `[E, N]` of its members' slots.
    """
    stacks = make_stacks(lineups)
    parameters = [stack.parameters for stack in stacks]
    evaluator = make_evaluator(env, lambda given: _seated(stacks, *given[:3]), episodes, memory_of=lambda given: _start(stacks, given[3]))

    def play(key: Array, lineup: Sequence[Player], order: np.ndarray) -> Evaluation:
        seats = find_seats(stacks, lineup)
        column_of_slot = np.empty_like(order)
        np.put_along_axis(column_of_slot, order, np.broadcast_to(seats.columns, order.shape), axis=1)
        return evaluator(key, (parameters, seats.chosen, seats.alone, column_of_slot))

    return play


def _start(stacks: Sequence[Stack], column_of_slot: Array) -> Any:
    """Returns the memory of all episodes before their first step: `[E, N]` columns, and each stack's, `[E, M, ...]`."""
    episodes = column_of_slot.shape[0]

    def of(stack: Stack) -> Any:
        return jax.tree.map(lambda leaf: jnp.broadcast_to(leaf, (episodes, stack.at_once, *jnp.shape(leaf))), stack.example().start)

    return column_of_slot, tuple(of(stack) for stack in stacks)


def _seated(stacks: Sequence[Stack], parameters: Sequence[Any], chosen: Sequence[Array], alone: Array) -> MemoryPolicy:
    """Returns the policy under which each slot acts by the column of its memory; every player says what all N agents would do.

    A column that is `alone` draws by the key itself, as the policy does in an evaluation: a mixture of one policy with itself is one.
    """
    examples = [stack.example() for stack in stacks]
    playing = [_of_players(leaves, own) for leaves, own in zip(parameters, chosen, strict=True)]
    number = sum(stack.at_once for stack in stacks)

    def act(memory: Any, key: Array, observation: Array, *given: Any) -> tuple[Any, Array]:
        allowed, state = seated.given(given)
        column_of_slot, memories = memory
        keys = _keys(key, number, alone)
        after, actions, first = [], [], 0
        for stack, example, own, before in zip(stacks, examples, playing, memories, strict=True):
            seen = (observation, *example.needs(allowed, state))
            own_keys = keys[first : first + stack.at_once]
            remembered, taken = _act_together(stack, own, before, own_keys, seen)
            after.append(remembered)
            actions.append(taken)
            first += stack.at_once
        by_column = jnp.concatenate(actions)
        return (column_of_slot, tuple(after)), jnp.take_along_axis(by_column, column_of_slot[None], axis=0)[0]

    seated = MemoryPolicy((), act, any(e.reads_allowed for e in examples), any(e.reads_state for e in examples))
    return seated


def _keys(key: Array, number: int, alone: Array) -> Array:
    """Returns a key for each column; that of a column that is `alone` is the key itself, and what the others draw is not used."""
    if number == 1:
        return key[None]
    words = jax.random.key_data(jax.random.split(key, number))
    mine = (jnp.arange(number) == alone)[:, None]
    chosen = jnp.where(mine, jax.random.key_data(key)[None], words)
    keys: Array = jax.random.wrap_key_data(chosen, impl=jax.random.key_impl(key))
    return keys


def _of_players(parameters: Any, chosen: Array) -> Any:
    """Returns the parameters `[M, ...]` of the players that are computed, of all `[G, ...]` of a stack."""
    return jax.tree.map(lambda leaf: leaf[chosen], parameters)


def _act_together(stack: Stack, parameters: Any, memory: Any, keys: Array, seen: tuple[Array, ...]) -> tuple[Any, Array]:
    """Returns the memory `[M, ...]` and the actions `[M, N]` of the M players of a stack that are computed."""

    def one(parameters: Any, memory: Any, key: Array) -> tuple[Any, Array]:
        after, actions = with_memory(stack.players[0].policy_of(parameters)).act(memory, key, *seen)
        return after, jnp.asarray(actions, jnp.int32)

    if stack.at_once == 1:  # a batch of one network would cost a loop over its convolutions
        own, before = jax.tree.map(lambda leaf: leaf[0], (parameters, memory))
        after, actions = one(own, before, keys[0])
        return jax.tree.map(lambda leaf: leaf[None], after), actions[None]
    after, actions = jax.vmap(one)(parameters, memory, keys)
    return after, actions
