"""Proximal policy optimisation in one file, from top to bottom: trains agents that share a network in any game.

    python examples/ppo_single_file.py                        # Coins, each agent for the sum of both rewards: about two minutes
    python examples/ppo_single_file.py harvest_open --steps 2e6 --reward individual

What is named after a paper is that paper's: PPO, Schulman et al. 2017; GAE, Schulman et al. 2016; orthogonal starts and the sizes of
heads, Huang et al. 2022. `sjdsl train` has the rest: other algorithms and rewards, checkpoints, policies, evaluation.

Axes: T steps of a rollout, B environments, N agents, A actions.
"""

import argparse
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import flax.linen as nn
import jax
import jax.numpy as jnp
import optax
from flax.training.train_state import TrainState
from jax import Array

import sjdsl

B = 64  # environments played at once
T = 125  # steps of a rollout
EPOCHS = 2  # times that each rollout is learnt from
MINIBATCHES = 8  # gradient steps of an epoch
LEARNING_RATE = 1e-3  # falls to 0 over the run
GAMMA = 0.99  # a reward t steps away counts GAMMA ** t
LAMBDA = 0.95  # of GAE: 0 trusts the critic, 1 the returns
CLIP = 0.2  # how far a gradient step may move the probability of an action
ENTROPY = 0.01  # weight of acting at random
VALUE = 0.5  # weight of the critic's error


class ActorCritic(nn.Module):
    """From what an agent sees to the logits of its actions, and the value of where it is."""

    num_actions: int

    @nn.compact
    def __call__(self, observation: Array) -> tuple[Array, Array]:
        """observation: `[..., C, rows, columns]` of 0 and 1. Returns logits `[..., A]` and values `[...]`."""
        dense = partial(nn.Dense, kernel_init=nn.initializers.orthogonal(2.0**0.5))
        seen = observation.reshape(*observation.shape[:-3], -1).astype(jnp.float32)
        features = nn.relu(dense(64)(seen))
        actor, critic = nn.relu(dense(64)(features)), nn.relu(dense(64)(features))
        logits = nn.Dense(self.num_actions, kernel_init=nn.initializers.orthogonal(0.01))(
            actor
        )  # at first, all actions are as likely
        value = nn.Dense(1, kernel_init=nn.initializers.orthogonal(1.0))(critic)
        return logits, value[..., 0]


class Rollout(NamedTuple):
    """What T steps in B environments leave behind, `[T, B, N, ...]`."""

    observation: Array
    action: Array
    log_probability: Array  # of the action, when it was drawn
    value: Array  # of the observation, when it was acted on
    reward: Array  # learnt from
    done: Array  # [T, B], the episode ended with this step


def collect(
    env: sjdsl.Environment,
    learner: TrainState,
    worlds: tuple[Array, object],
    key: Array,
    common: bool,
):
    """Plays T steps; returns the worlds afterwards, the rollout, and the reward that all agents together had in a step."""

    def step(worlds: tuple[Array, object], key: Array):
        observation, state = worlds
        action_key, env_key = jax.random.split(key)
        logits, value = learner.apply_fn(learner.params, observation)
        action = jax.random.categorical(action_key, logits)
        following, state, reward, done, _ = jax.vmap(env.step)(
            jax.random.split(env_key, B), state, action
        )  # resets what has ended
        learnt = (
            jnp.broadcast_to(reward.mean(axis=-1, keepdims=True), reward.shape)
            if common
            else reward
        )
        taken = Rollout(
            observation, action, log_probability_of(logits, action), value, learnt, done
        )
        return (following, state), (taken, reward.sum(axis=-1))

    worlds, (rollout, earned) = jax.lax.scan(step, worlds, jax.random.split(key, T))
    return worlds, rollout, earned.mean()


def log_probability_of(logits: Array, action: Array) -> Array:
    """Returns the log probability `[...]` of actions `[...]` under logits `[..., A]`."""
    return jnp.take_along_axis(jax.nn.log_softmax(logits), action[..., None], axis=-1)[..., 0]


def advantages_of(rollout: Rollout, last_value: Array) -> Array:
    """Returns by how much each action was better than expected, `[T, B, N]`: generalised advantage estimation.

    delta_t = r_t + GAMMA * V(s_{t+1}) - V(s_t);  A_t = delta_t + GAMMA * LAMBDA * A_{t+1}; both are cut where an episode ends.
    """
    goes_on = 1.0 - rollout.done[..., None]

    def backwards(after: tuple[Array, Array], step: tuple[Array, Array, Array]):
        advantage, next_value = after
        reward, value, goes_on = step
        delta = reward + GAMMA * goes_on * next_value - value
        advantage = delta + GAMMA * LAMBDA * goes_on * advantage
        return (advantage, value), advantage

    start = jnp.zeros_like(last_value), last_value
    _, advantages = jax.lax.scan(
        backwards, start, (rollout.reward, rollout.value, goes_on), reverse=True
    )
    return advantages


def loss_of(
    parameters: object, apply: Callable[..., tuple[Array, Array]], batch: tuple[Rollout, Array]
) -> Array:
    """Returns what a gradient step makes smaller, of samples `[M, N]`: PPO's clipped loss, the critic's error, less the entropy."""
    rollout, advantage = batch
    logits, value = apply(parameters, rollout.observation)
    ratio = jnp.exp(log_probability_of(logits, rollout.action) - rollout.log_probability)
    target = rollout.value + advantage
    advantage = (advantage - advantage.mean()) / jnp.maximum(
        advantage.std(), 0.03
    )  # where nothing is paid, it is noise: not enlarged
    policy_loss = -jnp.minimum(
        ratio * advantage, jnp.clip(ratio, 1 - CLIP, 1 + CLIP) * advantage
    ).mean()
    value_loss = 0.5 * jnp.square(value - target).mean()
    entropy = -(jax.nn.softmax(logits) * jax.nn.log_softmax(logits)).sum(axis=-1).mean()
    return policy_loss + VALUE * value_loss - ENTROPY * entropy


def learn(learner: TrainState, rollout: Rollout, advantages: Array, key: Array) -> TrainState:
    """Takes EPOCHS x MINIBATCHES gradient steps: each epoch sees every step once, in a new order."""
    steps = jax.tree.map(lambda leaf: leaf.reshape(T * B, *leaf.shape[2:]), (rollout, advantages))
    orders = jax.vmap(lambda own: jax.random.permutation(own, T * B))(jax.random.split(key, EPOCHS))

    def gradient_step(learner: TrainState, chosen: Array):
        batch = jax.tree.map(lambda leaf: leaf[chosen], steps)
        gradient = jax.grad(loss_of)(learner.params, learner.apply_fn, batch)
        return learner.apply_gradients(grads=gradient), None

    return jax.lax.scan(gradient_step, learner, orders.reshape(EPOCHS * MINIBATCHES, -1))[0]


def start(
    env: sjdsl.Environment, updates: int, key: Array
) -> tuple[TrainState, tuple[Array, object]]:
    """Returns the network before it has learnt, with its optimiser, and B new environments."""
    network_key, worlds_key = jax.random.split(key)
    observation, state = jax.vmap(env.reset)(jax.random.split(worlds_key, B))
    network = ActorCritic(env.num_actions)
    rate = optax.linear_schedule(LEARNING_RATE, 0.0, updates * EPOCHS * MINIBATCHES)
    optimiser = optax.chain(optax.clip_by_global_norm(0.5), optax.adam(rate, eps=1e-5))
    learner = TrainState.create(
        apply_fn=network.apply, params=network.init(network_key, observation), tx=optimiser
    )
    return learner, (observation, state)


def where(
    chosen: Array, worlds: tuple[Array, object], others: tuple[Array, object]
) -> tuple[Array, object]:
    """Returns the worlds that are chosen, `[B]` bool, and the others where they are not."""
    return jax.tree.map(
        lambda one, other: jnp.where(chosen.reshape(B, *[1] * (one.ndim - 1)), one, other),
        worlds,
        others,
    )


def train(
    game: str,
    steps: float,
    common: bool = True,
    seed: int = 0,
    say: Callable[[str], None] = print,
    **changes: object,
) -> list[float]:
    """Trains; returns the return of an episode, of all agents together, that the rewards of each update come to.

    Args:
      game: anything that `sjdsl.make` takes, as it does `changes`.
      steps: environment steps, rounded up to whole rollouts.
      common: whether agents learn from the mean reward of all; else each from its own.
    """
    env = sjdsl.make(game, observation="onehot", **changes)
    updates = -(-int(steps) // (B * T))
    start_key, key = jax.random.split(jax.random.key(seed))
    learner, worlds = start(env, updates, start_key)
    rollouts = -(-env.episode_length // T)  # that an episode spans

    play = jax.jit(lambda learner, worlds, key: collect(env, learner, worlds, key, common))

    @jax.jit
    def update(learner: TrainState, worlds: tuple[Array, object], key: Array):
        play_key, learn_key = jax.random.split(key)
        worlds, rollout, earned = collect(env, learner, worlds, play_key, common)
        last_value = learner.apply_fn(learner.params, worlds[0])[1]
        return (
            learn(learner, rollout, advantages_of(rollout, last_value), learn_key),
            worlds,
            earned,
        )

    # Environments that begin together end together, and each update would see one part of an episode: so some of them begin before others.
    for number in range(1, rollouts):
        key, play_key = jax.random.split(key)
        played, _, _ = play(learner, worlds, play_key)
        worlds = where(jnp.arange(B) * rollouts // B >= number, played, worlds)

    returns = []
    for number in range(1, updates + 1):
        key, update_key = jax.random.split(key)
        learner, worlds, earned = update(learner, worlds, update_key)
        returns.append(float(earned) * env.episode_length)
        if number % max(1, updates // 20) == 0:
            say(f"{number * B * T:>11,} steps: {returns[-1]:.1f} an episode")
    return returns


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("game", nargs="?", default="coins")
    parser.add_argument("--steps", type=float, default=3e6)
    parser.add_argument("--reward", choices=["common", "individual"], default="common")
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    train(asked.game, asked.steps, asked.reward == "common", asked.seed)
