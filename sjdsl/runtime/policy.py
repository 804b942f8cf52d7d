"""Policies: functions `(key, observation [N, ...]) -> actions [N] int32` of one environment, with memory or without."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from jax import Array


@dataclass(frozen=True)
class MemoryPolicy:
    """A policy that remembers: `act(memory, key, observation) -> memory, actions`, from `start` at each episode's first step."""

    start: Any
    act: Callable[[Any, Array, Array], tuple[Any, Array]]


Policy = Callable[[Array, Array], Array] | MemoryPolicy


def with_memory(policy: Policy) -> MemoryPolicy:
    """Returns any policy as one with memory; a function's is empty."""
    if isinstance(policy, MemoryPolicy):
        return policy
    return MemoryPolicy((), lambda memory, key, observation: (memory, policy(key, observation)))
