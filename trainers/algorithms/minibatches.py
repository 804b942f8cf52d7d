"""How a rollout divides into minibatches: which of its steps a gradient step learns from."""

import math
from functools import partial

import jax
import jax.numpy as jnp
from jax import Array

from ..devices.data_parallel import own_keys, own_share
from ..settings.config import ConfigError, PPOConfig, VDNConfig


def check_minibatches(config: PPOConfig | VDNConfig) -> None:
    """Raises ConfigError if the rollout doesn't divide into minibatches, or these into devices."""
    devices = len(jax.devices())
    parts = config.num_minibatches
    sequences = _num_sequences(config)
    if sequences % (parts * devices) == 0:
        return
    steps = f"num_envs x num_steps = {config.num_envs} x {config.num_steps} = {sequences} steps"
    if _remembers(config):
        steps = f"num_envs = {sequences}, as networks with memory learn from whole rollouts,"
    over_devices = f", each of them spread over {devices} devices" if devices > 1 else ""
    fitting = [number for number in range(1, parts) if sequences % (number * devices) == 0]
    repair = f"the largest below it that works is {fitting[-1]}" if fitting else "none works"
    raise ConfigError(
        f"{steps} cannot be split into num_minibatches = {parts} equal parts{over_devices}; {repair}"
    )


def minibatch_size(config: PPOConfig | VDNConfig) -> int:
    """Returns the number of sequences in a minibatch: steps, or whole rollouts with memory."""
    return _num_sequences(config) // config.num_minibatches


def _num_sequences(config: PPOConfig | VDNConfig) -> int:
    """Returns the number of sequences in a rollout."""
    return config.num_envs if _remembers(config) else config.steps_per_update


def _remembers(config: PPOConfig | VDNConfig) -> bool:
    return isinstance(config, PPOConfig) and config.memory != "none"


def sorted_on_cpu(indices: Array) -> Array:
    """Returns a minibatch's indices, in order on a CPU: their order doesn't matter.

    Unsorted, XLA fuses the shuffle into the loop that unpacks bytes, which is slow on a CPU.
    """
    ordered: Array = jax.lax.platform_dependent(
        indices, cpu=jnp.sort, default=lambda unsorted: unsorted
    )
    return ordered


def draw_orders(key: Array, number: int, config: PPOConfig | VDNConfig) -> Array:
    """Returns the sequences of each minibatch, `[G, epochs, minibatches, m]` int32.

    They are all sequences once an epoch, in a new order. Environments are divided into the most
    groups that divide a minibatch too, and a minibatch has equally many sequences of each group, so
    the order doesn't depend on the number of devices. On several devices, the sequences are those
    of this device's environments.
    """
    size = minibatch_size(config)
    all_groups = math.gcd(config.num_envs, size)
    envs = config.num_envs // all_groups  # of a group
    sequences = size * config.num_minibatches // all_groups  # of a group
    keys = own_keys(key, own_share(all_groups))
    keys = jax.vmap(lambda key: jax.random.split(key, (number, config.num_epochs)))(keys)
    draw = partial(jax.random.permutation, x=jnp.arange(sequences, dtype=jnp.int32))
    in_group = jax.vmap(jax.vmap(jax.vmap(draw)))(keys)  # [groups, G, epochs, sequences]
    step, env = jnp.divmod(in_group, envs)
    # The sequences of a rollout lie step by step, and in each step group by group.
    groups = len(keys)
    group = jnp.arange(groups)[:, None, None, None]
    orders = (step * groups + group) * envs + env
    orders = orders.reshape(groups, number, config.num_epochs, config.num_minibatches, -1)
    # A minibatch is its part of every group, one after the other.
    return jnp.moveaxis(orders, 0, 3).reshape(number, config.num_epochs, config.num_minibatches, -1)
