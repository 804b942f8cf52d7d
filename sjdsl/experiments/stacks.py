"""Many policies as one program: networks of one shape are stacked, and each slot acts by its own
parameters.
"""

import operator
from collections import Counter
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from sjdsl.experiments.players import Player
from sjdsl.models import HostPolicy
from sjdsl.models import Seats as AskedSeats
from sjdsl.models.asking import Ask
from sjdsl.trainers.environment import Environment
from sjdsl.trainers.policies.evaluation import (
    Evaluation,
    Tape,
    make_evaluator,
    make_host_evaluator,
)
from sjdsl.trainers.policies.loading import MemoryPolicy, with_memory

PlayLineup = Callable[
    [Array, Sequence[Player], np.ndarray, Ask, int], tuple[Evaluation, Tape | None]
]


@dataclass(frozen=True)
class Stack:
    """G players of one kind, of which a line-up has at most M."""

    players: tuple[Player, ...]
    at_once: int

    @property
    def parameters(self) -> Any:
        """The parameters of all players, stacked: leaves `[G, ...]`."""
        parameters = [player.parameters for player in self.players]
        return jax.tree.map(lambda *leaves: jnp.stack(leaves), *parameters)

    def policy(self, parameters: Any) -> MemoryPolicy:
        """Returns the policy of the player with these parameters."""
        return with_memory(self.players[0].policy_of(parameters))

    def example(self) -> MemoryPolicy:
        """Returns the policy of its first player.

        All its players have the same initial memory and read the same inputs.
        """
        return self.policy(self.players[0].parameters)


@dataclass(frozen=True)
class Seats:
    """Where the members of a line-up are computed.

    The players that are computed, those of all stacks one after the other, are columns.
    """

    chosen: tuple[np.ndarray, ...]  # [M] int32 of each stack: the players that are computed
    columns: np.ndarray  # [N] int32: the column of each member

    @property
    def only_column(self) -> np.int32:
        """The column of the only player of a line-up; -1 if there are several players."""
        return self.columns[0] if (self.columns == self.columns[0]).all() else np.int32(-1)


def make_stacks(lineups: Sequence[Sequence[Player]]) -> tuple[Stack, ...]:
    """Returns the players of all line-ups, those of one kind together."""
    kinds: dict[Hashable, dict[Player, None]] = {}
    at_once: Counter[Hashable] = Counter()
    for lineup in lineups:
        distinct = dict.fromkeys(lineup)
        for player in distinct:
            kinds.setdefault(player.kind, {})[player] = None
        at_once |= Counter(player.kind for player in distinct)  # keeps the larger count
    return tuple(Stack(tuple(players), at_once[kind]) for kind, players in kinds.items())


def find_seats(stacks: Sequence[Stack], lineup: Sequence[Player]) -> Seats:
    """Returns where the members of a line-up are computed.

    A stack with fewer than M of them computes its first player in the columns that are left.
    """
    column_of: dict[Player, int] = {}
    chosen = []
    first_column = 0
    for stack in stacks:
        players = np.zeros(stack.at_once, np.int32)
        in_lineup = [index for index, player in enumerate(stack.players) if player in lineup]
        players[: len(in_lineup)] = in_lineup
        chosen.append(players)
        for column, index in enumerate(in_lineup, first_column):
            column_of[stack.players[index]] = column
        first_column += stack.at_once
    return Seats(tuple(chosen), np.array([column_of[player] for player in lineup], np.int32))


def make_player_of_lineups(
    env: Environment, lineups: Sequence[Sequence[Player]], episodes: int
) -> PlayLineup:
    """Returns a function that plays E episodes of one of the line-ups, compiled once for all of
    them.

    Args:
      env: one environment of N agents.
      lineups: all line-ups to be played, N players each.
    Returns:
      a function of a typed key, a line-up and the slots `[E, N]` of its members, and of how those
      are asked who are asked in words: `Seats`' `ask` and `parallel`.
    """
    stacks = make_stacks(lineups)
    parameters = [stack.parameters for stack in stacks]

    def initial_memory(arguments: Any) -> Any:
        """Returns the memory of all episodes before their first step.

        It is the column `[E, N]` of each slot, and the memory `[E, M, ...]` of each stack.
        """
        *_, column_of_slot = arguments
        memories = tuple(stack.example().starts(episodes, stack.at_once) for stack in stacks)
        return column_of_slot, memories

    def policy_of(arguments: Any) -> MemoryPolicy:
        return _lineup_policy(stacks, *arguments[:3])

    evaluator = make_evaluator(env, policy_of, episodes, initial_memory)
    host_evaluator = make_host_evaluator(env, policy_of, episodes, initial_memory)

    def play(
        key: Array, lineup: Sequence[Player], order: np.ndarray, ask: Ask, parallel: int
    ) -> tuple[Evaluation, Tape | None]:
        """Plays a line-up; returns a tape if somebody is asked in words.

        order: `[E, N]`, the slot of each member in each episode.
        """
        seats = find_seats(stacks, lineup)
        column_of_slot = np.empty_like(order)
        columns = np.broadcast_to(seats.columns, order.shape)
        np.put_along_axis(column_of_slot, order, columns, axis=1)
        arguments = (parameters, seats.chosen, seats.only_column, column_of_slot)
        hosts = find_hosts(lineup, order)
        if not any(hosts):
            return evaluator(key, arguments), None
        with AskedSeats(env, hosts, ask, parallel) as asked:
            return host_evaluator(key, arguments, asked)

    return play


def find_hosts(lineup: Sequence[Player], order: np.ndarray) -> list[dict[int, HostPolicy]]:
    """Returns for each episode the policies of the slots that are asked in words."""
    return [
        {int(slots[member]): player.host for member, player in enumerate(lineup) if player.host}
        for slots in order
    ]


def _lineup_policy(
    stacks: Sequence[Stack], parameters: Sequence[Any], chosen: Sequence[Array], only_column: Array
) -> MemoryPolicy:
    """Returns the policy of a line-up: each slot takes the action of the column in its memory.

    Every column computes actions for all N agents. The only player of a line-up draws with the key
    itself, so that a policy mixed with itself acts as it does in an evaluation.

    Args:
      parameters: of all players of each stack.
      chosen, only_column: those of `Seats`.
    """
    examples = [stack.example() for stack in stacks]
    chosen_parameters = [
        jax.tree.map(operator.itemgetter(players), leaves)
        for leaves, players in zip(parameters, chosen, strict=True)
    ]
    num_columns = sum(stack.at_once for stack in stacks)

    def act(memory: Any, key: Array, observation: Array, *needed: Any) -> tuple[Any, Array]:
        """Returns the memories of all stacks and the action of each slot, `[N]`: of its column."""
        allowed, state = policy.given(needed)
        column_of_slot, memories = memory
        keys = _keys_of_columns(key, num_columns, only_column)
        next_memories = []
        actions = []
        first = 0
        for index, stack in enumerate(stacks):
            inputs = (observation, *examples[index].needs(allowed, state))
            stack_keys = keys[first : first + stack.at_once]
            next_memory, stack_actions = _act_together(
                stack, chosen_parameters[index], memories[index], stack_keys, inputs
            )
            next_memories.append(next_memory)
            actions.append(stack_actions)
            first += stack.at_once
        by_column = jnp.concatenate(actions)
        by_slot = jnp.take_along_axis(by_column, column_of_slot[None], axis=0)[0]
        return (column_of_slot, tuple(next_memories)), by_slot

    def after_step(memory: Any, actions: Array, reward: Array, info: Mapping[str, Any]) -> Any:
        """Returns the memories of all stacks after a step."""
        column_of_slot, memories = memory
        next_memories = [
            _tell_together(stack, of_stack, part, (actions, reward, info))
            for stack, of_stack, part in zip(stacks, chosen_parameters, memories, strict=True)
        ]
        return column_of_slot, tuple(next_memories)

    policy = MemoryPolicy(
        (),
        act,
        after_step=after_step,
        reads_allowed=any(example.reads_allowed for example in examples),
        reads_state=any(example.reads_state for example in examples),
    )
    return policy


def _keys_of_columns(key: Array, num_columns: int, only_column: Array) -> Array:
    """Returns a key for each column; `only_column` has the key itself, and then the others aren't
    used.
    """
    if num_columns == 1:
        return key[None]
    split_bits = jax.random.key_data(jax.random.split(key, num_columns))
    is_only = (jnp.arange(num_columns) == only_column)[:, None]
    bits = jnp.where(is_only, jax.random.key_data(key)[None], split_bits)
    keys: Array = jax.random.wrap_key_data(bits, impl=jax.random.key_impl(key))
    return keys


def _act_together(
    stack: Stack, parameters: Any, memory: Any, keys: Array, inputs: tuple[Array, ...]
) -> tuple[Any, Array]:
    """Returns the next memory `[M, ...]` and the actions `[M, N]` of the M computed players of a
    stack.
    """

    def act_alone(parameters: Any, memory: Any, key: Array) -> tuple[Any, Array]:
        next_memory, actions = stack.policy(parameters).act(memory, key, *inputs)
        return next_memory, jnp.asarray(actions, jnp.int32)

    result: tuple[Any, Array] = _of_each(stack, act_alone, parameters, memory, keys)
    return result


def _tell_together(stack: Stack, parameters: Any, memory: Any, outcome: tuple[Any, ...]) -> Any:
    """Returns the memory `[M, ...]` of the M computed players of a stack after a step.

    Args:
      outcome: the actions, rewards and info of the step.
    """

    def tell_alone(parameters: Any, memory: Any) -> Any:
        return stack.policy(parameters).after_step(memory, *outcome)

    return _of_each(stack, tell_alone, parameters, memory)


def _of_each(stack: Stack, function: Callable[..., Any], *arguments: Any) -> Any:
    """Returns a function's results for each of the M computed players of a stack, `[M, ...]`.

    Args:
      arguments: leaves `[M, ...]`.
    """
    if stack.at_once > 1:
        return jax.vmap(function)(*arguments)
    # vmap over a single network would turn its convolutions into a loop.
    result = function(*jax.tree.map(operator.itemgetter(0), arguments))
    return jax.tree.map(lambda leaf: leaf[None], result)
