"""A training script in the released suite's manner: the calls it makes, in its order, with a small policy of our own."""

from typing import Any

import jax
import jax.numpy as jnp
import optax


def run_update(env: Any, num_envs: int, num_steps: int, sharing: bool, seed: int = 0) -> dict[str, jax.Array]:
    """Plays `num_steps` in `num_envs` environments and takes one policy-gradient step; returns the means of the infos.

    Args:
      sharing: one policy for all agents, or one each.
    """
    shape = env.observation_space()[0].shape
    num_actions = env.action_space().n
    actors = env.num_agents * num_envs
    key, init_key, reset_key = jax.random.split(jax.random.PRNGKey(seed), 3)
    weights = 0.01 * jax.random.normal(init_key, (1 if sharing else env.num_agents, jnp.zeros(shape).size, num_actions))
    optimiser = optax.adam(1e-3)

    def logits_of(weights: jax.Array, observation: jax.Array) -> jax.Array:
        """`[E, N, rows, cols, channels]` -> `[N, E, A]`."""
        by_agent = jnp.transpose(observation, (1, 0, 2, 3, 4)).reshape(env.num_agents, num_envs, -1)
        return jnp.einsum("nef,nfa->nea", by_agent, jnp.broadcast_to(weights, (env.num_agents, *weights.shape[1:])))

    def play(carry: Any, _: None) -> Any:
        state, observation, key, number = carry
        key, act_key, step_key = jax.random.split(key, 3)
        chosen = jax.random.categorical(act_key, logits_of(weights, observation))
        actions = [chosen[agent] for agent in env.agents]
        step_keys = jax.random.split(step_key, num_envs)
        after, state, reward, done, info = jax.vmap(env.step, in_axes=(0, 0, 0, None))(step_keys, state, actions, number)
        info = jax.tree.map(lambda x: x.reshape(actors), info)
        ends = jnp.stack([done[str(agent)] for agent in env.agents]).reshape(actors)
        rewards = jnp.stack([reward[:, agent] for agent in env.agents]).reshape(actors)
        return (state, after, key, number + num_envs), (observation, chosen, rewards, ends, info)

    observation, state = jax.vmap(env.reset, in_axes=(0,))(jax.random.split(reset_key, num_envs))
    _, (observations, chosen, rewards, ends, info) = jax.lax.scan(play, (state, observation, key, 0), None, num_steps)

    def loss(weights: jax.Array) -> jax.Array:
        logits = jax.vmap(logits_of, in_axes=(None, 0))(weights, observations)
        taken = jnp.take_along_axis(jax.nn.log_softmax(logits), chosen[..., None], -1)[..., 0]
        return -(taken.reshape(num_steps, actors) * rewards).mean()

    updates, _ = optimiser.update(jax.grad(loss)(weights), optimiser.init(weights))
    return {**jax.tree.map(jnp.mean, info), "reward": rewards.mean(), "ends": ends.sum(), "moved": jnp.abs(updates).sum()}
