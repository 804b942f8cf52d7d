"""Individual reward assisted team policies (IRAT): the rewards and the loss of agents with an individual and a team policy each.

The individual policies act while agents learn. The team policies learn from what these did, and are the result of the run.
Source: Wang et al. 2022, "Individual reward assisted multi-agent reinforcement learning"; the losses are in the form of its authors' code.
"""

from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

from .config import PPOConfig
from .losses import Apply, Batch, clipped_surrogate, mean_entropy, normalised, value_loss
from .masks import masked
from .networks import INDIVIDUAL, TEAM
from .rollout import Rollout, chosen_log_probability
from .shaping import common_mean, common_sum
from .training_functions import Metrics


def both_rewards(rollout: Rollout, config: PPOConfig) -> Array:
    """Returns `[T, B, N, 2]`: the shaped reward of each agent, and the raw rewards of all."""
    team = common_mean(rollout.reward) if config.team_reward == "mean" else common_sum(rollout.reward)
    return jnp.stack([rollout.shaped_reward, team], axis=-1)


def irat_loss(parameters: Any, apply: Apply, batch: Batch, config: PPOConfig) -> tuple[Array, Metrics]:
    """Returns the loss of one minibatch, and its parts.

    For an action a drawn from the individual policy, let p and q be the individual and the team policy now, p' and q' the two when it was
    drawn, and A and B the advantages in individual and team reward. Then, as means over the minibatch:

      individual: -min(p/p' A, clip(p/p', 1 - epsilon, 1 + epsilon) A, clip(p/q', 1 - xi, 1 + xi) A) + alpha KL(q' || p)
      team:       -min(q/p' B, clip(q/p', 1 - epsilon, 1 + epsilon) B) + beta KL(p' || q)

    xi is `similarity_clip`, alpha `individual_kl`, beta `team_kl`. The losses of values and entropies of both are added as in PPO. No
    gradient passes from one policy to the other: p' and q' are constants.
    Source: Wang et al. 2022.
    """
    assert batch.progress is not None
    spans = (config.similarity_clip, config.individual_kl, config.team_kl)
    xi, alpha, beta = (first + (last - first) * batch.progress for first, last in spans)
    _, logits, value = apply(parameters, batch.memory, batch.observation, batch.joint, batch.fresh)
    logits = masked(logits, None if batch.allowed is None else batch.allowed[..., None, :])
    now = chosen_log_probability(logits, batch.action[..., None])  # [L, m, S, 2]
    before = chosen_log_probability(batch.log_probability, batch.action[..., None])  # these are normalised already
    drawn = before[..., INDIVIDUAL]

    advantage = normalised(batch.advantage[..., INDIVIDUAL], config)
    log_ratio = now[..., INDIVIDUAL] - drawn
    ratio = jnp.exp(log_ratio)
    # clipped as a logarithm: where the team policy would never have done this, the ratio is infinite and its gradient not a number
    similarity = jnp.exp(jnp.clip(now[..., INDIVIDUAL] - before[..., TEAM], jnp.log(jnp.maximum(1.0 - xi, 0.0)), jnp.log1p(xi)))
    individual = -jnp.minimum(clipped_surrogate(ratio, advantage, config.clip_epsilon), similarity * advantage).mean()
    off_ratio = jnp.exp(now[..., TEAM] - drawn)
    team = -clipped_surrogate(off_ratio, normalised(batch.advantage[..., TEAM], config), config.clip_epsilon).mean()

    other = batch.log_probability[..., ::-1, :]  # what the other of the two policies was
    divergence = (jnp.exp(other) * (other - jax.nn.log_softmax(logits))).sum(axis=-1).reshape(-1, 2).mean(axis=0)
    errors = [value_loss(value[..., one], batch.value[..., one], batch.target[..., one], config) for one in (INDIVIDUAL, TEAM)]
    entropies = [mean_entropy(logits[..., one, :]) for one in (INDIVIDUAL, TEAM)]
    loss = individual + team + alpha * divergence[INDIVIDUAL] + beta * divergence[TEAM]
    loss += config.value_coefficient * sum(errors) - config.entropy_coefficient * sum(entropies)
    return loss, {
        "loss": loss,
        "individual_policy_loss": individual,
        "team_policy_loss": team,
        "individual_value_loss": errors[INDIVIDUAL],
        "team_value_loss": errors[TEAM],
        "entropy": entropies[INDIVIDUAL],
        "team_entropy": entropies[TEAM],
        "individual_kl": divergence[INDIVIDUAL],
        "team_kl": divergence[TEAM],
        "kl": (ratio - 1.0 - log_ratio).mean(),
        "clip_fraction": (jnp.abs(ratio - 1.0) > config.clip_epsilon).mean(),
    }
