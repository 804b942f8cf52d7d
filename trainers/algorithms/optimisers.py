"""The optimisers (optax): for PPO one for all parameters that share layers."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp
import optax
from flax.training.train_state import TrainState as Learner
from jax import Array
from jax.tree_util import keystr

from ..settings.config import PPOConfig, VDNConfig


def start_learner(parameters: Any, optimiser: optax.GradientTransformation) -> Learner:
    """Returns parameters with their optimiser, before the first gradient step."""
    learner: Learner = Learner.create(apply_fn=None, params=parameters, tx=optimiser)
    # `create` leaves a Python int, whose type would change in a loop of JAX.
    return replace(learner, step=jnp.int32(0))


def learning_rate_schedule(config: PPOConfig | VDNConfig) -> optax.Schedule:
    """Returns the learning rate as a function of the gradient steps taken."""
    if not config.anneal_learning_rate:
        return optax.constant_schedule(config.learning_rate)
    steps = config.num_epochs * config.num_minibatches
    if isinstance(config, VDNConfig) and config.replay == "buffer":
        steps = config.gradient_steps
    return optax.linear_schedule(config.learning_rate, 0.0, config.num_updates * steps)


def make_optimiser(config: PPOConfig) -> optax.GradientTransformation:
    """Returns the optimiser of PPO: Adam on gradients whose global norm is clipped.

    There is one for all parameters, or one for each part of them. With separate optimisers, a
    critic with large errors (as with summed rewards) doesn't take the actor's share of the clipped
    norm.
    """
    adam = _clipped(optax.adam, config)
    if not parts(config):
        return adam
    return optax.partition(dict.fromkeys(parts(config), adam), part_of_each)


def parts(config: PPOConfig) -> tuple[str, ...]:
    """Returns the parts with an optimiser each: a critic that shares no layer with its actor."""
    return ("actor", "critic") if config.critic_has_torso else ()


def part_of_each(parameters: Any) -> Any:
    """Returns `actor` or `critic` for each leaf, by the name of the module it is in."""
    return jax.tree_util.tree_map_with_path(
        lambda path, _: "critic" if "['critic" in keystr(path) else "actor", parameters
    )


def gradient_norms(gradients: Any, config: PPOConfig) -> dict[str, Array]:
    """Returns the global norm of the gradients before clipping, and that of each part, if any."""
    norms = {"gradient_norm": optax.tree.norm(gradients)}
    part_of_leaf = jax.tree.leaves(part_of_each(gradients))
    leaves = list(zip(jax.tree.leaves(gradients), part_of_leaf, strict=True))
    for part in parts(config):
        of_part = [leaf for leaf, other in leaves if other == part]
        norms[f"{part}_gradient_norm"] = optax.tree.norm(of_part)
    return norms


def make_value_optimiser(config: VDNConfig) -> optax.GradientTransformation:
    """Returns rectified Adam on gradients whose global norm is clipped.

    Source: SocialJax, VDN configuration.
    """
    return _clipped(optax.radam, config)


def _clipped(
    make: Callable[..., optax.GradientTransformation], config: PPOConfig | VDNConfig
) -> optax.GradientTransformation:
    """Returns an optimiser on gradients whose global norm is clipped."""
    return optax.chain(
        optax.clip_by_global_norm(config.max_gradient_norm),
        make(learning_rate_schedule(config), eps=config.adam_epsilon),
    )
