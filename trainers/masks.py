"""Action masks: actions that the game forbids now are neither drawn, nor valued, nor learnt from.

In a compiled game a forbidden action is `stay` by another name: a mask takes nothing from an agent, it only spares it from learning
which names mean nothing now.
"""

from typing import Any, cast

import jax
import jax.numpy as jnp
from jax import Array

from .config import Config
from .environment import Environment, MaskedEnvironment

NEVER = -1e9  # of a logit or a value: in float32 its probability is exactly 0, and, unlike with -inf, gradients and entropies are finite


def wants_masks(env: Environment, config: Config) -> bool:
    """Whether actions are masked: it is asked for, and the game ever forbids one."""
    return config.mask_actions and hasattr(env, "allowed_actions") and getattr(env, "forbids_actions", True)


def allowed_in(env: Environment, masks: bool, state: Any) -> Array | None:
    """Returns which actions the agents of B environments may take, `[B, N, A]` bool; None without masks."""
    return jax.vmap(cast(MaskedEnvironment, env).allowed_actions)(state) if masks else None


def masked(scores: Array, allowed: Array | None) -> Array:
    """Returns logits or values `[..., A]` with those of actions that are not allowed so low that they are never taken."""
    return scores if allowed is None else jnp.where(allowed, scores, NEVER)


def draw_any(key: Array, shape: tuple[int, ...], num_actions: int, allowed: Array | None) -> Array:
    """Returns actions `shape` int32, each of those allowed with equal probability."""
    if allowed is None:
        return jax.random.randint(key, shape, 0, num_actions, jnp.int32)
    return jax.random.categorical(key, masked(jnp.zeros(allowed.shape, jnp.float32), allowed)).astype(jnp.int32)


def pack_mask(allowed: Array | None) -> Array | None:
    """Returns masks `[..., A]` bool as bits, `[..., bytes]` uint8: what rollouts and replay buffers keep."""
    return None if allowed is None else jnp.packbits(allowed, axis=-1)


def unpack_mask(packed: Array | None, num_actions: int) -> Array | None:
    """Returns what was packed."""
    return None if packed is None else jnp.unpackbits(packed, axis=-1, count=num_actions).astype(bool)
