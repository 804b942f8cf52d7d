"""Value decomposition networks (VDN): epsilon-greedy Q-learning of a team, with a target network.

It learns from a replay buffer. Source: Sunehag et al. 2018, "Value-decomposition networks for
cooperative multi-agent learning".
"""

from dataclasses import replace
from typing import Any, cast

import flax
import jax
import jax.numpy as jnp
import optax
from flax.training.train_state import TrainState as Learner
from jax import Array

from ..environment import Environment, MaskedEnvironment, array_shape, reset_shapes
from ..networks.action_values import (
    best_action,
    exploration,
    explore,
    make_action_values,
    values_of_actions,
)
from ..networks.actor_critics import packing_of
from ..networks.architectures import ActionValues
from ..networks.masks import allowed_in, masked, pack_mask, unpack_mask, wants_masks
from ..networks.packing import Packing
from ..networks.teams import learning_agents
from ..settings.config import ConfigError, VDNConfig
from .optimisers import learning_rate_schedule, make_value_optimiser, start_learner
from .partners import Partners
from .replay_buffer import ReplayBuffer, add_entries, draw_entries, empty_replay
from .rollout import Actor, Rollout, Worlds, collect_rollout, rollout_metrics, start_worlds
from .shaping import make_shaping
from .training_functions import Metrics, Train, TrainState, keep_if_finite


@flax.struct.dataclass
class Transition:
    """One step of one environment in the replay buffer."""

    observation: Array  # [N, bytes] uint8, acted on, packed
    action: Array  # [N] int32
    reward: Array  # [] float32, the team's
    following: Array  # [N, bytes] uint8, packed, after the step, before a reset
    ended: Array  # [] bool, a termination, not a truncation
    # [N, bytes] uint8, actions allowed after the step, packed; in a batch [N, A] bool; None: all
    allowed: Array | None = None


@flax.struct.dataclass
class ValueLearner:
    """Networks and replay buffer."""

    online: Learner  # parameters, optimiser state and `step`, the gradient steps taken
    target: Any  # parameters of the target network
    replay: ReplayBuffer


def make_vdn(env: Environment, config: VDNConfig, partners: Partners) -> Train:
    """Returns the pure functions of a run.

    Raises:
      ConfigError: the configuration is inconsistent or doesn't fit the environment.
    """
    if config.buffer_size % config.steps_per_update:
        raise ConfigError(
            f"`buffer_size` must be a multiple of num_envs x num_steps = {config.num_envs} x "
            f"{config.num_steps} = {config.steps_per_update}, not {config.buffer_size}"
        )
    network = make_action_values(env, config)
    shaping = make_shaping(config, env.num_agents)
    optimiser = make_value_optimiser(config)
    packing = packing_of(env)
    masks = wants_masks(env, config)

    def init(key: Array) -> TrainState:
        """Returns the state before the first update, with an empty replay buffer."""
        key, network_key, worlds_key = jax.random.split(key, 3)
        worlds = start_worlds(env, config.num_envs, (), worlds_key, partners)
        parameters = network.init(network_key, worlds.observation[:1])
        learner = ValueLearner(
            online=start_learner(parameters, optimiser),
            target=jax.tree.map(jnp.copy, parameters),
            replay=empty_replay(_entry_shapes(env, packing, masks), config.buffer_size),
        )
        return TrainState.start(key, learner, worlds)

    def collect(state: TrainState) -> tuple[TrainState, Any]:
        """Plays a rollout into the replay buffer."""
        key, rollout_key = jax.random.split(state.key)
        epsilon = exploration(config, state.updates)
        actor = make_actor(env, network, packing, masks, state.learner.online.params, epsilon)
        worlds, rollout, finished, measured = collect_rollout(
            env, actor, state.worlds, rollout_key, config.num_steps, shaping, partners
        )
        replay = add_entries(state.learner.replay, _entries(rollout))
        learner = replace(state.learner, replay=replay)
        metrics = {**rollout_metrics(rollout, finished, measured), "epsilon": epsilon}
        return replace(state, key=key, worlds=worlds, learner=learner), metrics

    def learn(state: TrainState, of_rollout: Metrics) -> tuple[TrainState, Metrics]:
        """Takes gradient steps on batches of the buffer, once it is full enough."""
        key, learn_key = jax.random.split(state.key)
        before = state.learner.online
        target = state.learner.target
        replay = state.learner.replay
        online, losses = take_gradient_steps(
            network, packing, before, target, replay, learn_key, config
        )
        learns = replay.filled >= config.learning_starts
        online, losses = jax.tree.map(
            lambda new, old: jnp.where(learns, new, old),
            (online, losses),
            (before, jax.tree.map(jnp.zeros_like, losses)),
        )
        online, losses["loss"] = keep_if_finite(losses["loss"], online, before, state.diverged)
        target = follow_target(target, online.params, state.updates + 1, config)
        learner = ValueLearner(online, target, replay)
        metrics = {
            **of_rollout,
            **losses,
            "replayed": replay.filled,
            "learning_rate": learning_rate_schedule(config)(online.step),
        }
        return state.after_update(key, learner, losses["loss"]), metrics

    def parameters(state: TrainState) -> Any:
        return state.learner.online.params

    # The replay buffer is large, and a loop over seeds would copy it.
    return Train(init, collect, learn, parameters, adopt, loops=False)


def adopt(state: TrainState, parameters: Any) -> TrainState:
    """Returns a state with other parameters, for the network and its target."""
    online = replace(state.learner.online, params=parameters)
    target = jax.tree.map(jnp.copy, parameters)
    return replace(state, learner=replace(state.learner, online=online, target=target))


def _entry_shapes(env: Environment, packing: Packing, masks: bool) -> Transition:
    """Returns the shapes and dtypes of a transition. `masks`: whether actions may be forbidden."""
    observation, state = reset_shapes(env)
    packed = jax.eval_shape(packing.pack, observation)
    allowed = None
    if masks:
        actions = jax.eval_shape(cast(MaskedEnvironment, env).allowed_actions, state)
        allowed = jax.eval_shape(pack_mask, actions)
    return Transition(
        observation=packed,
        action=array_shape((env.num_agents,), jnp.int32),
        reward=array_shape((), jnp.float32),
        following=packed,
        ended=array_shape((), jnp.bool_),
        allowed=allowed,
    )


def _entries(rollout: Rollout) -> Transition:
    """Returns a rollout's T * B transitions."""
    following, allowed = rollout.ending
    steps = Transition(
        observation=rollout.observation,
        action=rollout.action,
        reward=rollout.shaped_reward[..., 0],  # the same for all agents
        following=following,
        ended=rollout.done & ~rollout.truncated,
        allowed=allowed,
    )
    entries: Transition = jax.tree.map(lambda leaf: leaf.reshape(-1, *leaf.shape[2:]), steps)
    return entries


def make_actor(
    env: Environment,
    network: ActionValues,
    packing: Packing,
    masks: bool,
    parameters: Any,
    epsilon: Array,
) -> Actor:
    """Returns agents that take their best action or, with probability `epsilon`, a random one."""

    def act(worlds: Worlds, key: Array) -> tuple[Any, Array, None]:
        allowed = allowed_in(env, masks, worlds.state)
        values = cast(Array, network.apply(parameters, worlds.observation))
        return (), explore(key, values, allowed, epsilon), None

    def follow(memory: Any, info: dict[str, Any]) -> tuple[Array, Array | None]:
        del memory
        allowed = allowed_in(env, masks, info.get("terminal_state"))
        return packing.pack(info["terminal_observation"]), pack_mask(allowed)

    return Actor(act, packing.pack, follow)


def take_gradient_steps(
    network: ActionValues,
    packing: Packing,
    online: Learner,
    target: Any,
    replay: ReplayBuffer,
    key: Array,
    config: VDNConfig,
) -> tuple[Learner, Metrics]:
    """Takes `gradient_steps` steps, each on a new batch; losses are means over them."""

    def take_step(online: Learner, key: Array) -> tuple[Learner, Metrics]:
        """Takes one gradient step on a batch drawn from the buffer."""
        drawn = draw_entries(replay, key, config.batch_size)
        batch = drawn.replace(
            observation=packing.unpack(drawn.observation),
            following=packing.unpack(drawn.following),
            allowed=unpack_mask(drawn.allowed, network.num_actions),
        )
        loss = jax.value_and_grad(vdn_loss, has_aux=True)
        (_, losses), gradients = loss(online.params, target, network, batch, config)
        losses["gradient_norm"] = optax.tree.norm(gradients)
        return online.apply_gradients(grads=gradients), losses

    online, losses = jax.lax.scan(take_step, online, jax.random.split(key, config.gradient_steps))
    return online, jax.tree.map(jnp.mean, losses)


def vdn_loss(
    parameters: Any, target: Any, network: ActionValues, batch: Transition, config: VDNConfig
) -> tuple[Array, Metrics]:
    """Returns the mean squared error of the team's value, and its parts.

    y = r + gamma * sum over i of max_a Q'_i(s', a), with the target network Q', over the actions
    allowed in s'. After a termination y = r. With `double_q`, a is the best action of the online
    network (van Hasselt et al. 2016). The error is (y - sum over i of Q_i(s, a_i))^2. Sums are over
    the learning agents.
    """
    values = cast(Array, network.apply(parameters, batch.observation))
    learning = jnp.asarray(learning_agents(values.shape[-2], config))

    def of_team(values: Array) -> Array:
        return values[..., learning].sum(axis=-1)

    team_value = of_team(values_of_actions(values, batch.action))
    next_values = cast(Array, network.apply(target, batch.following))
    if config.double_q:
        online_values = cast(Array, network.apply(parameters, batch.following))
        following = values_of_actions(next_values, best_action(online_values, batch.allowed))
    else:
        following = masked(next_values, batch.allowed).max(axis=-1)
    wanted = batch.reward + config.gamma * jnp.where(batch.ended, 0.0, of_team(following))
    loss = jnp.square(team_value - jax.lax.stop_gradient(wanted)).mean()
    return loss, {"loss": loss, "team_value": team_value.mean()}


def follow_target(target: Any, online: Any, updates: Array, config: VDNConfig) -> Any:
    """Returns the target's parameters.

    Every `target_update_every` updates they move by `target_rate` towards the online ones.
    """
    rate = jnp.where(updates % config.target_update_every == 0, config.target_rate, 0.0)
    return jax.tree.map(lambda kept, new: (1.0 - rate) * kept + rate * new, target, online)
