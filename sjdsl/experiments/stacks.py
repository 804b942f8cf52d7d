"""Many policies as one program: networks of one shape are stacked, and each slot acts by its own parameters."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from sjdsl.experiments.players import Player
from sjdsl.trainers.environment import Environment
from sjdsl.trainers.policies.evaluation import Evaluation, make_evaluator
from sjdsl.trainers.policies.loading import MemoryPolicy, with_memory

PlayLineup = Callable[[Array, Sequence[Player], np.ndarray], Evaluation]


@dataclass(frozen=True)
class Stack:
    """G players of one kind, of which a line-up has at most M."""

    players: tuple[Player, ...]
    at_once: int

    @property
    def parameters(self) -> Any:
        """Leaves `[G, ...]`."""
        return jax.tree.map(
            lambda *leaves: jnp.stack(leaves), *(player.parameters for player in self.players)
        )

    def example(self) -> MemoryPolicy:
        """Returns the policy of its first player: all have the same initial memory and read the same inputs."""
        return with_memory(self.players[0].policy_of(self.players[0].parameters))


@dataclass(frozen=True)
class Seats:
    """Who plays: the players `[M]` int32 of each stack that are computed, and the column `[N]` of each member among all of them."""

    chosen: tuple[np.ndarray, ...]
    columns: np.ndarray

    @property
    def alone(self) -> np.int32:
        """The column of the only player of a line-up; -1 if there are several."""
        return self.columns[0] if (self.columns == self.columns[0]).all() else np.int32(-1)


def make_stacks(lineups: Sequence[Sequence[Player]]) -> tuple[Stack, ...]:
    """Returns the players of all line-ups, those of one kind together."""
    kinds: dict[Any, dict[Player, None]] = {}
    for player in (player for lineup in lineups for player in lineup):
        kinds.setdefault(player.kind, {})[player] = None
    most = {
        kind: max(len({player for player in lineup if player.kind == kind}) for lineup in lineups)
        for kind in kinds
    }
    return tuple(Stack(tuple(players), most[kind]) for kind, players in kinds.items())


def find_seats(stacks: Sequence[Stack], lineup: Sequence[Player]) -> Seats:
    """Returns where the members of a line-up are computed; a stack with fewer than M of them also computes its first player."""
    column_of: dict[Player, int] = {}
    chosen, first = [], 0
    for stack in stacks:
        present = [number for number, player in enumerate(stack.players) if player in lineup]
        column_of |= {stack.players[number]: first + place for place, number in enumerate(present)}
        chosen.append(np.array(present + [0] * (stack.at_once - len(present)), np.int32))
        first += stack.at_once
    return Seats(tuple(chosen), np.array([column_of[player] for player in lineup], np.int32))


def make_player_of_lineups(
    env: Environment, lineups: Sequence[Sequence[Player]], episodes: int
) -> PlayLineup:
    """Returns a function that plays E episodes of one of the line-ups, compiled once for all of them.

    Args:
      env: one environment of N agents.
      lineups: all line-ups to be played, N players each.
    Returns:
      a function of a typed key, a line-up and the slots `[E, N]` of its members.
    """
    stacks = make_stacks(lineups)
    parameters = [stack.parameters for stack in stacks]

    def start(given: Any) -> Any:
        """Returns the memory of all episodes before their first step: `[E, N]` columns, and the memory `[E, M, ...]` of each stack."""
        column_of_slot = given[3]

        def of(stack: Stack) -> Any:
            return jax.tree.map(
                lambda leaf: jnp.broadcast_to(leaf, (episodes, stack.at_once, *jnp.shape(leaf))),
                stack.example().start,
            )

        return column_of_slot, tuple(of(stack) for stack in stacks)

    evaluator = make_evaluator(
        env, lambda given: _seated(stacks, *given[:3]), episodes, memory_of=start
    )

    def play(key: Array, lineup: Sequence[Player], order: np.ndarray) -> Evaluation:
        seats = find_seats(stacks, lineup)
        column_of_slot = np.empty_like(order)
        np.put_along_axis(
            column_of_slot, order, np.broadcast_to(seats.columns, order.shape), axis=1
        )
        return evaluator(key, (parameters, seats.chosen, seats.alone, column_of_slot))

    return play


def _seated(
    stacks: Sequence[Stack], parameters: Sequence[Any], chosen: Sequence[Array], alone: Array
) -> MemoryPolicy:
    """Returns the policy in which each slot acts by the column in its memory; every player computes actions for all N agents.

    A player that is `alone` draws with the key itself, so that a policy mixed with itself acts as it does in an evaluation.
    """
    examples = [stack.example() for stack in stacks]
    playing = [
        jax.tree.map(lambda leaf, own=own: leaf[own], leaves)
        for leaves, own in zip(parameters, chosen, strict=True)
    ]
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
        return (column_of_slot, tuple(after)), jnp.take_along_axis(
            by_column, column_of_slot[None], axis=0
        )[0]

    seated = MemoryPolicy(
        (), act, any(e.reads_allowed for e in examples), any(e.reads_state for e in examples)
    )
    return seated


def _keys(key: Array, number: int, alone: Array) -> Array:
    """Returns a key for each column; for the column `alone` it is the key itself, and the draws of the others are not used."""
    if number == 1:
        return key[None]
    words = jax.random.key_data(jax.random.split(key, number))
    mine = (jnp.arange(number) == alone)[:, None]
    chosen = jnp.where(mine, jax.random.key_data(key)[None], words)
    keys: Array = jax.random.wrap_key_data(chosen, impl=jax.random.key_impl(key))
    return keys


def _act_together(
    stack: Stack, parameters: Any, memory: Any, keys: Array, seen: tuple[Array, ...]
) -> tuple[Any, Array]:
    """Returns the next memory `[M, ...]` and the actions `[M, N]` of the M computed players of a stack."""

    def one(parameters: Any, memory: Any, key: Array) -> tuple[Any, Array]:
        after, actions = with_memory(stack.players[0].policy_of(parameters)).act(memory, key, *seen)
        return after, jnp.asarray(actions, jnp.int32)

    if stack.at_once == 1:  # vmap over a single network would turn its convolutions into a loop
        own, before = jax.tree.map(lambda leaf: leaf[0], (parameters, memory))
        after, actions = one(own, before, keys[0])
        return jax.tree.map(lambda leaf: leaf[None], after), actions[None]
    after, actions = jax.vmap(one)(parameters, memory, keys)
    return after, actions
