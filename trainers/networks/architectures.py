"""Neural networks (flax): from token observations to action logits, state values or action values."""

import inspect
from functools import partial
from typing import Any

import flax.linen as nn
import jax
import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.planes import TokenPlane
from sjdsl.runtime.tokens import to_channels

from ..settings.config_errors import ConfigError
from ..settings.own_settings import filled
from .convolution import convolve
from .initialisation import orthogonal
from .window_layer import WindowLayer

HIDDEN_GAIN = 2.0**0.5
ACTOR_GAIN = 0.01
CRITIC_GAIN = 1.0
CONVOLUTION_SIDES = (5, 3, 3)
CONVOLUTION_CHANNELS = 32

Memory = Any  # recurrent state passed from step to step: arrays `[M, ...]`; `()` without memory


class Torso(nn.Module):
    """Features of windows of tokens, or of vectors.

    Tokens become channels inside the network, so that rollouts store bytes. `mlp` flattens a window; `cnn` applies convolutions first. Vectors,
    which have no planes, go straight to the dense layer. Source of the three convolutions: SocialJax.
    """

    planes: tuple[TokenPlane, ...]
    kind: str  # mlp, cnn, or the name of a custom network
    width: int
    dtype: Any
    sides: tuple[int, ...] = CONVOLUTION_SIDES
    channels: int = CONVOLUTION_CHANNELS
    own: tuple[tuple[str, Any], ...] = ()  # settings that a custom network may take
    layer_norm: bool = False

    @nn.compact
    def __call__(self, observation: Array) -> Array:
        """Returns features `[..., width]` of observations `[..., P, V, V]` uint8, or of `[..., K]` float32 if there are no planes."""
        if not self.planes:
            return self._dense(observation.astype(self.dtype))
        lead = observation.shape[:-3]
        if self.kind not in ("mlp", "cnn"):
            return (
                self._own(observation.reshape(-1, *observation.shape[-3:]))
                .reshape(*lead, -1)
                .astype(self.dtype)
            )
        if self.kind == "mlp":
            return self._activate(
                WindowLayer(self.width, self.planes, HIDDEN_GAIN, self.dtype, name="Dense_0")(
                    observation
                )
            )
        features = to_channels(observation, self.planes, self.dtype, scale_numbers=True)
        features = jnp.moveaxis(
            features.reshape(-1, *features.shape[-3:]), 1, -1
        )  # convolutions expect channels last
        for index, side in enumerate(self.sides):
            shape = (side, side, features.shape[-1], self.channels)
            kernel = self.param(f"convolution_{index}", orthogonal(HIDDEN_GAIN), shape)
            bias = self.param(
                f"convolution_{index}_bias", nn.initializers.zeros, shape[-1:], jnp.float32
            )
            features = nn.relu(
                convolve(features, kernel.astype(self.dtype)) + bias.astype(self.dtype)
            )
        return self._dense(features.reshape(*lead, -1))

    def _own(self, tokens: Array) -> Array:
        """Returns the features `[M, K]` of tokens `[M, P, V, V]` uint8 from a custom module.

        It is created with those of `planes`, `width`, `dtype` and `own` for which it has fields or arguments.
        """
        make = filled("network", self.kind, self.own)
        fields = inspect.signature(make).parameters
        known = {"planes": self.planes, "width": self.width, "dtype": self.dtype}
        module = make(**{name: value for name, value in known.items() if name in fields})
        if module.scope is None:  # created beforehand and registered
            module = module.clone(parent=self, name="own")
        features = module(tokens)
        if features.ndim != 2 or features.shape[0] != tokens.shape[0]:
            raise ConfigError(
                f"the network `{self.kind}` must return features [M, K] for tokens [M, planes, rows, columns], here {tokens.shape}; it returned "
                f"{features.shape}"
            )
        result: Array = features
        return result

    def _dense(self, features: Array) -> Array:
        return self._activate(
            nn.Dense(self.width, kernel_init=orthogonal(HIDDEN_GAIN), dtype=self.dtype)(features)
        )

    def _activate(self, features: Array) -> Array:
        return nn.relu(nn.LayerNorm(dtype=self.dtype)(features) if self.layer_norm else features)


def with_numbers(features: Array, agents: Array | None, number: int) -> Array:
    """Returns features `[..., S, K]` with the one-hot numbers `[S]` of their agents appended: `[..., S, K + number]`.

    They are appended after the torso, so that the later layers, memory included, can differ by agent. With `number` 0 nothing is appended.
    """
    if number == 0:
        return features
    known = jax.nn.one_hot(agents, number, dtype=features.dtype)
    return jnp.concatenate(
        [features, jnp.broadcast_to(known, (*features.shape[:-1], number))], axis=-1
    )


class Recurrence(nn.Module):
    """A gated recurrent unit along the first axis; its memory is reset at the start of an episode."""

    width: int
    dtype: Any

    @partial(
        nn.scan, variable_broadcast="params", split_rngs={"params": False}, in_axes=0, out_axes=0
    )
    @nn.compact
    def __call__(self, memory: Array, step: tuple[Array, Array]) -> tuple[Array, Array]:
        """Takes memory `[..., width]`, features `[L, ..., K]` and `[L, ...]` bool, fresh; returns memory and `[L, ..., width]`."""
        features, fresh = step
        memory = jnp.where(fresh[..., None], jnp.zeros_like(memory), memory)
        result: tuple[Array, Array] = nn.GRUCell(
            self.width, dtype=self.dtype, recurrent_kernel_init=orthogonal()
        )(memory, features)
        return result


class Head(nn.Module):
    """A hidden layer and a linear layer with float32 outputs; of a critic whose values are normalised, also their scale (`value_scale`)."""

    outputs: int
    width: int
    gain: float
    dtype: Any
    layer_norm: bool = False
    normalised: bool = False

    @nn.compact
    def __call__(self, features: Array) -> Array:
        hidden = nn.Dense(self.width, kernel_init=orthogonal(HIDDEN_GAIN), dtype=self.dtype)(
            features
        )
        hidden = nn.relu(nn.LayerNorm(dtype=self.dtype)(hidden) if self.layer_norm else hidden)
        outputs = nn.Dense(
            self.outputs, kernel_init=orthogonal(self.gain), dtype=self.dtype, name="out"
        )(hidden).astype(jnp.float32)
        if not self.normalised:
            return outputs
        mean = self.param("mean", nn.initializers.zeros, (), jnp.float32)
        deviation = self.param("deviation", nn.initializers.ones, (), jnp.float32)
        return outputs * jax.lax.stop_gradient(deviation) + jax.lax.stop_gradient(mean)


class ActorCritic(nn.Module):
    """The network that S agents share: a policy given an agent's window, and a value.

    With a local critic, policy and value share one torso, and the value depends on the agent's own window. With a central one, the critic is
    a separate network that sees `joint`, the same for all agents, and returns all S values at once, so it doesn't need agents' numbers.
    """

    num_actions: int
    num_agents: int  # S
    planes: tuple[TokenPlane, ...]
    joint_planes: tuple[TokenPlane, ...] | None  # None: a local critic; (): joint is a vector
    kind: str
    width: int
    recurrent: bool = False
    dtype: Any = jnp.float32
    numbers: int = 0  # N if the agents' numbers are an input, else 0
    sides: tuple[int, ...] = CONVOLUTION_SIDES
    channels: int = CONVOLUTION_CHANNELS
    own: tuple[tuple[str, Any], ...] = ()
    normalise_values: bool = False

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
          memory: from the previous step; initially from `start_memory`.
          observation: `[L, M, S, P, V, V]` uint8.
          joint: `[L, M, ...]`, the input of a central critic; None for a local one.
          fresh: `[L, M]` bool, whether the episode starts with this step.
          agents: `[S]` int32, the numbers of the agents; used only if they are an input.
        Returns:
          the memory afterwards, logits `[L, M, S, A]`, values `[L, M, S]`.
        """
        torso = partial(
            Torso,
            kind=self.kind,
            width=self.width,
            dtype=self.dtype,
            sides=self.sides,
            channels=self.channels,
            own=self.own,
        )
        head = partial(Head, width=self.width, dtype=self.dtype)
        critic = partial(head, gain=CRITIC_GAIN, normalised=self.normalise_values, name="critic")
        seen = with_numbers(torso(self.planes, name="torso")(observation), agents, self.numbers)
        memory, seen = self._remember(
            "memory", memory, seen, jnp.broadcast_to(fresh[..., None], seen.shape[:-1])
        )
        logits = head(self.num_actions, gain=ACTOR_GAIN, name="actor")(seen)
        if self.joint_planes is None:
            return memory, logits, critic(1)(seen)[..., 0]
        assert joint is not None
        known = torso(self.joint_planes, name="critic_torso")(joint)
        memory, known = self._remember("critic_memory", memory, known, fresh)
        return memory, logits, critic(self.num_agents)(known)

    def _remember(
        self, name: str, memory: Memory, features: Array, fresh: Array
    ) -> tuple[Memory, Array]:
        if not self.recurrent:
            return memory, features
        after, features = Recurrence(self.width, self.dtype, name=name)(
            memory[name], (features, fresh)
        )
        return {**memory, name: after}, features

    def start_memory(self, num_envs: int) -> Memory:
        """Returns the memory before the first step of M environments."""
        if not self.recurrent:
            return ()
        memory = {"memory": jnp.zeros((num_envs, self.num_agents, self.width), self.dtype)}
        if self.joint_planes is not None:
            memory["critic_memory"] = jnp.zeros((num_envs, self.width), self.dtype)
        return memory


class ActionValues(nn.Module):
    """The value of each action given an agent's window; all agents share the network."""

    num_actions: int
    planes: tuple[TokenPlane, ...]
    kind: str
    width: int
    dtype: Any = jnp.float32
    numbers: int = 0  # N if the agents' numbers are an input, else 0
    sides: tuple[int, ...] = CONVOLUTION_SIDES
    channels: int = CONVOLUTION_CHANNELS
    own: tuple[tuple[str, Any], ...] = ()
    layer_norm: bool = False

    @nn.compact
    def __call__(self, observation: Array) -> Array:
        """Returns `[..., N, A]` float32 for observations `[..., N, P, V, V]` uint8 of all agents, in order."""
        torso = Torso(
            self.planes,
            self.kind,
            self.width,
            self.dtype,
            self.sides,
            self.channels,
            self.own,
            self.layer_norm,
            name="torso",
        )
        seen = with_numbers(torso(observation), jnp.arange(self.numbers), self.numbers)
        return Head(
            self.num_actions, self.width, CRITIC_GAIN, self.dtype, self.layer_norm, name="values"
        )(seen)
