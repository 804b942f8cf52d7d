"""Proximal policy optimisation (PPO) of N agents: runs of IPPO and MAPPO, with shared or separate networks, and the clipped loss."""

from dataclasses import replace
from functools import partial
from itertools import accumulate
from typing import Any, cast

import flax
import jax
import jax.numpy as jnp
from flax.training.train_state import TrainState as Learner
from jax import Array

from ..devices.data_parallel import (
    ALL,
    OF_ENVS,
    SECOND_OF_ENVS,
    mean_of_all,
    over_devices,
    own_keys,
)
from ..environment import Environment
from ..networks.actor_critics import AGENTS_AXIS, ActorCritics, make_actor_critics
from ..networks.architectures import Memory
from ..networks.masks import allowed_in, masked, pack_mask, unpack_mask
from ..networks.value_scale import follow_targets, value_unit
from ..policies.loading import trained_policy
from ..settings.config import ConfigError, PPOConfig
from ..settings.own_settings import filled
from .advantage import generalised_advantages, successor_values
from .episodes import FinishedEpisodes, mean_episode
from .losses import Apply, Batch, Loss, clipped_surrogate, mean_entropy, normalised, value_loss
from .minibatches import check_minibatches, draw_orders
from .optimisers import gradient_norms, learning_rate_schedule, make_optimiser
from .partners import Partners, learning_agents
from .rollout import (
    Actor,
    Rollout,
    Worlds,
    chosen_log_probability,
    collect_rollout,
    rewarded_steps,
    start_worlds,
)
from .shaping import make_shaping
from .training_functions import Metrics, Train, TrainState, keep_if_finite


@flax.struct.dataclass
class Acting:
    """What a rollout stores of acting."""

    log_probability: Array  # [..., B, N] float32, of the drawn action
    value: Array  # [..., B, N] float32, of the observation
    allowed: Array | None = None  # [..., B, N, bytes] uint8, the allowed actions, packed; None: all


@flax.struct.dataclass
class Played:
    """One rollout of an update."""

    rollout: Rollout
    memory: Memory  # of the agents before the rollout
    finished: FinishedEpisodes  # total over the episodes that ended
    measured: dict[str, Array]  # the game's metrics, name -> [] float32, averaged over its steps


def make_ppo(env: Environment, config: PPOConfig, partners: Partners) -> Train:
    """Returns the pure functions of a run.

    Raises:
      ConfigError: the rollout doesn't divide into minibatches, or the configuration doesn't fit the environment.
    """
    check_minibatches(config)
    if config.scale_clip_epsilon:
        config = config.model_copy(update={"clip_epsilon": config.clip_epsilon / env.num_agents})
    networks = make_actor_critics(env, config)
    shaping = make_shaping(config, env.num_agents)
    learning = jnp.asarray(learning_agents(env.num_agents, config))

    def init(key: Array) -> TrainState:
        key, network_key, worlds_key = jax.random.split(key, 3)
        worlds = start_worlds(
            env, config.num_envs, networks.start_memory(config.num_envs), worlds_key, partners
        )
        learner = start_learner(networks.init(network_key, env), config)
        return TrainState(key, learner, worlds, jnp.int32(0), jnp.bool_(False))

    def play(parameters: Any, worlds: Worlds, key: Array) -> Any:
        return collect_rollout(
            env,
            make_actor(env, networks, parameters),
            worlds,
            key,
            config.num_steps,
            shaping,
            partners,
        )

    def collect(state: TrainState) -> tuple[TrainState, Played]:
        key, rollout_key = jax.random.split(state.key)
        together = over_devices(play, (ALL, OF_ENVS, ALL), (OF_ENVS, SECOND_OF_ENVS, ALL, ALL))
        worlds, rollout, finished, measured = together(
            state.learner.params, state.worlds, rollout_key
        )
        after = replace(state, key=key, worlds=worlds)
        return after, Played(rollout, state.worlds.memory, finished, measured)

    def take_steps(
        learner: Any, worlds: Worlds, rollout: Rollout, memory: Memory, key: Array
    ) -> Any:
        """Returns the learner, its losses, and the values `[1, M, N]` that the rollout had with their targets."""
        _, _, last_value = _read(
            networks, learner.params, worlds.memory, worlds.observation, worlds.state, worlds.fresh
        )
        batch = make_batch(rollout, memory, last_value, config)
        return *learn_teams(learner, batch, key, networks, config), batch.value, batch.target

    def learn(state: TrainState, played: Played) -> tuple[TrainState, Metrics]:
        rollout = played.rollout
        key, shuffle_key = jax.random.split(state.key)
        given, returned = (
            (ALL, OF_ENVS, SECOND_OF_ENVS, OF_ENVS, ALL),
            (ALL, ALL, SECOND_OF_ENVS, SECOND_OF_ENVS),
        )
        together = over_devices(take_steps, given, returned)
        learner, losses, value, target = together(
            state.learner, state.worlds, rollout, played.memory, shuffle_key
        )
        learner, losses["loss"] = keep_if_finite(
            losses["loss"], learner, state.learner, state.diverged
        )
        value, target = (leaf[..., learning] for leaf in (value, target))
        metrics = {
            **mean_episode(played.finished),
            "reward_per_step": rollout.reward.sum(axis=-1).mean(),
            "rewarded_steps": rewarded_steps(rollout.reward),
            "metric": played.measured,
            **losses,
            "explained_variance": explained_variance(value, target),
            "learning_rate": learning_rate_schedule(config)(state.learner.step.ravel()[0]),
        }
        diverged = ~jnp.isfinite(losses["loss"])
        return replace(
            state, key=key, learner=learner, updates=state.updates + 1, diverged=diverged
        ), metrics

    def adopt(state: TrainState, parameters: Any) -> TrainState:
        return replace(state, learner=replace(state.learner, params=parameters))

    return Train(
        init,
        collect,
        learn,
        lambda state: state.learner.params,
        adopt,
        partial(trained_policy, env, config),
    )


def start_learner(parameters: Any, config: PPOConfig) -> Learner:
    """Returns G learners in one: parameters `[G, ...]`, each with an optimiser."""
    optimiser = make_optimiser(config)
    result: Learner = jax.vmap(
        lambda own: Learner.create(apply_fn=None, params=own, tx=optimiser).replace(
            step=jnp.int32(0)
        )
    )(parameters)
    return result


def make_actor(env: Environment, networks: ActorCritics, parameters: Any) -> Actor:
    """Returns how agents with these parameters act: each draws its action independently."""

    def act(worlds: Worlds, key: Array) -> tuple[Memory, Array, Acting]:
        memory, logits, value = _read(
            networks, parameters, worlds.memory, worlds.observation, worlds.state, worlds.fresh
        )
        allowed = allowed_in(env, networks.masks, worlds.state)
        likes = masked(logits, allowed)
        action = draw_actions(key, likes)
        return (
            memory,
            action,
            Acting(chosen_log_probability(likes, action), value, pack_mask(allowed)),
        )

    def follow(memory: Memory, observation: Array, info: dict[str, Any]) -> Array:
        del observation
        truncated = info["truncated"]
        state = None
        if networks.state_vector is not None:
            if "terminal_state" not in info:
                raise ConfigError(
                    f'`{env.name}` gives no terminal_state in the info of a step; choose critic = "observations"'
                )
            state = info["terminal_state"]

        # Most steps end no episode, and then the second forward pass is skipped.
        result: Array = jax.lax.cond(
            truncated.any(),
            lambda memory, last, state: _read(
                networks, parameters, memory, last, state, jnp.zeros_like(truncated)
            )[2],
            lambda *_: jnp.zeros((truncated.shape[0], env.num_agents), jnp.float32),
            memory,
            info["terminal_observation"],
            state,
        )
        return result

    return Actor(act, networks.packing.pack, follow, keeps_state=networks.state_vector is not None)


def draw_actions(key: Array, logits: Array) -> Array:
    """Returns actions `[B, N]` int32 drawn independently from logits `[B, N, A]`, by inverting the cumulative distribution.

    It needs one random number for each drawn action; `jax.random.categorical` draws one for each possible action.
    """
    number, agents, _ = logits.shape
    drawn = jax.vmap(lambda own: jax.random.uniform(own, (agents,)))(own_keys(key, number))
    *before, total = accumulate(
        jnp.moveaxis(jax.nn.softmax(logits), -1, 0)
    )  # summed in order: a share of 0 changes no sum, and is not drawn
    result: Array = sum((drawn * total >= shares).astype(jnp.int32) for shares in before)
    return result


def _read(
    networks: ActorCritics,
    parameters: Any,
    memory: Memory,
    observation: Array,
    state: Any,
    fresh: Array,
) -> tuple[Memory, Array, Array]:
    """Returns the memory afterwards, logits `[B, N, A]` and values `[B, N]` of one step of B environments."""
    observation, state, fresh = jax.tree.map(lambda leaf: leaf[None], (observation, state, fresh))
    memory, logits, value = networks.apply(
        parameters, memory, observation, networks.joint(observation, state), fresh
    )
    return memory, logits[0], value[0]


def make_batch(rollout: Rollout, memory: Memory, last_value: Array, config: PPOConfig) -> Batch:
    """Returns the rollout as sequences with their advantages.

    Args:
      rollout: T steps of B environments.
      memory: of the agents before its first step.
      last_value: `[B, N]`, values of the observations after its last step.
    """
    acting: Acting = rollout.acting
    successors = successor_values(
        acting.value, last_value, rollout.ending, rollout.done, rollout.truncated
    )
    advantage = generalised_advantages(
        rollout.shaped_reward,
        acting.value,
        successors,
        rollout.done,
        config.gamma,
        config.gae_lambda,
    )
    steps = {
        "observation": rollout.observation,
        "joint": rollout.state,
        "fresh": rollout.fresh,
        "action": rollout.action,
        "log_probability": acting.log_probability,
        "value": acting.value,
        "advantage": advantage,
        "target": acting.value + advantage,
        "allowed": acting.allowed,
    }
    if config.memory == "none":
        steps = jax.tree.map(lambda leaf: leaf.reshape(1, -1, *leaf.shape[2:]), steps)
    return Batch(memory=memory, **steps)


def learn_teams(
    learner: Learner, batch: Batch, key: Array, networks: ActorCritics, config: PPOConfig
) -> tuple[Learner, Metrics]:
    """Returns the learner `[G, ...]` after its epochs; teams learn side by side, and losses are means over teams."""
    memory = jax.tree.map(lambda leaf: jnp.moveaxis(leaf, 1, 0), batch.memory)
    agents = networks.teams.indices
    number = len(agents)
    orders = draw_orders(key, number, config)

    def learn_team(
        learner: Learner, orders: Array, agents: Array, memory: Memory
    ) -> tuple[Learner, Metrics]:
        return take_epochs(
            learner,
            replace(batch, memory=memory),
            orders,
            agents,
            cast(Apply, networks.network.apply),
            networks,
            config,
        )

    if number == 1:  # vmap over a single network would turn its convolutions into a loop
        first = jax.tree.map(lambda leaf: leaf[0], (learner, memory))
        after, losses = learn_team(first[0], orders[0], agents[0], first[1])
        return jax.tree.map(lambda leaf: leaf[None], after), losses
    after, losses = jax.vmap(learn_team)(learner, orders, jnp.asarray(agents), memory)
    return after, jax.tree.map(jnp.mean, losses)


def take_epochs(
    learner: Learner,
    batch: Batch,
    orders: Array,
    agents: Any,
    apply: Apply,
    networks: ActorCritics,
    config: PPOConfig,
) -> tuple[Learner, Metrics]:
    """Takes `num_epochs * num_minibatches` gradient steps of one team.

    Args:
      learner: the learner of the team.
      batch: the rollout of all agents, with the team's memory `[M, ...]`.
      orders: `[epochs, minibatches, m]` of `draw_orders`.
      agents: `[S]` numbers of the team's agents.
      apply: the network of the team.
    """

    def take_step(learner: Learner, indices: Array) -> tuple[Learner, Metrics]:
        minibatch = sample(batch, indices, agents, networks)
        loss = jax.value_and_grad(loss_of(config), has_aux=True)
        (value, losses), gradients = mean_of_all(
            loss(learner.params, lambda *seen: apply(*seen, agents), minibatch, config)
        )
        losses = {**losses, "loss": value, **gradient_norms(gradients, config)}
        return learner.apply_gradients(grads=gradients), losses

    if config.normalise_values:
        learner = learner.replace(
            params=follow_targets(
                learner.params, batch.target[..., agents], jnp.equal(learner.step, 0)
            )
        )
    learner, losses = jax.lax.scan(take_step, learner, orders.reshape(-1, orders.shape[-1]))
    return learner, jax.tree.map(jnp.mean, losses)


def sample(batch: Batch, indices: Array, agents: Array, networks: ActorCritics) -> Batch:
    """Returns the sequences `[m]` of a team's agents `[S]`, and the input of its critic.

    Only indices are shuffled, so nothing outside the minibatch is copied.
    """
    # Unsorted, XLA fuses the shuffle into the loop that unpacks bytes, which is slow on a CPU. The order within a minibatch doesn't matter.
    indices = jax.lax.platform_dependent(indices, cpu=jnp.sort, default=lambda unsorted: unsorted)
    everybody = agents.shape[0] == batch.action.shape[AGENTS_AXIS]

    def of_sequences(leaf: Array) -> Array:
        return leaf[:, indices]

    def of_team(leaf: Array) -> Array:
        return leaf[:, indices] if everybody else leaf[:, indices[:, None], agents]

    all_windows = networks.packing.unpack(of_sequences(batch.observation))
    return Batch(
        observation=networks.packing.unpack(of_team(batch.observation)),
        joint=networks.joint(all_windows, jax.tree.map(of_sequences, batch.joint)),
        fresh=of_sequences(batch.fresh),
        memory=jax.tree.map(lambda leaf: leaf[indices], batch.memory),
        action=of_team(batch.action),
        log_probability=of_team(batch.log_probability),
        value=of_team(batch.value),
        advantage=of_team(batch.advantage),
        target=of_team(batch.target),
        allowed=unpack_mask(jax.tree.map(of_team, batch.allowed), networks.num_actions),
    )


def loss_of(config: PPOConfig) -> Loss:
    """Returns the loss that gradient steps minimise."""
    if config.loss == "ppo":
        return ppo_loss
    own = filled("loss", config.loss, config.own)

    def checked(*given: Any) -> tuple[Array, Metrics]:
        result = own(*given)
        match result:
            case (value, dict() as parts) if all(
                jnp.ndim(number) == 0 for number in (value, *parts.values())
            ):
                return value, parts
            case _:
                shapes = jax.tree.map(jnp.shape, result)
                raise ConfigError(
                    f"the loss `{config.loss}` must return a number and a dict of numbers, its metrics, not {shapes}"
                )

    return checked


def ppo_loss(
    parameters: Any, apply: Apply, batch: Batch, config: PPOConfig
) -> tuple[Array, Metrics]:
    """Returns the loss of one minibatch, and its parts.

    Source: Schulman et al. 2017, equations 7 and 9; value clipping and the KL estimate as in Huang et al. 2022.
    """
    _, logits, value = apply(parameters, batch.memory, batch.observation, batch.joint, batch.fresh)
    logits = masked(logits, batch.allowed)

    log_ratio = chosen_log_probability(logits, batch.action) - batch.log_probability
    ratio = jnp.exp(log_ratio)
    policy_loss = -clipped_surrogate(
        ratio, normalised(batch.advantage, config), config.clip_epsilon
    ).mean()
    unit = value_unit(parameters) if config.normalise_values else 1.0
    critic_loss = value_loss(value, batch.value, batch.target, unit, config)
    entropy = mean_entropy(logits)
    loss = (
        policy_loss + config.value_coefficient * critic_loss - config.entropy_coefficient * entropy
    )
    return loss, {
        "loss": loss,
        "policy_loss": policy_loss,
        "value_loss": critic_loss,
        "entropy": entropy,
        "kl": (ratio - 1.0 - log_ratio).mean(),
        "clip_fraction": (jnp.abs(ratio - 1.0) > config.clip_epsilon).mean(),
    }


def explained_variance(value: Array, target: Array) -> Array:
    """Returns the share of the targets' variance that the values explain; 0 if the targets don't vary."""
    variance = target.var()
    return jnp.where(variance > 0, 1.0 - (target - value).var() / jnp.maximum(variance, 1e-12), 0.0)
