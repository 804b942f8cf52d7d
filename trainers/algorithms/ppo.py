"""Proximal policy optimisation (PPO) of N agents: runs of IPPO and MAPPO, and the clipped loss."""

from dataclasses import replace
from functools import partial
from itertools import accumulate
from typing import Any, cast

import flax
import jax
import jax.numpy as jnp
import optax
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
from ..networks.last_step import LastStep, over_rollout
from ..networks.masks import allowed_in, masked
from ..networks.teams import learning_agents, over_teams
from ..networks.value_scale import follow_targets, value_unit
from ..settings.config import ConfigError, PPOConfig
from ..settings.own_settings import filled
from .advantage import generalised_advantages, successor_values
from .episodes import FinishedEpisodes
from .losses import (
    Apply,
    Batch,
    Loss,
    chosen_log_probability,
    clipped_surrogate,
    mean_entropy,
    normalised,
    value_loss,
)
from .minibatches import check_minibatches, draw_orders, sorted_on_cpu
from .optimisers import learning_rate_schedule, make_optimiser, start_learner
from .partners import Partners
from .preferences import draw_preferences
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

# fields of a batch that each agent has, [L, M, N, ...]
OF_AGENTS = (
    "observation",
    "action",
    "log_probability",
    "value",
    "advantage",
    "target",
    "allowed",
)


@flax.struct.dataclass
class Acting:
    """What a rollout keeps of a step in which agents act."""

    log_probability: Array  # [..., B, N] float32, of the drawn action
    value: Array  # [..., B, N] float32, of the observation
    allowed: Array | None = None  # [..., B, N, A] bool; None: all
    last: LastStep | None = None  # leaves [..., B, G, 1, S], what agents read of their last steps
    preferences: Array | None = None  # [..., B, A] float32, added to the logits; None: none


@flax.struct.dataclass
class Played:
    """One rollout of an update."""

    rollout: Rollout
    # of the agents before the rollout; `last`, what they read of their last steps, in all of it
    memory: Memory
    finished: FinishedEpisodes  # total over the episodes that ended
    measured: dict[str, Array]  # the game's metrics, name -> [] float32, averaged over its steps


def make_ppo(env: Environment, config: PPOConfig, partners: Partners) -> Train:
    """Returns the pure functions of a run.

    Raises:
      ConfigError: the rollout doesn't divide into minibatches, or the configuration doesn't fit the
        environment.
    """
    check_minibatches(config)
    if config.scale_clip_epsilon:
        config = config.model_copy(update={"clip_epsilon": config.clip_epsilon / env.num_agents})
    networks = make_actor_critics(env, config)
    shaping = make_shaping(config, env.num_agents)
    optimiser = make_optimiser(config)
    learning = jnp.asarray(learning_agents(env.num_agents, config))

    def init(key: Array) -> TrainState:
        """Returns the state before the first update, with a learner for each team, `[G, ...]`."""
        key, network_key, worlds_key = jax.random.split(key, 3)
        memory = networks.start_memory(config.num_envs)
        worlds = start_worlds(
            env, config.num_envs, memory, worlds_key, partners, config.reward_horizons
        )
        of_teams = networks.init(network_key, env)
        learner = jax.vmap(lambda parameters: start_learner(parameters, optimiser))(of_teams)
        return TrainState.start(key, learner, worlds)

    def play(parameters: Any, worlds: Worlds, key: Array, updates: Array) -> Any:
        preferences = None
        if config.preference_noise:
            key, preference_key = jax.random.split(key)
            num_envs = worlds.fresh.shape[0]
            preferences = draw_preferences(
                preference_key, num_envs, env.num_actions, updates, config
            )
        actor = make_actor(env, networks, parameters, preferences)
        return collect_rollout(env, actor, worlds, key, config.num_steps, shaping, partners)

    def collect(state: TrainState) -> tuple[TrainState, Played]:
        """Plays a rollout, on each device in its own environments."""
        key, rollout_key = jax.random.split(state.key)
        play_all = over_devices(
            play,
            in_specs=(ALL, OF_ENVS, ALL, ALL),
            out_specs=(OF_ENVS, SECOND_OF_ENVS, ALL, ALL),
        )
        worlds, rollout, finished, measured = play_all(
            state.learner.params, state.worlds, rollout_key, state.updates
        )
        after = replace(state, key=key, worlds=worlds)
        memory = over_rollout(state.worlds.memory, rollout.acting.last)
        return after, Played(rollout, memory, finished, measured)

    def take_steps(
        learner: Any, worlds: Worlds, rollout: Rollout, memory: Memory, key: Array
    ) -> Any:
        """Returns the learner, its losses, and values `[L, M, N]` with their targets."""
        for_critic = networks.for_critic(worlds.state, worlds.recent)
        _, _, last_value = _forward(
            networks, learner.params, worlds.memory, worlds.observation, for_critic, worlds.fresh
        )
        batch = make_batch(rollout, memory, last_value, config)
        learner, losses = learn_teams(learner, batch, key, networks, config)
        return learner, losses, batch.value[..., learning], batch.target[..., learning]

    def learn(state: TrainState, played: Played) -> tuple[TrainState, Metrics]:
        """Takes the gradient steps of one rollout."""
        rollout = played.rollout
        before = state.learner
        key, shuffle_key = jax.random.split(state.key)
        take_steps_of_all = over_devices(
            take_steps,
            in_specs=(ALL, OF_ENVS, SECOND_OF_ENVS, OF_ENVS, ALL),
            out_specs=(ALL, ALL, SECOND_OF_ENVS, SECOND_OF_ENVS),
        )
        learner, losses, value, target = take_steps_of_all(
            before, state.worlds, rollout, played.memory, shuffle_key
        )
        learner, losses["loss"] = keep_if_finite(losses["loss"], learner, before, state.diverged)
        metrics = {
            **rollout_metrics(rollout, played.finished, played.measured),
            **losses,
            "explained_variance": explained_variance(value, target),
            "learning_rate": learning_rate_schedule(config)(before.step.ravel()[0]),
        }
        return state.after_update(key, learner, losses["loss"]), metrics

    return Train(init, collect, learn, lambda state: state.learner.params, with_parameters)


def make_actor(
    env: Environment, networks: ActorCritics, parameters: Any, preferences: Array | None
) -> Actor:
    """Returns how agents with these parameters act: each draws its action independently.

    Args:
      preferences: `[B, A]`, added to the logits of all agents in an environment; None: none.
    """

    def act(worlds: Worlds, key: Array) -> tuple[Memory, Array, Acting]:
        """Returns the memory afterwards, drawn actions `[B, N]`, and what learning needs of them."""
        for_critic = networks.for_critic(worlds.state, worlds.recent)
        memory, logits, value = _forward(
            networks, parameters, worlds.memory, worlds.observation, for_critic, worlds.fresh
        )
        if preferences is not None:
            logits = logits + preferences[:, None]
        allowed = allowed_in(env, networks.masks, worlds.state)
        logits = masked(logits, allowed)
        action = draw_actions(key, logits)
        log_probability = chosen_log_probability(logits, action)
        last = worlds.memory["last"] if networks.network.config.memory_reads else None
        acting = Acting(log_probability, value, allowed, last, preferences)
        return memory, action, acting

    def follow(memory: Memory, info: dict[str, Any], recent: Array) -> Array:
        """Returns the values `[B, N]` of the observations at which episodes were cut."""
        if networks.state_vector is not None and "terminal_state" not in info:
            raise ConfigError(
                f"`{env.name}` gives no terminal_state in the info of a step; "
                'choose critic = "observations"'
            )

        def terminal_values() -> Array:
            """Returns the values `[B, N]` of terminal observations."""
            fresh = jnp.zeros_like(info["truncated"])
            observation = info["terminal_observation"]
            for_critic = networks.for_critic(info.get("terminal_state"), recent)
            _, _, values = _forward(networks, parameters, memory, observation, for_critic, fresh)
            return values

        return if_any_truncated(info, terminal_values)

    return Actor(
        act,
        networks.packing.pack,
        follow,
        networks.after_step,
        networks.for_critic,
        networks.network.config.reward_horizons,
    )


def draw_actions(key: Array, logits: Array) -> Array:
    """Returns actions `[B, N]` int32, drawn independently from logits `[B, N, A]`.

    It inverts the cumulative distribution, which needs one random number for each drawn action;
    `jax.random.categorical` draws one for each possible action.
    """
    num_envs, num_agents, _ = logits.shape
    keys = own_keys(key, num_envs)
    drawn = jax.vmap(lambda key: jax.random.uniform(key, (num_agents,)))(keys)
    # summed in order: a share of 0 changes no sum, and is not drawn
    *before, total = accumulate(jnp.moveaxis(jax.nn.softmax(logits), -1, 0))
    passed = jnp.stack([drawn * total >= shares for shares in before], axis=-1)
    # A matrix product, because XLA fuses a sum into whatever reads the actions and repeats it for
    # each cell there: a linear policy and a step of Clean Up as released took 4.5 times as long.
    action = passed.astype(jnp.float32) @ jnp.ones(len(before), jnp.float32)
    return action.astype(jnp.int32)


def _forward(
    networks: ActorCritics,
    parameters: Any,
    memory: Memory,
    observation: Array,
    for_critic: Any,
    fresh: Array,
) -> tuple[Memory, Array, Array]:
    """Returns the memory afterwards, logits `[B, N, A]` and values `[B, N]` of one step."""
    observation, for_critic, fresh = jax.tree.map(
        lambda leaf: leaf[None], (observation, for_critic, fresh)
    )
    joint = networks.joint(observation, for_critic)
    memory, logits, value = networks.apply(parameters, memory, observation, joint, fresh)
    return memory, logits[0], value[0]


def make_batch(rollout: Rollout, memory: Memory, last_value: Array, config: PPOConfig) -> Batch:
    """Returns the rollout as sequences with their advantages.

    Args:
      rollout: T steps of B environments.
      memory: that of `Played`.
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
        "joint": rollout.for_critic,
        "fresh": rollout.fresh,
        "action": rollout.action,
        "log_probability": acting.log_probability,
        "value": acting.value,
        "advantage": advantage,
        "target": acting.value + advantage,
        "allowed": acting.allowed,
        "preferences": acting.preferences,
    }
    if config.memory == "none":
        steps = jax.tree.map(lambda leaf: leaf.reshape(1, -1, *leaf.shape[2:]), steps)
    return Batch(memory=memory, **steps)


def learn_teams(
    learner: Learner, batch: Batch, key: Array, networks: ActorCritics, config: PPOConfig
) -> tuple[Learner, Metrics]:
    """Returns the learner `[G, ...]` after its epochs, and its losses, as means over teams."""
    number = len(networks.teams)
    learn_team = partial(take_epochs, batch=batch, networks=networks, config=config)
    learn = over_teams(learn_team, number, in_axes=(0, 0, 0, 1), out_axes=(0, 0))
    orders = draw_orders(key, number, config)
    learner, losses = learn(learner, orders, jnp.asarray(networks.teams), batch.memory)
    return learner, jax.tree.map(jnp.mean, losses)


def take_epochs(
    learner: Learner,
    orders: Array,
    agents: Array,
    memory: Memory,
    batch: Batch,
    networks: ActorCritics,
    config: PPOConfig,
) -> tuple[Learner, Metrics]:
    """Takes `num_epochs * num_minibatches` gradient steps of one team.

    Args:
      learner: the learner of the team.
      orders: `[epochs, minibatches, m]` of `draw_orders`.
      agents: `[S]` numbers of the team's agents.
      memory: of the team, `[M, ...]`.
      batch: the rollout of all agents.
    """
    batch = replace(batch, memory=memory)
    apply = cast(Apply, networks.network.apply)
    loss = jax.value_and_grad(loss_of(config), has_aux=True)

    def take_step(learner: Learner, indices: Array) -> tuple[Learner, Metrics]:
        """Takes one gradient step on the sequences of a minibatch."""
        minibatch = take_minibatch(batch, indices, agents, networks)

        def with_preferences(*seen: Any) -> tuple[Memory, Array, Array]:
            """Reads the minibatch as when acting: with the environments' preferences, if any."""
            memory, logits, values = apply(*seen, agents)
            if minibatch.preferences is not None:
                logits = logits + minibatch.preferences[:, :, None]
            return memory, logits, values

        (value, losses), gradients = mean_of_all(
            loss(learner.params, with_preferences, minibatch, config)
        )
        losses = {**losses, "loss": value, "gradient_norm": optax.tree.norm(gradients)}
        return learner.apply_gradients(grads=gradients), losses

    if config.normalise_values:
        is_first = jnp.equal(learner.step, 0)
        params = follow_targets(learner.params, batch.target[..., agents], is_first)
        learner = learner.replace(params=params)
    learner, losses = jax.lax.scan(take_step, learner, orders.reshape(-1, orders.shape[-1]))
    return learner, jax.tree.map(jnp.mean, losses)


def take_minibatch(batch: Batch, indices: Array, agents: Array, networks: ActorCritics) -> Batch:
    """Returns the sequences `[m]` of a team's agents `[S]`, and the input of its critic.

    Only indices are shuffled, so nothing outside the minibatch is copied.
    """
    indices = sorted_on_cpu(indices)
    is_everybody = agents.shape[0] == batch.action.shape[AGENTS_AXIS]

    def of_sequences(leaf: Array) -> Array:
        return leaf[:, indices]

    def of_team(leaf: Array) -> Array:
        return leaf[:, indices] if is_everybody else leaf[:, indices[:, None], agents]

    all_windows = networks.packing.unpack(of_sequences(batch.observation))
    of_agents = {name: jax.tree.map(of_team, getattr(batch, name)) for name in OF_AGENTS}
    of_agents["observation"] = networks.packing.unpack(of_agents["observation"])
    of_critics = of_team if networks.reads_rewards else of_sequences
    for_critic = jax.tree.map(of_critics, batch.joint)
    return Batch(
        joint=networks.joint(all_windows, for_critic),
        fresh=of_sequences(batch.fresh),
        memory=jax.tree.map(lambda leaf: leaf[indices], batch.memory),
        preferences=jax.tree.map(of_sequences, batch.preferences),
        **of_agents,
    )


def loss_of(config: PPOConfig) -> Loss:
    """Returns the loss that gradient steps minimise.

    A user's own raises ConfigError when it is traced and returns something else.
    """
    if config.loss == "ppo":
        return ppo_loss
    own_loss = filled("loss", config.loss, config.own)

    def checked(*arguments: Any) -> tuple[Array, Metrics]:
        """Returns what the loss of a user gives."""
        result = own_loss(*arguments)
        match result:
            case (value, dict() as parts) if not any(map(jnp.ndim, (value, *parts.values()))):
                return value, parts
        shapes = jax.tree.map(jnp.shape, result)
        raise ConfigError(
            f"the loss `{config.loss}` must return a number and a dict of numbers, its metrics, "
            f"not {shapes}"
        )

    return checked


def ppo_loss(
    parameters: Any, apply: Apply, batch: Batch, config: PPOConfig
) -> tuple[Array, Metrics]:
    """Returns the loss of one minibatch, and its parts.

    Source: Schulman et al. 2017, equations 7 and 9; value clipping and the KL estimate as in Huang
    et al. 2022.
    """
    _, logits, value = apply(parameters, batch.memory, batch.observation, batch.joint, batch.fresh)
    logits = masked(logits, batch.allowed)

    log_ratio = chosen_log_probability(logits, batch.action) - batch.log_probability
    ratio = jnp.exp(log_ratio)
    advantage = normalised(batch.advantage, config)
    policy_loss = -clipped_surrogate(ratio, advantage, config.clip_epsilon).mean()
    unit = value_unit(parameters) if config.normalise_values else 1.0
    critic_loss = value_loss(value, batch.value, batch.target, unit, config)
    entropy = mean_entropy(logits)
    loss = policy_loss + config.value_coefficient * critic_loss
    loss = loss - config.entropy_coefficient * entropy
    return loss, {
        "loss": loss,
        "policy_loss": policy_loss,
        "value_loss": critic_loss,
        "entropy": entropy,
        "kl": (ratio - 1.0 - log_ratio).mean(),
        "clip_fraction": (jnp.abs(ratio - 1.0) > config.clip_epsilon).mean(),
    }


def explained_variance(value: Array, target: Array) -> Array:
    """Returns the share of the targets' variance that the values explain; 0 if they don't vary."""
    variance = target.var()
    explained = 1.0 - (target - value).var() / jnp.maximum(variance, 1e-12)
    return jnp.where(variance > 0, explained, 0.0)
