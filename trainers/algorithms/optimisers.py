"""The optimisers (optax) and their learning rates."""

from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp
import optax
from flax.training.train_state import TrainState as Learner
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


def make_optimiser(config: PPOConfig | VDNConfig) -> optax.GradientTransformation:
    """Returns the optimiser on gradients whose global norm is clipped: Adam, for VDN rectified Adam.

    There is one for all parameters; or one for a critic that shares no layer with its actor, and
    one for the rest. With separate optimisers, a critic with large errors (as with summed rewards)
    doesn't take the actor's share of the clipped norm. Source of rectified Adam: SocialJax.
    """
    make = optax.radam if isinstance(config, VDNConfig) else optax.adam
    optimiser = optax.chain(
        optax.clip_by_global_norm(config.max_gradient_norm),
        make(learning_rate_schedule(config), eps=config.adam_epsilon),
    )
    if isinstance(config, VDNConfig) or not config.critic_has_torso:
        return optimiser
    return optax.partition({"actor": optimiser, "critic": optimiser}, part_of_each)


def part_of_each(parameters: Any) -> Any:
    """Returns `actor` or `critic` for each leaf, by the name of the module it is in."""
    return jax.tree_util.tree_map_with_path(
        lambda path, _: "critic" if "['critic" in keystr(path) else "actor", parameters
    )
