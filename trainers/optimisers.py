"""The optimisers of PPO (optax): one if actor and critic share layers, one each if they do not."""

from typing import Any

import jax
import optax
from jax import Array
from jax.tree_util import keystr

from .config import PPOConfig


def learning_rate_schedule(config: PPOConfig) -> optax.Schedule:
    """Returns the learning rate as a function of the gradient steps taken."""
    if not config.anneal_learning_rate:
        return optax.constant_schedule(config.learning_rate)
    steps = config.num_updates * config.num_epochs * config.num_minibatches
    return optax.linear_schedule(config.learning_rate, 0.0, steps)


def make_optimiser(config: PPOConfig) -> optax.GradientTransformation:
    """Returns Adam on gradients whose global norm is clipped: for all parameters, or for the actor's and the critic's apart.

    Apart, a critic whose errors are large, as those of summed rewards are, does not take the actor's share of the clipped norm.
    """
    if not apart(config):
        return _clipped_adam(config)
    return optax.partition({"actor": _clipped_adam(config), "critic": _clipped_adam(config)}, part_of_each)


def apart(config: PPOConfig) -> bool:
    """Whether actor and critic have an optimiser each: a central critic shares no layer with the actor."""
    return config.algorithm == "mappo" and not config.joint_optimiser


def part_of_each(parameters: Any) -> Any:
    """Returns `actor` or `critic` for each leaf, by the name of the module it is in."""
    return jax.tree_util.tree_map_with_path(lambda path, _: "critic" if "['critic" in keystr(path) else "actor", parameters)


def gradient_norms(gradients: Any, config: PPOConfig) -> dict[str, Array]:
    """Returns the global norm of the gradients before they are clipped; where that is done apart, also the norm of each part."""
    norms = {"gradient_norm": optax.tree.norm(gradients)}
    if apart(config):
        of_leaf = jax.tree.leaves(part_of_each(gradients))
        for part in ("actor", "critic"):
            own = [leaf for leaf, name in zip(jax.tree.leaves(gradients), of_leaf, strict=True) if name == part]
            norms[f"{part}_gradient_norm"] = optax.tree.norm(own)
    return norms


def _clipped_adam(config: PPOConfig) -> optax.GradientTransformation:
    return optax.chain(optax.clip_by_global_norm(config.max_gradient_norm), optax.adam(learning_rate_schedule(config), eps=1e-5))
