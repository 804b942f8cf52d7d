"""Policies: functions `(key, observation [N, ...]) -> actions [N] int32` of one environment, with memory or without."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array


@dataclass(frozen=True)
class MemoryPolicy:
    """A policy that remembers: `act(memory, key, observation) -> memory, actions`, from `start` at each episode's first step.

    With `reads_allowed` it also gets the actions that the game allows: `act(memory, key, observation, allowed)`, `[N, A]` bool, of
    `env.allowed_actions(state)`. With `reads_state` the true state comes last: `act(memory, key, observation, state)`.
    """

    start: Any
    act: Callable[..., tuple[Any, Array]]
    reads_allowed: bool = False
    reads_state: bool = False

    def needs(self, allowed: Any, state: Any) -> tuple[Any, ...]:
        """Returns what its `act` reads besides memory, key and observation, in order."""
        return (
            *((allowed,) if self.reads_allowed else ()),
            *((state,) if self.reads_state else ()),
        )

    def given(self, needed: tuple[Any, ...]) -> tuple[Any, Any]:
        """Returns what is allowed and the state, of what `needs` gave; None for what was not needed."""
        return (needed[0] if self.reads_allowed else None), (
            needed[-1] if self.reads_state else None
        )


Policy = Callable[[Array, Array], Array] | MemoryPolicy


def with_memory(policy: Policy) -> MemoryPolicy:
    """Returns any policy as one with memory; a function's is empty."""
    if isinstance(policy, MemoryPolicy):
        return policy
    return MemoryPolicy((), lambda memory, key, observation: (memory, policy(key, observation)))


def take_actions(
    env: Any, policy: MemoryPolicy, memory: Any, key: Array, observation: Array, state: Any
) -> tuple[Any, Array]:
    """Returns the policy's memory and its actions `[N]` in a state of one environment; `observation` is what is seen of the state."""
    allowed = env.allowed_actions(state) if policy.reads_allowed else None
    return policy.act(memory, key, observation, *policy.needs(allowed, state))


def mixed_policy(num_agents: int, parts: Sequence[tuple[Sequence[int], Policy]]) -> MemoryPolicy:
    """Returns the policy under which the agents of each part act by its policy; those of no part take action 0.

    Args:
      parts: `(numbers of agents, policy)`. A policy sees the observations of all agents, and gives actions for all.
    """
    policies = [(list(agents), with_memory(policy)) for agents, policy in parts]
    reads_allowed = any(policy.reads_allowed for _, policy in policies)
    reads_state = any(policy.reads_state for _, policy in policies)

    def act(memory: Any, key: Array, observation: Array, *given: Any) -> tuple[Any, Array]:
        allowed, state = mixed.given(given)
        actions = jnp.zeros(num_agents, jnp.int32)
        after = []
        for (agents, policy), own, own_key in zip(
            policies, memory, jax.random.split(key, len(policies)), strict=True
        ):
            own, taken = policy.act(own, own_key, observation, *policy.needs(allowed, state))
            theirs = jnp.asarray(agents, jnp.int32)  # a part may be of nobody
            actions = actions.at[theirs].set(jnp.asarray(taken, jnp.int32)[theirs])
            after.append(own)
        return tuple(after), actions

    mixed = MemoryPolicy(
        tuple(policy.start for _, policy in policies), act, reads_allowed, reads_state
    )
    return mixed


def stay_policy(env: Any) -> Callable[[Array, Array], Array]:
    """Returns the policy that always stays. Raises ValueError if the game has no action `stay`."""
    if "stay" not in env.action_names:
        raise ValueError(
            f"{env.name} has no action `stay`; its actions are {', '.join(env.action_names)}"
        )
    stay = jnp.full(env.num_agents, list(env.action_names).index("stay"), jnp.int32)
    return lambda _key, _observation: stay


def random_policy(env: Any) -> Callable[[Array, Array], Array]:
    """Returns the policy that draws every action with equal probability."""
    return lambda key, _observation: jax.random.randint(
        key, (env.num_agents,), 0, env.num_actions, jnp.int32
    )


UNTRAINED = {
    "random": random_policy,
    "stay": stay_policy,
}  # by the names that they have wherever a policy is asked for
