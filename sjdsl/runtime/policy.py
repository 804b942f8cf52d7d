"""Policies: functions `(key, observation [N, ...]) -> actions [N] int32` of one environment, with memory or without."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from jax import Array


@dataclass(frozen=True)
class MemoryPolicy:
    """A policy that remembers: `act(memory, key, observation) -> memory, actions`, from `start` at each episode's first step.

    One that `reads_allowed` is told besides which actions the game allows: `act(memory, key, observation, allowed)`, `[N, A]` bool, of
    `env.allowed_actions(state)`.
    """

    start: Any
    act: Callable[..., tuple[Any, Array]]
    reads_allowed: bool = False


Policy = Callable[[Array, Array], Array] | MemoryPolicy


def with_memory(policy: Policy) -> MemoryPolicy:
    """Returns any policy as one with memory; a function's is empty."""
    if isinstance(policy, MemoryPolicy):
        return policy
    return MemoryPolicy((), lambda memory, key, observation: (memory, policy(key, observation)))


def take_actions(env: Any, policy: MemoryPolicy, memory: Any, key: Array, observation: Array, state: Any) -> tuple[Any, Array]:
    """Returns the policy's memory and its actions `[N]` in a state of one environment; `observation` is what is seen of the state."""
    allowed = (env.allowed_actions(state),) if policy.reads_allowed else ()
    return policy.act(memory, key, observation, *allowed)
