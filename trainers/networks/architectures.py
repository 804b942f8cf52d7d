"""Neural networks (flax): from token observations to action logits, state or action values."""

import inspect
from functools import partial
from typing import Any

import flax.linen as nn
import jax
import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.planes import TokenPlane
from sjdsl.runtime.tokens import to_channels

from ..settings.config import Config, PPOConfig, VDNConfig
from ..settings.config_errors import ConfigError
from ..settings.own_settings import filled
from .convolution import convolve
from .initialisation import orthogonal
from .last_step import blank_last_step, last_step_features
from .window_layer import WindowLayer

HIDDEN_GAIN = 2.0**0.5
ACTOR_GAIN = 0.01
CRITIC_GAIN = 1.0

Planes = tuple[TokenPlane, ...]
Memory = Any  # recurrent state passed from step to step: arrays `[M, ...]`; `()` without memory


class Torso(nn.Module):
    """Features of windows of tokens, or of vectors.

    Tokens become channels inside the network, so that rollouts store bytes. `mlp` flattens a
    window; `cnn` applies convolutions first. Vectors, which have no planes, go straight to the
    dense layer. Source of the three convolutions: SocialJax.
    """

    planes: Planes
    config: Config

    @nn.compact
    def __call__(self, observation: Array) -> Array:
        """Returns features `[..., width]`.

        Args:
          observation: `[..., P, V, V]` uint8, or `[..., K]` float32 if there are no planes.
        """
        config = self.config
        dtype = jnp.dtype(config.precision)
        if not self.planes:
            return dense(observation.astype(dtype), config)
        lead = observation.shape[:-3]
        windows = observation.reshape(-1, *observation.shape[-3:])
        if config.network == "mlp":
            layer = WindowLayer(
                config.network_width, self.planes, HIDDEN_GAIN, dtype, name="Dense_0"
            )
            return activate(layer(observation), config)
        if config.network == "cnn":
            return dense(self._convolutions(windows).reshape(*lead, -1), config)
        return self._own(windows).reshape(*lead, -1).astype(dtype)

    def _convolutions(self, windows: Array) -> Array:
        """Returns the features `[M, V, V, channels]` of windows `[M, P, V, V]` uint8."""
        dtype = jnp.dtype(self.config.precision)
        features = to_channels(windows, self.planes, dtype, scale_numbers=True)
        features = jnp.moveaxis(features, 1, -1)  # convolutions expect channels last
        for index, side in enumerate(self.config.convolution_sides):
            name = f"convolution_{index}"
            shape = (side, side, features.shape[-1], self.config.convolution_channels)
            kernel = self.param(name, orthogonal(HIDDEN_GAIN), shape)
            bias = self.param(f"{name}_bias", nn.initializers.zeros, shape[-1:], jnp.float32)
            features = nn.relu(convolve(features, kernel.astype(dtype)) + bias.astype(dtype))
        return features

    def _own(self, tokens: Array) -> Array:
        """Returns the features `[M, K]` of tokens `[M, P, V, V]` uint8 from a custom module.

        It is created with those of `planes`, `width`, `dtype` and the user's own settings for which
        it has fields or arguments.
        """
        config = self.config
        make = filled("network", config.network, config.own)
        known = {
            "planes": self.planes,
            "width": config.network_width,
            "dtype": jnp.dtype(config.precision),
        }
        fields = inspect.signature(make).parameters
        module = make(**{name: value for name, value in known.items() if name in fields})
        if module.scope is None:  # created beforehand and registered
            module = module.clone(parent=self, name="own")
        features: Array = module(tokens)
        if features.ndim != 2 or features.shape[0] != tokens.shape[0]:
            raise ConfigError(
                f"the network `{config.network}` must return features [M, K] for tokens "
                f"[M, planes, rows, columns], here {tokens.shape}; it returned {features.shape}"
            )
        return features


def dense(features: Array, config: Config) -> Array:
    """Returns a hidden layer `[..., width]` of features, inside a module's `__call__`."""
    layer = nn.Dense(
        config.network_width,
        kernel_init=orthogonal(HIDDEN_GAIN),
        dtype=jnp.dtype(config.precision),
    )
    return activate(layer(features), config)


def activate(features: Array, config: Config) -> Array:
    """Returns the positive part of features, normalised if VDN's layers are."""
    if isinstance(config, VDNConfig) and config.layer_norm:
        features = nn.LayerNorm(dtype=jnp.dtype(config.precision))(features)
    return nn.relu(features)


def with_numbers(features: Array, agents: Array | None, number: int) -> Array:
    """Returns features `[..., S, K]` with the numbers of their agents: `[..., S, K + number]`.

    The numbers `[S]`, one-hot, are appended after the torso, so that the later layers, memory
    included, can differ by agent. With `number` 0 nothing is appended.
    """
    if number == 0:
        return features
    one_hot = jax.nn.one_hot(agents, number, dtype=features.dtype)
    numbers = jnp.broadcast_to(one_hot, (*features.shape[:-1], number))
    return jnp.concatenate([features, numbers], axis=-1)


def with_mean_of_agents(features: Array) -> Array:
    """Returns features `[..., S, K]` with their mean over the agents: `[..., S, 2 K]`."""
    mean = jnp.broadcast_to(features.mean(axis=-2, keepdims=True), features.shape)
    return jnp.concatenate([features, mean], axis=-1)


class Recurrence(nn.Module):
    """A gated recurrent unit along the first axis, reset at the start of an episode."""

    width: int
    dtype: Any

    @partial(
        nn.scan, variable_broadcast="params", split_rngs={"params": False}, in_axes=0, out_axes=0
    )
    @nn.compact
    def __call__(self, memory: Array, step: tuple[Array, Array]) -> tuple[Array, Array]:
        """Returns the memory afterwards and outputs `[L, ..., width]`.

        Args:
          memory: `[..., width]`.
          step: features `[L, ..., K]`, and `[L, ...]` bool, whether an episode starts.
        """
        features, fresh = step
        memory = jnp.where(fresh[..., None], jnp.zeros_like(memory), memory)
        cell = nn.GRUCell(self.width, dtype=self.dtype, recurrent_kernel_init=orthogonal())
        result: tuple[Array, Array] = cell(memory, features)
        return result


class Head(nn.Module):
    """A linear layer with float32 outputs, after a hidden layer if it has one.

    Of a critic whose values are normalised, it also has their scale (`value_scale`).
    """

    outputs: int
    config: Config
    gain: float
    hidden: bool = True
    normalised: bool = False

    @nn.compact
    def __call__(self, features: Array) -> Array:
        """Returns float32 outputs `[..., outputs]`."""
        if self.hidden:
            features = dense(features, self.config)
        last = nn.Dense(
            self.outputs,
            kernel_init=orthogonal(self.gain),
            dtype=jnp.dtype(self.config.precision),
            name="out",
        )
        outputs = last(features).astype(jnp.float32)
        if not self.normalised:
            return outputs
        mean = self.param("mean", nn.initializers.zeros, (), jnp.float32)
        deviation = self.param("deviation", nn.initializers.ones, (), jnp.float32)
        return outputs * jax.lax.stop_gradient(deviation) + jax.lax.stop_gradient(mean)


class ActorCritic(nn.Module):
    """The network that S agents share: a policy given an agent's window, and a value.

    Policy and value share one torso, and a hidden layer after it if `share_hidden`. The value
    depends on the agent's own window; with `reward_horizons` also on its recent rewards, and
    with `critic=pooled` on the mean over the S agents of what is made of windows. Or the critic is
    a network of its own that sees `joint`, the same for all agents, and returns all S values at
    once, so it doesn't need agents' numbers. It reads the last steps of all S agents if each agent
    reads its own.
    """

    num_actions: int
    num_agents: int  # S
    planes: Planes
    joint_planes: Planes | None  # None: one torso; (): joint is a vector
    config: PPOConfig
    numbers: int = 0  # N if the agents' numbers are an input, else 0

    @nn.compact
    def __call__(
        self,
        memory: Memory,
        observation: Array,
        joint: Array | None,
        fresh: Array,
        agents: Array | None = None,
    ) -> tuple[Memory, Array, Array]:
        """Reads L steps of M environments.

        Args:
          memory: from the previous step; initially from `start_memory`. To read several steps, it
            has what agents read in each, as `over_rollout` returns it.
          observation: `[L, M, S, P, V, V]` uint8.
          joint: `[L, M, ...]`, the input of a critic with a torso of its own, or the
            averages of recent rewards `[L, M, S, K]`, or None.
          fresh: `[L, M]` bool, whether the episode starts with this step.
          agents: `[S]` int32, the numbers of the agents; used only if they are an input.
        Returns:
          the memory afterwards, logits `[L, M, S, A]`, values `[L, M, S]`.
        """
        config = self.config
        head = partial(Head, config=config, hidden=not config.share_hidden)
        critic = partial(head, gain=CRITIC_GAIN, normalised=config.normalise_values, name="critic")
        features = Torso(self.planes, config, name="torso")(observation)
        features = with_numbers(features, agents, self.numbers)
        if config.memory_reads:
            last = last_step_features(memory["last"], fresh, self.num_actions, features.dtype)
            features = jnp.concatenate([features, last], axis=-1)
        of_agents = jnp.broadcast_to(fresh[..., None], features.shape[:-1])
        memory, features = self._remember("memory", memory, features, of_agents)
        if config.share_hidden:
            features = dense(features, config)
        logits = head(self.num_actions, gain=ACTOR_GAIN, name="actor")(features)
        if self.joint_planes is None:
            if config.algorithm == "mappo":  # with `critic=pooled`
                features = with_mean_of_agents(features)
            if joint is not None:
                features = jnp.concatenate([features, joint.astype(features.dtype)], axis=-1)
            return memory, logits, critic(1)(features)[..., 0]
        assert joint is not None
        features = Torso(self.joint_planes, config, name="critic_torso")(joint)
        if config.memory_reads:
            of_all = last.reshape(*last.shape[:2], -1)
            features = jnp.concatenate([features, of_all], axis=-1)
        memory, features = self._remember("critic_memory", memory, features, fresh)
        return memory, logits, critic(self.num_agents)(features)

    def _remember(
        self, name: str, memory: Memory, features: Array, fresh: Array
    ) -> tuple[Memory, Array]:
        """Returns the memory and the features after a recurrence; both as they are without one."""
        config = self.config
        if config.memory == "none":
            return memory, features
        recurrence = Recurrence(config.network_width, jnp.dtype(config.precision), name=name)
        after, features = recurrence(memory[name], (features, fresh))
        return {**memory, name: after}, features

    def start_memory(self, num_envs: int) -> Memory:
        """Returns the memory before the first step of M environments."""
        config = self.config
        if config.memory == "none":
            return ()
        width = config.network_width
        dtype = jnp.dtype(config.precision)
        memory: dict[str, Any] = {"memory": jnp.zeros((num_envs, self.num_agents, width), dtype)}
        if self.joint_planes is not None:
            memory["critic_memory"] = jnp.zeros((num_envs, width), dtype)
        if config.memory_reads:
            shape = (num_envs, 1, self.num_agents)
            memory["last"] = blank_last_step(config.memory_reads, shape)
        return memory


class ActionValues(nn.Module):
    """The value of each action given an agent's window; all agents share the network."""

    num_actions: int
    planes: Planes
    config: VDNConfig
    numbers: int = 0  # N if the agents' numbers are an input, else 0

    @nn.compact
    def __call__(self, observation: Array) -> Array:
        """Returns `[..., N, A]` float32 for the observations `[..., N, P, V, V]` of all agents."""
        features = Torso(self.planes, self.config, name="torso")(observation)
        features = with_numbers(features, jnp.arange(self.numbers), self.numbers)
        return Head(self.num_actions, self.config, CRITIC_GAIN, name="values")(features)
