"""How a rollout divides into minibatches: which of its steps a gradient step learns from."""

import math
from functools import partial

import jax
import jax.numpy as jnp
from jax import Array

from ..devices.data_parallel import own_keys, own_share
from ..settings.config import ConfigError, PPOConfig, VDNConfig


def check_minibatches(config: PPOConfig | VDNConfig) -> None:
    """Raises ConfigError if the rollout doesn't divide into minibatches, or a minibatch into devices."""
    devices = len(jax.devices())
    if not _remembers(config):
        if config.steps_per_update % config.num_minibatches:
            raise ConfigError(
                f"num_envs x num_steps = {config.num_envs} x {config.num_steps} = {config.steps_per_update} steps cannot be split "
                f"into num_minibatches = {config.num_minibatches} equal parts"
            )
    elif config.num_envs % config.num_minibatches:
        raise ConfigError(
            f"networks with memory learn from whole rollouts: num_envs = {config.num_envs} cannot be split into "
            f"num_minibatches = {config.num_minibatches} equal parts; the largest that works is {max(config.num_envs // devices, 1)}"
        )
    size = minibatch_size(config)
    if size % devices:
        raise ConfigError(
            f"a minibatch of {size} {'environments' if _remembers(config) else 'steps'} cannot be spread over {devices} devices; "
            "choose num_minibatches so that it is a multiple"
        )


def minibatch_size(config: PPOConfig | VDNConfig) -> int:
    """Returns the number of sequences in a minibatch: steps, or whole rollouts for networks with memory."""
    return (
        config.num_envs if _remembers(config) else config.steps_per_update
    ) // config.num_minibatches


def _remembers(config: PPOConfig | VDNConfig) -> bool:
    return isinstance(config, PPOConfig) and config.memory != "none"


def draw_orders(key: Array, number: int, config: PPOConfig | VDNConfig) -> Array:
    """Returns the sequences of each minibatch, `[G, epochs, minibatches, m]` int32: all of them once an epoch, in a new order.

    Environments are divided into the most groups that divide a minibatch too, and a minibatch has equally many sequences of each group, so
    the order doesn't depend on the number of devices. On several devices, the sequences are those of this device's environments.
    """
    groups = math.gcd(config.num_envs, minibatch_size(config))
    keys = jax.vmap(lambda own: jax.random.split(own, (number, config.num_epochs)))(
        own_keys(key, own_share(groups))
    )
    envs, sequences = (
        config.num_envs // groups,
        minibatch_size(config) * config.num_minibatches // groups,
    )  # of a group
    draw = partial(jax.random.permutation, x=jnp.arange(sequences, dtype=jnp.int32))
    step, env = jnp.divmod(jax.vmap(jax.vmap(jax.vmap(draw)))(keys), envs)
    orders = (
        step * len(keys) + jnp.arange(len(keys))[:, None, None, None]
    ) * envs + env  # steps one after another, each of all environments
    orders = orders.reshape(*keys.shape, config.num_minibatches, -1)
    return jnp.moveaxis(orders, 0, 3).reshape(number, config.num_epochs, config.num_minibatches, -1)
