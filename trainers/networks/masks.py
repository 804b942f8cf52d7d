"""Action masks: actions that the game forbids now are neither drawn, nor valued, nor learnt from.

In a compiled game, a forbidden action does the same as `stay`: a mask takes nothing from an agent,
but saves it from learning which actions do nothing now.
"""

from typing import Any, cast

import jax
import jax.numpy as jnp
from jax import Array

from ..environment import Environment, MaskedEnvironment
from ..settings.config import Config

# A logit or a value whose probability is exactly 0 in float32. With -inf, gradients and entropies
# would not be finite.
NEVER = -1e9


def wants_masks(env: Environment, config: Config) -> bool:
    """Whether actions are masked: the configuration asks for it, and the game forbids some."""
    return (
        config.mask_actions
        and hasattr(env, "allowed_actions")
        and getattr(env, "forbids_actions", True)
    )


def allowed_in(env: Environment, masks: bool, state: Any) -> Array | None:
    """Returns which actions agents of B environments may take, `[B, N, A]` bool, or None."""
    return jax.vmap(cast(MaskedEnvironment, env).allowed_actions)(state) if masks else None


def masked(scores: Array, allowed: Array | None) -> Array:
    """Returns logits or values `[..., A]`, so low for forbidden actions that none is ever taken."""
    return scores if allowed is None else jnp.where(allowed, scores, NEVER)


def draw_any(key: Array, shape: tuple[int, ...], num_actions: int, allowed: Array | None) -> Array:
    """Returns actions `shape` int32, drawn from the allowed ones with equal probability."""
    if allowed is None:
        return jax.random.randint(key, shape, 0, num_actions, jnp.int32)
    equal = jnp.zeros(allowed.shape, jnp.float32)
    return jax.random.categorical(key, masked(equal, allowed)).astype(jnp.int32)
