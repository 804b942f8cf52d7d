"""The parts of an update that no run computes alone: a rollout without a network, and a count of the networks' operations."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.env import Environment
from sjdsl.trainers.actor_critics import make_actor_critics, packing_of
from sjdsl.trainers.config import Config, PPOConfig, VDNConfig
from sjdsl.trainers.masks import allowed_in, pack_mask, wants_masks
from sjdsl.trainers.ppo import Acting
from sjdsl.trainers.rollout import Actor, Worlds, collect_rollout
from sjdsl.trainers.shaping import make_shaping
from sjdsl.trainers.vdn import make_action_values


def idle_rollout(env: Environment, config: Config) -> Callable[[Worlds, Array], Any]:
    """Returns a function of worlds and a key that plays agents without a network: it costs what the environments cost."""
    shape = (config.num_envs, env.num_agents)
    packing = packing_of(env)
    masks = wants_masks(env, config)
    keeps: Any = Acting(jnp.zeros(shape), jnp.zeros(shape)) if isinstance(config, PPOConfig) else None

    def act(worlds: Worlds, joint: Any, key: Array) -> tuple[Any, Array, Any]:
        del joint
        return worlds.memory, jax.random.randint(key, shape, 0, env.num_actions, jnp.int32), keeps

    def follow(memory: Any, observation: Array, info: dict[str, Any]) -> Any:
        del memory, observation
        if isinstance(config, PPOConfig):
            return jnp.zeros(shape)
        return packing.pack(info["terminal_observation"]), pack_mask(allowed_in(env, masks, info.get("terminal_state")))

    actor = Actor(act, packing.pack, follow)
    shaping = make_shaping(config, env.num_agents)
    return lambda worlds, key: collect_rollout(env, actor, worlds, key, config.num_steps, shaping)[1]


def flops_of(env: Environment, config: Config, parameters: Any) -> float:
    """Returns the floating-point operations of the networks in an update, acting and learning."""
    return _flops_of_vdn(env, config, parameters) if isinstance(config, VDNConfig) else _flops_of_ppo(env, config, parameters)


def _flops_of_ppo(env: Environment, config: Any, parameters: Any) -> float:
    """A forward pass each step and one at the end, then the gradient steps."""
    networks = make_actor_critics(env, config)

    def forward(parameters: Any, steps: int) -> Array:
        """The networks on so many steps, of one environment or of several: that makes no difference here."""
        seen = jnp.zeros((1, steps, *env.observation_shape), jnp.uint8)
        _, logits, values = networks.apply(parameters, networks.start_memory(steps), seen, None, jnp.zeros((1, steps), bool))
        return logits.sum() + values.sum()

    minibatch = config.steps_per_update // config.num_minibatches
    acting = _flops(lambda own: forward(own, config.num_envs), parameters)
    learning = _flops(jax.grad(lambda own: forward(own, minibatch)), parameters)
    result: float = acting * (config.num_steps + 1) + learning * config.num_epochs * config.num_minibatches
    return result


def _flops_of_vdn(env: Environment, config: VDNConfig, parameters: Any) -> float:
    """A forward pass each step; in each gradient step one with its gradient, and one of the target network; with `double_q` another."""
    network = make_action_values(env, config)

    def forward(parameters: Any, steps: int) -> Array:
        values: Any = network.apply(parameters, jnp.zeros((steps, *env.observation_shape), jnp.uint8))
        result: Array = values.sum()
        return result

    acting = _flops(lambda own: forward(own, config.num_envs), parameters)
    learning = _flops(jax.grad(lambda own: forward(own, config.batch_size)), parameters)
    target = _flops(lambda own: forward(own, config.batch_size), parameters)
    return acting * config.num_steps + (learning + target * (1 + config.double_q)) * config.gradient_steps


def _flops(function: Callable[..., Any], parameters: Any) -> float:
    """Returns XLA's count for the program of a GPU, whatever device there is: that of a CPU has loops, which are counted as one turn."""
    analysis: Any = jax.jit(function).trace(parameters).lower(lowering_platforms=("cuda",)).cost_analysis()
    return float(analysis["flops"])
