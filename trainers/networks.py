"""The actor-critic network: token observations in, action logits and a value out."""

from typing import Literal

import flax.linen as nn
import jax.numpy as jnp
from flax.linen.initializers import orthogonal
from jax import Array

from sjdsl.runtime.planes import TokenPlane
from sjdsl.runtime.tokens import to_channels

from .convolution import convolve

HIDDEN_GAIN = 2.0**0.5
ACTOR_GAIN = 0.01
CRITIC_GAIN = 1.0
CONVOLUTION_CHANNELS = 32


class ActorCritic(nn.Module):
    """A torso on one-hot channels with a policy head and a value head.

    Tokens become channels inside the network, so that a rollout stores bytes. `mlp` reads the window flat; `cnn` passes
    it through three convolutions first. Source of the convolutions and of the heads: SocialJax, IPPO network.
    """

    num_actions: int
    planes: tuple[TokenPlane, ...]
    kind: Literal["mlp", "cnn"]
    width: int

    @nn.compact
    def __call__(self, observation: Array) -> tuple[Array, Array]:
        """Returns logits `[..., A]` and values `[...]` for observations `[..., P, V, V]` uint8."""
        features = to_channels(observation, self.planes, jnp.float32, scale_numbers=True)
        lead = observation.shape[:-3]
        features = features.reshape(-1, *features.shape[-3:])
        if self.kind == "cnn":
            features = jnp.moveaxis(features, 1, -1)  # convolutions want channels last
            for index, side in enumerate((5, 3, 3)):
                shape = (side, side, features.shape[-1], CONVOLUTION_CHANNELS)
                kernel = self.param(f"convolution_{index}", orthogonal(HIDDEN_GAIN), shape)
                bias = self.param(f"convolution_{index}_bias", nn.initializers.zeros, shape[-1:])
                features = nn.relu(convolve(features, kernel) + bias)
        features = self._dense(features.reshape(features.shape[0], -1))
        logits = nn.Dense(self.num_actions, kernel_init=orthogonal(ACTOR_GAIN), name="actor")(self._dense(features))
        value = nn.Dense(1, kernel_init=orthogonal(CRITIC_GAIN), name="critic")(self._dense(features))
        return logits.reshape(*lead, self.num_actions), value.reshape(lead)

    def _dense(self, features: Array) -> Array:
        return nn.relu(nn.Dense(self.width, kernel_init=orthogonal(HIDDEN_GAIN))(features))
