"""Policies to play with: random ones, trained ones, stored ones."""

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.policy import MemoryPolicy, Policy, with_memory

from .actor_critics import make_actor_critics
from .config import Config, PPOConfig, VDNConfig
from .environment import Environment, abstract_key, reset_shapes
from .masks import masked, wants_masks
from .policy_file import PolicyError, policy_path, read_policy
from .vdn import best_action, explore, make_action_values

__all__ = ["MemoryPolicy", "Policy", "PolicyError", "load_policy", "random_policy", "trained_policy", "with_memory"]


def random_policy(env: Environment) -> Callable[[Array, Array], Array]:
    """Returns the policy that draws every action with equal probability."""

    def act(key: Array, observation: Array) -> Array:
        del observation
        return jax.random.randint(key, (env.num_agents,), 0, env.num_actions, jnp.int32)

    return act


def trained_policy(env: Environment, config: Config, parameters: Any, greedy: bool | None = None) -> Policy:
    """Returns the policy of `parameters`.

    Args:
      greedy: take the best action instead of drawing one. None: as what was learnt is meant to act: actors, which learn probabilities,
        draw their actions; action values have none, and the best is taken. Values with `greedy=False` explore as the run did at its end.
    """
    match config:
        case PPOConfig():
            return _actor_policy(env, config, parameters, bool(greedy))
        case VDNConfig():
            return _value_policy(env, config, parameters, greedy is None or greedy)
    raise TypeError(f"no algorithm takes a {type(config).__name__}")


def _actor_policy(env: Environment, config: PPOConfig, parameters: Any, greedy: bool) -> Policy:
    networks = make_actor_critics(env, config)
    # a critic is not asked; one that sees the state gets zeros
    state = jnp.zeros((1, 1, *networks.joint_shape)) if networks.joint_shape and networks.from_state else None

    def act(memory: Any, key: Array, observation: Array, allowed: Array | None) -> tuple[Any, Array]:
        never_fresh = jnp.zeros((1, 1), bool)  # an episode starts with `start`
        memory, logits, _ = networks.apply(parameters, memory, observation[None, None], state, never_fresh)
        likes = masked(logits[0, 0], allowed)
        action = jnp.argmax(likes, axis=-1) if greedy else jax.random.categorical(key, likes)
        return memory, action.astype(jnp.int32)

    return _policy(networks.start_memory(1), act, networks.masks)


def _value_policy(env: Environment, config: VDNConfig, parameters: Any, greedy: bool) -> Policy:
    network = make_action_values(env, config)

    def act(memory: Any, key: Array, observation: Array, allowed: Array | None) -> tuple[Any, Array]:
        values = network.apply(parameters, observation)
        return memory, best_action(values, allowed) if greedy else explore(key, values, allowed, config.epsilon_end)

    return _policy((), act, wants_masks(env, config))


def _policy(start: Any, act: Callable[[Any, Array, Array, Array | None], tuple[Any, Array]], reads_allowed: bool) -> Policy:
    """Returns the simplest form of a policy: a function of key and observation if it neither remembers nor reads what is allowed."""
    if reads_allowed:
        return MemoryPolicy(start, act, reads_allowed=True)
    if jax.tree.leaves(start):
        return MemoryPolicy(start, lambda memory, key, observation: act(memory, key, observation, None))
    return lambda key, observation: act(start, key, observation, None)[1]


def parameter_shapes(env: Environment, config: Config) -> Any:
    """Returns the shapes and dtypes of the parameters that a configuration's policy has."""
    match config:
        case PPOConfig():
            networks = make_actor_critics(env, config)
            return jax.eval_shape(lambda key: networks.init(key, env), abstract_key())
        case VDNConfig():
            return jax.eval_shape(make_action_values(env, config).init, abstract_key(), reset_shapes(env)[0])
    raise TypeError(f"no algorithm takes a {type(config).__name__}")


def load_policy(source: Path | str, env: Environment, update: int | None = None, greedy: bool | None = None, which: str = "last") -> Policy:
    """Returns a stored policy.

    Args:
      source: the folder of a run, or one of the `.safetensors` files in its `policies`, with the `.json` file beside it.
      env: environment to act in; it must have the actions and observation planes of the one trained on. Another
        variant or other parameters are allowed, with a warning.
      update: of a folder, the policy of one of its checkpoints.
      greedy: take the best action, or draw one; None: as the algorithm is meant to act, see `trained_policy`.
      which: of a folder, `last` or `best`, by its evaluations.
    Raises:
      PolicyError: no such policy, or it cannot be read, or it does not fit `env`.
    """
    path = policy_path(Path(source), which if update is None else update)
    parameters, described = read_policy(path, lambda config: parameter_shapes(env, config))
    game = described.game
    if game["hash"] != env.hash:
        warnings.warn(
            f"{path} was trained on another form of the game: {game['name']} {game['hash']}, not {env.name} {env.hash}", stacklevel=2
        )
    if parameters is None:
        raise PolicyError(
            f"{path} does not fit {env.name}: it was trained on {game['name']} with "
            f"{len(game['action_names'])} actions and observations {game['observation_shape']}; "
            f"here are {env.num_actions} actions and observations {list(reset_shapes(env)[0].shape)}"
        )
    return trained_policy(env, described.config, parameters, greedy)
