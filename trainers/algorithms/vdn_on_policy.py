"""Value decomposition networks without replay: Q(lambda) from whole rollouts of many environments.

It has neither a replay buffer nor a target network: targets are lambda returns of the rollout just
played, and layer normalisation keeps the values from diverging. Source: Gallici et al. 2024,
"Simplifying deep temporal difference learning" (PQN), section 4.
"""

from dataclasses import replace
from typing import Any, cast

import flax
import jax
import jax.numpy as jnp
import optax
from flax.training.train_state import TrainState as Learner
from jax import Array

from ..environment import Environment
from ..networks.action_values import exploration, explore, make_action_values, values_of_actions
from ..networks.actor_critics import packing_of
from ..networks.architectures import ActionValues
from ..networks.masks import allowed_in, masked, wants_masks
from ..networks.packing import Packing
from ..networks.teams import learning_agents
from ..settings.config import VDNConfig
from .advantage import generalised_advantages, successor_values
from .minibatches import check_minibatches, draw_orders, sorted_on_cpu
from .optimisers import learning_rate_schedule, make_value_optimiser, start_learner
from .partners import Partners
from .rollout import (
    Actor,
    Rollout,
    Worlds,
    collect_rollout,
    if_any_truncated,
    rollout_metrics,
    start_worlds,
)
from .shaping import make_shaping
from .training_functions import Metrics, Train, TrainState, keep_if_finite, with_parameters


@flax.struct.dataclass
class Steps:
    """Steps to learn from: M of one rollout, or the m of a minibatch."""

    observation: Array  # [M, N, bytes] uint8, packed
    action: Array  # [M, N] int32
    target: Array  # [M] float32, the lambda return of the team


def make_vdn_on_policy(env: Environment, config: VDNConfig, partners: Partners) -> Train:
    """Returns the pure functions of a run.

    Raises:
      ConfigError: the rollout doesn't divide into minibatches, or the configuration doesn't fit the
        environment.
    """
    check_minibatches(config)
    network = make_action_values(env, config)
    shaping = make_shaping(config, env.num_agents)
    optimiser = make_value_optimiser(config)
    packing = packing_of(env)
    masks = wants_masks(env, config)
    learning = jnp.asarray(learning_agents(env.num_agents, config))

    def best_values(values: Array, allowed: Array | None) -> Array:
        """Returns the value `[B]` of the best actions of all learning agents."""
        return masked(values, allowed).max(axis=-1)[..., learning].sum(axis=-1)

    def team_value(parameters: Any, observation: Array, state: Any) -> Array:
        """Returns the value `[B]` of the best actions after an observation."""
        values = cast(Array, network.apply(parameters, observation))
        return best_values(values, allowed_in(env, masks, state))

    def init(key: Array) -> TrainState:
        key, network_key, worlds_key = jax.random.split(key, 3)
        worlds = start_worlds(env, config.num_envs, (), worlds_key, partners)
        parameters = network.init(network_key, worlds.observation[:1])
        return TrainState.start(key, start_learner(parameters, optimiser), worlds)

    def make_actor(parameters: Any, epsilon: Array) -> Actor:
        """Returns agents that take their best action or, with probability `epsilon`, any."""

        def act(worlds: Worlds, key: Array) -> tuple[Any, Array, Array]:
            allowed = allowed_in(env, masks, worlds.state)
            values = cast(Array, network.apply(parameters, worlds.observation))
            return (), explore(key, values, allowed, epsilon), best_values(values, allowed)

        def follow(memory: Any, info: dict[str, Any]) -> Array:
            """Returns the team's values `[B]` of the observations at which episodes were cut."""
            del memory

            def terminal_values() -> Array:
                state = info.get("terminal_state")
                return team_value(parameters, info["terminal_observation"], state)

            return if_any_truncated(info, terminal_values)

        return Actor(act, packing.pack, follow)

    def collect(state: TrainState) -> tuple[TrainState, Any]:
        """Plays a rollout; exploration falls with the updates."""
        key, rollout_key = jax.random.split(state.key)
        epsilon = exploration(config, state.updates)
        actor = make_actor(state.learner.params, epsilon)
        worlds, rollout, finished, measured = collect_rollout(
            env, actor, state.worlds, rollout_key, config.num_steps, shaping, partners
        )
        metrics = {**rollout_metrics(rollout, finished, measured), "epsilon": epsilon}
        return replace(state, key=key, worlds=worlds), (rollout, metrics)

    def learn(state: TrainState, played: Any) -> tuple[TrainState, Metrics]:
        """Takes gradient steps towards the lambda returns of a rollout."""
        rollout, metrics = played
        before = state.learner
        key, shuffle_key = jax.random.split(state.key)
        worlds = state.worlds
        last_value = team_value(before.params, worlds.observation, worlds.state)
        steps = with_targets(rollout, last_value, config)
        learner, losses = take_gradient_steps(
            network, packing, learning, before, steps, shuffle_key, config
        )
        learner, losses["loss"] = keep_if_finite(losses["loss"], learner, before, state.diverged)
        metrics = {
            **metrics,
            **losses,
            "learning_rate": learning_rate_schedule(config)(before.step),
        }
        return state.after_update(key, learner, losses["loss"]), metrics

    return Train(init, collect, learn, lambda state: state.learner.params, with_parameters)


def with_targets(rollout: Rollout, last_value: Array, config: VDNConfig) -> Steps:
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


def take_gradient_steps(
    network: ActionValues,
    packing: Packing,
    learning: Array,
    learner: Learner,
    steps: Steps,
    key: Array,
    config: VDNConfig,
) -> tuple[Learner, Metrics]:
    """Takes `num_epochs * num_minibatches` gradient steps; losses are means over them."""

    def take_step(learner: Learner, indices: Array) -> tuple[Learner, Metrics]:
        """Takes one gradient step on the steps of a minibatch."""
        ordered = sorted_on_cpu(indices)
        minibatch = jax.tree.map(lambda leaf: leaf[ordered], steps)
        minibatch = minibatch.replace(observation=packing.unpack(minibatch.observation))
        (_, losses), gradients = jax.value_and_grad(team_loss, has_aux=True)(
            learner.params, network, learning, minibatch
        )
        losses["gradient_norm"] = optax.tree.norm(gradients)
        return learner.apply_gradients(grads=gradients), losses

    orders = draw_orders(key, 1, config)
    learner, losses = jax.lax.scan(take_step, learner, orders.reshape(-1, orders.shape[-1]))
    return learner, jax.tree.map(jnp.mean, losses)


def team_loss(
    parameters: Any, network: ActionValues, learning: Array, steps: Steps
) -> tuple[Array, Metrics]:
    """Returns half the mean squared error of the team's value, and its parts.

    The team's value is the sum of Q_i(s, a_i) over the learning agents.
    """
    values = cast(Array, network.apply(parameters, steps.observation))
    team_value = values_of_actions(values, steps.action)[..., learning].sum(axis=-1)
    loss = 0.5 * jnp.square(team_value - steps.target).mean()
    return loss, {"loss": loss, "team_value": team_value.mean()}
