"""Value decomposition networks (VDN): epsilon-greedy Q-learning of a team.

With a replay buffer it has a target network. Source: Sunehag et al. 2018, "Value-decomposition
networks for cooperative multi-agent learning". Without, targets are lambda returns of the rollout
just played, in many environments, and layer normalisation keeps the values from diverging. Source:
Gallici et al. 2024, "Simplifying deep temporal difference learning" (PQN), section 4.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, cast

import flax
import jax
import jax.numpy as jnp
import optax
from flax.training.train_state import TrainState as Learner
from jax import Array

from ..environment import Environment, MaskedEnvironment, reset_shapes
from ..networks.action_values import exploration, explore, make_action_values
from ..networks.actor_critics import packing_of
from ..networks.masks import allowed_in, wants_masks
from ..networks.packing import Packing
from ..networks.teams import learning_agents
from ..settings.config import ConfigError, VDNConfig
from .minibatches import check_minibatches, draw_orders, sorted_on_cpu
from .optimisers import learning_rate_schedule, make_optimiser, start_learner
from .partners import Partners
from .replay_buffer import ReplayBuffer, add_entries, draw_entries, empty_replay
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
from .training_functions import Metrics, Train, TrainState, keep_if_finite
from .vdn_targets import Steps, Team, Transition, bootstrapped, team_loss, with_lambda_returns


@flax.struct.dataclass
class ValueLearner:
    """The network, and with replay its target and the buffer."""

    online: Learner  # parameters, optimiser state and `step`, the gradient steps taken
    target: Any = None  # parameters of the target network
    replay: ReplayBuffer | None = None


def make_vdn(env: Environment, config: VDNConfig, partners: Partners) -> Train:
    """Returns the pure functions of a run.

    Raises:
      ConfigError: the rollout doesn't divide into minibatches or the replay buffer into rollouts,
        or the configuration doesn't fit the environment.
    """
    replays = config.replay == "buffer"
    if not replays:
        check_minibatches(config)
    elif config.buffer_size % config.steps_per_update:
        raise ConfigError(
            f"`buffer_size` must be a multiple of num_envs x num_steps = {config.num_envs} x "
            f"{config.num_steps} = {config.steps_per_update}, not {config.buffer_size}"
        )
    network = make_action_values(env, config)
    team = Team(network, jnp.asarray(learning_agents(env.num_agents, config)))
    shaping = make_shaping(config, env.num_agents)
    optimiser = make_optimiser(config)
    packing = packing_of(env)
    masks = wants_masks(env, config)

    def init(key: Array) -> TrainState:
        """Returns the state before the first update, with an empty replay buffer."""
        key, network_key, worlds_key = jax.random.split(key, 3)
        worlds = start_worlds(env, config.num_envs, (), worlds_key, partners)
        parameters = network.init(network_key, worlds.observation[:1])
        learner = ValueLearner(start_learner(parameters, optimiser))
        if replays:
            learner = replace(
                learner,
                target=jax.tree.map(jnp.copy, parameters),
                replay=empty_replay(_entry_shapes(env, packing, masks), config.buffer_size),
            )
        return TrainState.start(key, learner, worlds)

    def best_value(parameters: Any, observation: Array, state: Any) -> Array:
        """Returns the value `[B]` of the best actions after an observation."""
        return team.best(team.values(parameters, observation), allowed_in(env, masks, state))

    def make_actor(parameters: Any, epsilon: Array) -> Actor:
        """Returns agents that take their best action or, with probability `epsilon`, any."""

        def act(worlds: Worlds, key: Array) -> tuple[Any, Array, Array]:
            allowed = allowed_in(env, masks, worlds.state)
            values = team.values(parameters, worlds.observation)
            return (), explore(key, values, allowed, epsilon), team.best(values, allowed)

        def follow(memory: Any, info: dict[str, Any], recent: Array) -> Any:
            """Returns what a replayed step led to; else the values `[B]` where episodes were cut."""
            del memory, recent
            observation = info["terminal_observation"]
            state = info.get("terminal_state")
            if replays:
                return packing.pack(observation), allowed_in(env, masks, state)
            return if_any_truncated(info, lambda: best_value(parameters, observation, state))

        return Actor(act, packing.pack, follow)

    def collect(state: TrainState) -> tuple[TrainState, Any]:
        """Plays a rollout, perhaps into the replay buffer; exploration falls with the updates."""
        key, rollout_key = jax.random.split(state.key)
        epsilon = exploration(config, state.updates)
        actor = make_actor(state.learner.online.params, epsilon)
        worlds, rollout, finished, measured = collect_rollout(
            env, actor, state.worlds, rollout_key, config.num_steps, shaping, partners
        )
        metrics = {**rollout_metrics(rollout, finished, measured), "epsilon": epsilon}
        after = replace(state, key=key, worlds=worlds)
        if not replays:
            return after, (rollout, metrics)
        replay = add_entries(state.learner.replay, _entries(rollout))
        return replace(after, learner=replace(state.learner, replay=replay)), (None, metrics)

    def learn(state: TrainState, played: Any) -> tuple[TrainState, Metrics]:
        """Takes gradient steps on batches of the buffer, or on what was played."""
        rollout, metrics = played
        key, learn_key = jax.random.split(state.key)
        learner = state.learner
        before = learner.online
        if replays:
            online, losses = learn_from_replay(learner, learn_key, team, packing, config)
        else:
            worlds = state.worlds
            last_value = best_value(before.params, worlds.observation, worlds.state)
            steps = with_lambda_returns(rollout, last_value, config)
            online, losses = learn_from_rollout(before, steps, learn_key, team, packing, config)
        online, losses["loss"] = keep_if_finite(losses["loss"], online, before, state.diverged)
        metrics = {**metrics, **losses}
        learner = replace(learner, online=online)
        counted = before
        if replays:
            counted = online
            target = follow_target(learner.target, online.params, state.updates + 1, config)
            learner = replace(learner, target=target)
            metrics["replayed"] = learner.replay.filled
        metrics["learning_rate"] = learning_rate_schedule(config)(counted.step)
        return state.after_update(key, learner, losses["loss"]), metrics

    def parameters(state: TrainState) -> Any:
        return state.learner.online.params

    # The replay buffer is large, and a loop over seeds would copy it.
    return Train(init, collect, learn, parameters, adopt, loops=not replays)


def adopt(state: TrainState, parameters: Any) -> TrainState:
    """Returns a state with other parameters, for the network and its target."""
    learner = replace(state.learner, online=replace(state.learner.online, params=parameters))
    if learner.target is not None:
        learner = replace(learner, target=jax.tree.map(jnp.copy, parameters))
    return replace(state, learner=learner)


def _entry_shapes(env: Environment, packing: Packing, masks: bool) -> Transition:
    """Returns the shapes and dtypes of a transition. `masks`: whether actions may be forbidden."""
    observation, state = reset_shapes(env)
    packed = jax.eval_shape(packing.pack, observation)
    placeholder: Any = jax.ShapeDtypeStruct
    allowed = None
    if masks:
        allowed = jax.eval_shape(cast(MaskedEnvironment, env).allowed_actions, state)
    return Transition(
        observation=packed,
        action=placeholder((env.num_agents,), jnp.int32),
        reward=placeholder((), jnp.float32),
        following=packed,
        ended=placeholder((), jnp.bool_),
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


def learn_from_replay(
    learner: ValueLearner, key: Array, team: Team, packing: Packing, config: VDNConfig
) -> tuple[Learner, Metrics]:
    """Takes `gradient_steps` steps, each on a new batch; none until enough steps were played."""
    assert learner.replay is not None
    replay = learner.replay

    def draw_steps(parameters: Any, key: Array) -> Steps:
        drawn = draw_entries(replay, key, config.batch_size)
        batch = drawn.replace(
            observation=packing.unpack(drawn.observation),
            following=packing.unpack(drawn.following),
        )
        return bootstrapped(parameters, learner.target, batch, team, config)

    keys = jax.random.split(key, config.gradient_steps)
    online, losses = take_gradient_steps(learner.online, keys, draw_steps, team, weight=1.0)
    learns = replay.filled >= config.learning_starts
    result: tuple[Learner, Metrics] = jax.tree.map(
        lambda new, old: jnp.where(learns, new, old),
        (online, losses),
        (learner.online, jax.tree.map(jnp.zeros_like, losses)),
    )
    return result


def learn_from_rollout(
    learner: Learner, steps: Steps, key: Array, team: Team, packing: Packing, config: VDNConfig
) -> tuple[Learner, Metrics]:
    """Returns the learner after `num_epochs * num_minibatches` gradient steps, and mean losses.

    In each epoch the rollout's steps are divided at random into minibatches; the loss of one is
    half the mean squared error of the team's value.

    Args:
      learner: the network's parameters and optimiser.
      steps: all `T * B` steps of the rollout with their targets, observations packed.
      key: of the division.
    """

    def minibatch_of(_: Any, step_numbers: Array) -> Steps:
        """Returns the steps with these numbers, `[m]` int32; parameters are not needed."""
        step_numbers = sorted_on_cpu(step_numbers)
        minibatch: Steps = jax.tree.map(lambda leaf: leaf[step_numbers], steps)
        return replace(minibatch, observation=packing.unpack(minibatch.observation))

    divisions = draw_orders(key, 1, config)  # [1, epochs, minibatches, m] numbers of steps
    minibatches = divisions.reshape(-1, divisions.shape[-1])
    return take_gradient_steps(learner, minibatches, minibatch_of, team, weight=0.5)


def take_gradient_steps(
    learner: Learner,
    draws: Array,
    steps_of: Callable[[Any, Array], Steps],
    team: Team,
    weight: float,
) -> tuple[Learner, Metrics]:
    """Takes a gradient step for each draw; losses are means over them.

    Args:
      steps_of: `(parameters, draw) -> steps` to learn from.
      weight: of the squared error.
    """

    def take_step(learner: Learner, draw: Array) -> tuple[Learner, Metrics]:
        steps = steps_of(learner.params, draw)
        loss = jax.value_and_grad(team_loss, has_aux=True)
        (_, losses), gradients = loss(learner.params, team, steps, weight)
        losses["gradient_norm"] = optax.tree.norm(gradients)
        return learner.apply_gradients(grads=gradients), losses

    learner, losses = jax.lax.scan(take_step, learner, draws)
    return learner, jax.tree.map(jnp.mean, losses)


def follow_target(target: Any, online: Any, updates: Array, config: VDNConfig) -> Any:
    """Returns the target's parameters.

    Every `target_update_every` updates they move by `target_rate` towards the online ones.
    """
    rate = jnp.where(updates % config.target_update_every == 0, config.target_rate, 0.0)
    return jax.tree.map(lambda kept, new: (1.0 - rate) * kept + rate * new, target, online)
