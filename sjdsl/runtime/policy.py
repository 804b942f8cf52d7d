"""Policies: functions `(key, observation [N, ...]) -> actions [N] int32`, perhaps with memory."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array


def unchanged(memory: Any, actions: Array, reward: Array, info: Mapping[str, Any]) -> Any:
    """Returns a memory as it is, whatever came of the actions."""
    del actions, reward, info
    return memory


@dataclass(frozen=True)
class MemoryPolicy:
    """A policy with memory: `act(memory, key, observation) -> memory, actions`.

    start: the memory before each episode's first step.
    reads_allowed: whether `act` also gets the actions that the game allows, `[N, A]` bool, of
    `env.allowed_actions(state)`; reads_state: whether the true state is its last argument.
    after_step: `(memory, actions, reward, info) -> memory`, called after each step with what all
    agents did, `[N]` int32, and earned, `[N]` float32, and the step's info.
    traced: whether JAX can compile it; if not, as with a language model, only loops in Python call
    it, one episode at a time.
    """

    start: Any
    act: Callable[..., tuple[Any, Array]]
    reads_allowed: bool = False
    reads_state: bool = False
    after_step: Callable[[Any, Array, Array, Mapping[str, Any]], Any] = unchanged
    traced: bool = True

    def starts(self, *shape: int) -> Any:
        """Returns the memories before the first step of many episodes: leaves `[*shape, ...]`."""

        def repeated(leaf: Any) -> Array:
            return jnp.broadcast_to(leaf, (*shape, *jnp.shape(leaf)))

        return jax.tree.map(repeated, self.start)

    def needs(self, allowed: Any, state: Any) -> tuple[Any, ...]:
        """Returns the arguments of `act` behind memory, key and observation."""
        arguments = []
        if self.reads_allowed:
            arguments.append(allowed)
        if self.reads_state:
            arguments.append(state)
        return tuple(arguments)

    def given(self, needed: tuple[Any, ...]) -> tuple[Any, Any]:
        """Returns the allowed actions and the state among what `needs` returned, None without."""
        allowed = needed[0] if self.reads_allowed else None
        state = needed[-1] if self.reads_state else None
        return allowed, state


Policy = Callable[[Array, Array], Array] | MemoryPolicy


def with_memory(policy: Policy) -> MemoryPolicy:
    """Returns any policy as one with memory; that of a function is empty."""
    if isinstance(policy, MemoryPolicy):
        return policy
    return MemoryPolicy((), lambda memory, key, observation: (memory, policy(key, observation)))


def compiled_actions(
    env: Any, policy: MemoryPolicy
) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Returns `take_actions` and `after_step` of a policy, compiled if it can be."""
    act = partial(take_actions, env, policy)
    if not policy.traced:
        return act, policy.after_step
    return jax.jit(act), jax.jit(policy.after_step)


def take_actions(
    env: Any, policy: MemoryPolicy, memory: Any, key: Array, observation: Array, state: Any
) -> tuple[Any, Array]:
    """Returns a policy's new memory and its actions `[N]`, from a state and its observation."""
    allowed = env.allowed_actions(state) if policy.reads_allowed else None
    return policy.act(memory, key, observation, *policy.needs(allowed, state))


def mixed_policy(num_agents: int, parts: Sequence[tuple[Sequence[int], Policy]]) -> MemoryPolicy:
    """Returns a policy in which the agents of each part follow the part's policy.

    Agents of no part take action 0.

    Args:
      parts: `(numbers of agents, policy)`; a policy gets the observations of all agents, and
        returns actions of all.
    """
    policies = [(list(agents), with_memory(policy)) for agents, policy in parts]
    reads_allowed = any(policy.reads_allowed for _, policy in policies)
    reads_state = any(policy.reads_state for _, policy in policies)

    def act(memory: Any, key: Array, observation: Array, *needed: Any) -> tuple[Any, Array]:
        """Lets each part act, and takes of its actions those of its agents."""
        allowed, state = mixed.given(needed)
        actions = jnp.zeros(num_agents, jnp.int32)
        keys = jax.random.split(key, len(policies))
        memories = []
        for (agents, policy), part, part_key in zip(policies, memory, keys, strict=True):
            arguments = policy.needs(allowed, state)
            part, of_all = policy.act(part, part_key, observation, *arguments)
            numbers = jnp.asarray(agents, jnp.int32)  # perhaps none
            actions = actions.at[numbers].set(jnp.asarray(of_all, jnp.int32)[numbers])
            memories.append(part)
        return tuple(memories), actions

    def after_step(memory: Any, actions: Array, reward: Array, info: Mapping[str, Any]) -> Any:
        return tuple(
            policy.after_step(part, actions, reward, info)
            for (_, policy), part in zip(policies, memory, strict=True)
        )

    start = tuple(policy.start for _, policy in policies)
    mixed = MemoryPolicy(start, act, reads_allowed, reads_state, after_step)
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


# By the names that commands and functions accept.
UNTRAINED = {"random": random_policy, "stay": stay_policy}
