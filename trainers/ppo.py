"""Proximal policy optimisation for N agents that share one network (IPPO)."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import flax
import jax
import jax.numpy as jnp
import optax
from flax.training.train_state import TrainState as Learner
from jax import Array

from .advantage import generalised_advantages, successor_values
from .config import Config, ConfigError
from .environment import Environment, reset_shapes
from .episodes import mean_episode
from .networks import ActorCritic
from .rollout import Rollout, Worlds, chosen_log_probability, collect_rollout, start_worlds

Metrics = dict[str, Any]


@flax.struct.dataclass
class TrainState:
    """All that one update hands to the next."""

    key: Array  # [] typed key, consumed by the next update
    learner: Learner  # parameters, optimiser state and `step`, the gradient steps taken
    worlds: Worlds  # the B environments
    updates: Array  # [] int32, updates done


@flax.struct.dataclass
class Batch:
    """Samples to learn from; M = T * B * N, or one minibatch of them."""

    observation: Array  # [M, P, V, V] uint8
    action: Array  # [M] int32
    log_probability: Array  # [M] float32, when drawn
    value: Array  # [M] float32, when drawn
    advantage: Array  # [M] float32
    target: Array  # [M] float32, of the value


@dataclass(frozen=True)
class Train:
    """A training run as two pure functions: both can be jitted, and vmapped over seeds."""

    init: Callable[[Array], TrainState]  # key -> state before the first update
    update: Callable[[TrainState], tuple[TrainState, Metrics]]  # one rollout and its gradient steps


def make_network(env: Environment, config: Config) -> ActorCritic:
    """Returns the network for the environment's observations and actions.

    Raises:
      ConfigError: the environment gives no token observations.
    """
    observation, _ = reset_shapes(env)
    if observation.dtype != jnp.uint8 or observation.shape[1] != len(env.token_planes):
        raise ConfigError(
            f"trainers read token observations, uint8 with {len(env.token_planes)} planes, but `{env.name}` gives "
            f'{observation.dtype} {observation.shape}; make it with observation="tokens"'
        )
    return ActorCritic(env.num_actions, tuple(env.token_planes), config.network, config.network_width)


def make_train(env: Environment, config: Config) -> Train:
    """Returns the pure functions of a run; nothing is computed yet.

    Args:
      env: one environment.
      config: `seed` is not read here: `init` takes the key.
    Raises:
      ConfigError: the rollout does not divide into minibatches, or the observations are no tokens.
    """
    samples = config.steps_per_update * env.num_agents
    if samples % config.num_minibatches:
        raise ConfigError(
            f"num_envs x num_steps x agents = {config.num_envs} x {config.num_steps} x {env.num_agents} = {samples} "
            f"samples cannot be split into num_minibatches = {config.num_minibatches} equal parts"
        )
    network = make_network(env, config)

    def init(key: Array) -> TrainState:
        key, network_key, worlds_key = jax.random.split(key, 3)
        worlds = start_worlds(env, config.num_envs, worlds_key)
        parameters = network.init(network_key, worlds.observation)
        learner = Learner.create(apply_fn=network.apply, params=parameters, tx=make_optimiser(config))
        return TrainState(key, learner, worlds, jnp.int32(0))

    def update(state: TrainState) -> tuple[TrainState, Metrics]:
        key, rollout_key, shuffle_key = jax.random.split(state.key, 3)

        def act_and_value(observation: Array) -> tuple[Array, Array]:
            return network.apply(state.learner.params, observation)

        worlds, rollout, finished, game_metrics = collect_rollout(
            env, act_and_value, state.worlds, rollout_key, config.num_steps, config.reward
        )
        batch = flatten_rollout(rollout, act_and_value(worlds.observation)[1], config)
        learner, losses = take_epochs(state.learner, batch, shuffle_key, config)
        metrics = {
            **mean_episode(finished),
            "reward_per_step": rollout.reward.sum(axis=-1).mean(),
            "metric": game_metrics,
            **losses,
            "explained_variance": explained_variance(batch.value, batch.target),
            "learning_rate": learning_rate_schedule(config)(state.learner.step),
        }
        return TrainState(key, learner, worlds, state.updates + 1), metrics

    return Train(init, update)


def learning_rate_schedule(config: Config) -> optax.Schedule:
    """Returns the learning rate as a function of the gradient steps taken."""
    if not config.anneal_learning_rate:
        return optax.constant_schedule(config.learning_rate)
    steps = config.num_updates * config.num_epochs * config.num_minibatches
    return optax.linear_schedule(config.learning_rate, 0.0, steps)


def make_optimiser(config: Config) -> optax.GradientTransformation:
    """Returns Adam on gradients whose global norm is clipped."""
    return optax.chain(
        optax.clip_by_global_norm(config.max_gradient_norm),
        optax.adam(learning_rate_schedule(config), eps=1e-5),
    )


def flatten_rollout(rollout: Rollout, last_value: Array, config: Config) -> Batch:
    """Returns the rollout's T * B * N samples with their advantages; `last_value` is `[B, N]`."""
    successors = successor_values(rollout.value, last_value, rollout.terminal_value, rollout.done, rollout.truncated)
    advantage = generalised_advantages(rollout.shaped_reward, rollout.value, successors, rollout.done, config.gamma, config.gae_lambda)
    batch = Batch(
        observation=rollout.observation,
        action=rollout.action,
        log_probability=rollout.log_probability,
        value=rollout.value,
        advantage=advantage,
        target=rollout.value + advantage,
    )
    return jax.tree.map(lambda leaf: leaf.reshape(-1, *leaf.shape[3:]), batch)


def take_epochs(learner: Learner, batch: Batch, key: Array, config: Config) -> tuple[Learner, Metrics]:
    """Takes `num_epochs * num_minibatches` gradient steps; every epoch sees each sample once, in a new order."""

    def take_step(learner: Learner, indices: Array) -> tuple[Learner, Metrics]:
        minibatch = jax.tree.map(lambda leaf: leaf[indices], batch)
        loss = jax.value_and_grad(ppo_loss, has_aux=True)
        (_, losses), gradients = loss(learner.params, learner.apply_fn, minibatch, config)
        losses["gradient_norm"] = jnp.sqrt(sum(jnp.square(leaf).sum() for leaf in jax.tree.leaves(gradients)))
        return learner.apply_gradients(grads=gradients), losses

    def take_epoch(learner: Learner, key: Array) -> tuple[Learner, Metrics]:
        order = jax.random.permutation(key, batch.action.shape[0])
        return jax.lax.scan(take_step, learner, order.reshape(config.num_minibatches, -1))

    learner, losses = jax.lax.scan(take_epoch, learner, jax.random.split(key, config.num_epochs))
    return learner, jax.tree.map(jnp.mean, losses)


def ppo_loss(parameters: Any, apply: Callable[..., Any], batch: Batch, config: Config) -> tuple[Array, Metrics]:
    """Returns the loss of one minibatch, and its parts.

    Source: Schulman et al. 2017, equations 7 and 9; value clipping and the KL estimate as in Huang et al. 2022.
    """
    epsilon = config.clip_epsilon
    logits, value = apply(parameters, batch.observation)

    log_ratio = chosen_log_probability(logits, batch.action) - batch.log_probability
    ratio = jnp.exp(log_ratio)
    advantage = (batch.advantage - batch.advantage.mean()) / (batch.advantage.std() + 1e-8)
    clipped_ratio = jnp.clip(ratio, 1.0 - epsilon, 1.0 + epsilon)
    policy_loss = -jnp.minimum(ratio * advantage, clipped_ratio * advantage).mean()

    squared_error = jnp.square(value - batch.target)
    if config.clip_value_loss:
        clipped_value = batch.value + jnp.clip(value - batch.value, -epsilon, epsilon)
        squared_error = jnp.maximum(squared_error, jnp.square(clipped_value - batch.target))
    value_loss = 0.5 * squared_error.mean()

    entropy = -(jax.nn.softmax(logits) * jax.nn.log_softmax(logits)).sum(axis=-1).mean()
    loss = policy_loss + config.value_coefficient * value_loss - config.entropy_coefficient * entropy
    return loss, {
        "loss": loss,
        "policy_loss": policy_loss,
        "value_loss": value_loss,
        "entropy": entropy,
        "kl": (ratio - 1.0 - log_ratio).mean(),
        "clip_fraction": (jnp.abs(ratio - 1.0) > epsilon).mean(),
    }


def explained_variance(value: Array, target: Array) -> Array:
    """Returns the share of the targets' variance that the values explained; 0 where targets do not vary."""
    variance = target.var()
    return jnp.where(variance > 0, 1.0 - (target - value).var() / jnp.maximum(variance, 1e-12), 0.0)
