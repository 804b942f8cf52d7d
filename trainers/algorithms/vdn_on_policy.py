"""Value decomposition networks without replay: Q(lambda) from whole rollouts of many environments.

Neither a replay buffer nor a target network: targets are lambda returns of the rollout just played, and layer normalisation keeps the
values from diverging. Source: Gallici et al. 2024, "Simplifying deep temporal difference learning" (PQN), section 4.
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
from ..networks.action_values import exploration, explore, make_action_values
from ..networks.actor_critics import packing_of
from ..networks.architectures import ActionValues
from ..networks.masks import allowed_in, masked, wants_masks
from ..networks.packing import Packing
from ..networks.teams import learning_agents
from ..settings.config import VDNConfig
from .advantage import generalised_advantages, successor_values
from .episodes import mean_episode
from .minibatches import check_minibatches, draw_orders
from .optimisers import learning_rate_schedule, make_value_optimiser
from .partners import Partners
from .rollout import Actor, Rollout, Worlds, collect_rollout, rewarded_steps, start_worlds
from .shaping import make_shaping
from .training_functions import Metrics, Train, TrainState, keep_if_finite


@flax.struct.dataclass
class Steps:
    """Steps to learn from: M of one rollout, or the m of a minibatch."""

    observation: Array  # [M, N, bytes] uint8, packed
    action: Array  # [M, N] int32
    target: Array  # [M] float32, the lambda return of the team


def make_vdn_on_policy(env: Environment, config: VDNConfig, partners: Partners) -> Train:
    """Returns the pure functions of a run.

    Raises:
      ConfigError: the rollout doesn't divide into minibatches, or the configuration doesn't fit the environment.
    """
    check_minibatches(config)
    network = make_action_values(env, config)
    shaping = make_shaping(config, env.num_agents)
    optimiser = make_value_optimiser(config)
    packing = packing_of(env)
    masks = wants_masks(env, config)
    learning = jnp.asarray(learning_agents(env.num_agents, config))

    def team_value(parameters: Any, observation: Array, allowed: Array | None) -> Array:
        """Returns the value `[B]` of the best actions of all learning agents."""
        values = masked(cast(Array, network.apply(parameters, observation)), allowed)
        return values.max(axis=-1)[..., learning].sum(axis=-1)

    def init(key: Array) -> TrainState:
        key, network_key, worlds_key = jax.random.split(key, 3)
        worlds = start_worlds(env, config.num_envs, (), worlds_key, partners)
        parameters = network.init(network_key, worlds.observation[:1])
        learner = Learner.create(apply_fn=None, params=parameters, tx=optimiser).replace(
            step=jnp.int32(0)
        )
        return TrainState(key, learner, worlds, jnp.int32(0), jnp.bool_(False))

    def make_actor(parameters: Any, epsilon: Array) -> Actor:
        def act(worlds: Worlds, key: Array) -> tuple[Any, Array, Array]:
            allowed = allowed_in(env, masks, worlds.state)
            values = cast(Array, network.apply(parameters, worlds.observation))
            best = masked(values, allowed).max(axis=-1)[..., learning].sum(axis=-1)
            return (), explore(key, values, allowed, epsilon), best

        def follow(memory: Any, info: dict[str, Any]) -> Array:
            del memory
            truncated = info["truncated"]

            def of_last(last: Array, state: Any) -> Array:
                return team_value(parameters, last, allowed_in(env, masks, state))

            result: Array = jax.lax.cond(
                truncated.any(),
                of_last,
                lambda *_: jnp.zeros(truncated.shape, jnp.float32),
                info["terminal_observation"],
                info.get("terminal_state"),
            )
            return result

        return Actor(act, packing.pack, follow)

    def collect(state: TrainState) -> tuple[TrainState, Any]:
        key, rollout_key = jax.random.split(state.key)
        epsilon = exploration(config, state.updates)
        actor = make_actor(state.learner.params, epsilon)
        worlds, rollout, finished, measured = collect_rollout(
            env, actor, state.worlds, rollout_key, config.num_steps, shaping, partners
        )
        return replace(state, key=key, worlds=worlds), (rollout, finished, measured, epsilon)

    def learn(state: TrainState, played: Any) -> tuple[TrainState, Metrics]:
        rollout, finished, measured, epsilon = played
        key, shuffle_key = jax.random.split(state.key)
        worlds = state.worlds
        last = team_value(
            state.learner.params, worlds.observation, allowed_in(env, masks, worlds.state)
        )
        steps = with_targets(rollout, last, config)
        learner, losses = take_gradient_steps(
            network, packing, learning, state.learner, steps, shuffle_key, config
        )
        learner, losses["loss"] = keep_if_finite(
            losses["loss"], learner, state.learner, state.diverged
        )
        metrics = {
            **mean_episode(finished),
            "reward_per_step": rollout.reward.sum(axis=-1).mean(),
            "rewarded_steps": rewarded_steps(rollout.reward),
            "metric": measured,
            **losses,
            "epsilon": epsilon,
            "learning_rate": learning_rate_schedule(config)(state.learner.step),
        }
        diverged = ~jnp.isfinite(losses["loss"])
        return replace(
            state, key=key, learner=learner, updates=state.updates + 1, diverged=diverged
        ), metrics

    def adopt(state: TrainState, parameters: Any) -> TrainState:
        return replace(state, learner=replace(state.learner, params=parameters))

    return Train(init, collect, learn, lambda state: state.learner.params, adopt)


def with_targets(rollout: Rollout, last_value: Array, config: VDNConfig) -> Steps:
    """Returns the `T * B` steps of a rollout with their targets.

    The lambda return of Q-learning is G_t = r_t + gamma * ((1 - lambda) * V_{t+1} + lambda * G_{t+1}), where V is the value of the best
    actions: it is V_t plus the generalised advantage of these values.

    Args:
      rollout: its `acting` are the values `[T, B]` of the best actions, its `ending` those of terminal observations.
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
        indices = jax.lax.platform_dependent(
            indices, cpu=jnp.sort, default=lambda unsorted: unsorted
        )
        minibatch = jax.tree.map(lambda leaf: leaf[indices], steps)
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
    """Returns half the mean squared error of the team's value, the sum over learning agents of Q_i(s, a_i), and its parts."""
    values = cast(Array, network.apply(parameters, steps.observation))
    taken = jnp.take_along_axis(values, steps.action[..., None], axis=-1)[..., 0][
        ..., learning
    ].sum(axis=-1)
    loss = 0.5 * jnp.square(taken - steps.target).mean()
    return loss, {"loss": loss, "team_value": taken.mean()}
