"""Value normalisation.

A critic predicts values in units of the running mean and deviation of its targets. So one learning
rate and one value coefficient suit games with small and large returns. The two moments are
parameters that gradients don't reach. When they move, the critic's last layer is rescaled, so that
no value changes. Source: van Hasselt et al. 2016, "Learning values across many orders of magnitude"
(Pop-Art), equations 1 to 4.
"""

from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

from ..devices.data_parallel import mean_of_all

RATE = 0.2  # how far the moments move towards those of each rollout
# of targets, so that errors alone aren't scaled up while nobody is rewarded. Source: MAPPO (Yu et
# al. 2022), its code
LEAST_VARIANCE = 1e-2


def value_unit(parameters: Any) -> Array:
    """Returns the deviation `[]` in which a network predicts values, as a constant."""
    unit: Array = jax.lax.stop_gradient(parameters["params"]["critic"]["deviation"])
    return unit


def follow_targets(parameters: Any, target: Array, first: Array) -> Any:
    """Returns parameters with moments moved towards those of the targets, and the same values.

    Args:
      parameters: of one `ActorCritic` that normalises values.
      target: of the values in the rollout, any shape.
      first: `[]` bool, whether nothing has been learnt yet, so that the targets' moments are
        adopted whole.
    """
    critic = parameters["params"]["critic"]
    rate = jnp.where(first, 1.0, RATE)
    mean = critic["mean"]
    deviation = critic["deviation"]
    square = jnp.square(deviation) + jnp.square(mean)
    new_mean = mean + rate * (mean_of_all(target.mean()) - mean)
    new_square = square + rate * (mean_of_all(jnp.square(target).mean()) - square)
    new_deviation = jnp.sqrt(jnp.maximum(new_square - jnp.square(new_mean), LEAST_VARIANCE))
    out = {
        "kernel": critic["out"]["kernel"] * deviation / new_deviation,
        "bias": (critic["out"]["bias"] * deviation + mean - new_mean) / new_deviation,
    }
    moved = {**critic, "out": out, "mean": new_mean, "deviation": new_deviation}
    return with_critic(parameters, moved)


def converted(parameters: Any, normalised: bool) -> Any:
    """Returns the parameters of networks, stacked or not, with or without moments; values stay."""
    critic = parameters["params"]["critic"]
    if normalised == ("deviation" in critic):
        return parameters
    kernel = critic["out"]["kernel"]
    bias = critic["out"]["bias"]
    if normalised:
        shape = kernel.shape[:-2]
        moments = {"mean": jnp.zeros(shape), "deviation": jnp.ones(shape)}
        return with_critic(parameters, {**critic, **moments})
    mean = critic["mean"][..., None]
    deviation = critic["deviation"][..., None]
    rest = {name: part for name, part in critic.items() if name not in ("mean", "deviation")}
    out = {"kernel": kernel * deviation[..., None], "bias": bias * deviation + mean}
    return with_critic(parameters, {**rest, "out": out})


def with_critic(parameters: Any, critic: Any) -> Any:
    """Returns the parameters of a network with others for its critic's head."""
    return {**parameters, "params": {**parameters["params"], "critic": critic}}
