"""What a team's value is learnt from: its targets in replayed steps or in rollouts, and its loss."""

from dataclasses import dataclass
from typing import Any, cast

import flax
import jax
import jax.numpy as jnp
from jax import Array

from ..networks.action_values import best_action, values_of_actions
from ..networks.architectures import ActionValues
from ..networks.masks import masked
from ..settings.config import VDNConfig
from .advantage import generalised_advantages, successor_values
from .rollout import Rollout
from .training_functions import Metrics


@dataclass(frozen=True)
class Team:
    """The network that all agents share, and those whose values are added up to the team's."""

    network: ActionValues
    learning: Array  # numbers of the agents that learn

    def values(self, parameters: Any, observation: Array) -> Array:
        """Returns action values `[..., N, A]` of observations `[..., N, P, V, V]`."""
        return cast(Array, self.network.apply(parameters, observation))

    def total(self, values: Array) -> Array:
        """Returns the team's value `[...]` from those of all agents `[..., N]`."""
        return values[..., self.learning].sum(axis=-1)

    def best(self, values: Array, allowed: Array | None) -> Array:
        """Returns the value `[...]` of all agents' best actions from action values."""
        return self.total(masked(values, allowed).max(axis=-1))


@flax.struct.dataclass
class Transition:
    """One step of one environment in the replay buffer."""

    observation: Array  # [N, bytes] uint8, acted on, packed
    action: Array  # [N] int32
    reward: Array  # [] float32, the team's
    following: Array  # [N, bytes] uint8, packed, after the step, before a reset
    ended: Array  # [] bool, a termination, not a truncation
    allowed: Array | None = None  # [N, A] bool, actions allowed after the step; None: all


@flax.struct.dataclass
class Steps:
    """M steps to learn from."""

    observation: Array  # [M, N, bytes] uint8, packed; in a minibatch [M, N, P, V, V]
    action: Array  # [M, N] int32
    target: Array  # [M] float32, of the team's value


def bootstrapped(
    parameters: Any, target: Any, batch: Transition, team: Team, config: VDNConfig
) -> Steps:
    """Returns replayed steps with their targets.

    y = r + gamma * sum over i of max_a Q'_i(s', a), with the target network Q', over the actions
    allowed in s'. After a termination y = r. With `double_q`, a is the best action of the online
    network (van Hasselt et al. 2016). Sums are over the learning agents.
    """
    next_values = team.values(target, batch.following)
    if config.double_q:
        online_values = team.values(parameters, batch.following)
        chosen = best_action(online_values, batch.allowed)
        following = team.total(values_of_actions(next_values, chosen))
    else:
        following = team.best(next_values, batch.allowed)
    wanted = batch.reward + config.gamma * jnp.where(batch.ended, 0.0, following)
    return Steps(batch.observation, batch.action, wanted)


def with_lambda_returns(rollout: Rollout, last_value: Array, config: VDNConfig) -> Steps:
    """Returns the `T * B` steps of a rollout with their targets.

    The lambda return of Q-learning is
    G_t = r_t + gamma * ((1 - lambda) * V_{t+1} + lambda * G_{t+1}), where V is the value of the
    best actions: it is V_t plus the generalised advantage of these values.

    Args:
      rollout: its `acting` are the values `[T, B]` of the best actions, its `ending` those of
        terminal observations.
      last_value: `[B]`, of the observations after the last step.
    """
    values = rollout.acting[..., None]
    successors = successor_values(
        values, last_value[:, None], rollout.ending[..., None], rollout.done, rollout.truncated
    )
    reward = rollout.shaped_reward[..., :1]  # the same for all agents
    advantage = generalised_advantages(
        reward, values, successors, rollout.done, config.gamma, config.q_lambda
    )
    steps = Steps(rollout.observation, rollout.action, (values + advantage)[..., 0])
    result: Steps = jax.tree.map(lambda leaf: leaf.reshape(-1, *leaf.shape[2:]), steps)
    return result


def team_loss(parameters: Any, team: Team, steps: Steps, weight: float) -> tuple[Array, Metrics]:
    """Returns the weighted mean squared error of the team's value, and its parts.

    The team's value is the sum of Q_i(s, a_i) over the learning agents.
    """
    values = team.values(parameters, steps.observation)
    team_value = team.total(values_of_actions(values, steps.action))
    loss = weight * jnp.square(team_value - steps.target).mean()
    return loss, {"loss": loss, "team_value": team_value.mean()}
