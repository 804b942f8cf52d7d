"""A training script in the released suite's manner: the calls that its families of scripts make, with a small policy of our own.

What each family asks for is in `socialjax_scripts.toml`.
"""

import tomllib
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import optax

from sjdsl.interop import socialjax

TABLE = tomllib.loads(
    (Path(__file__).parent / "socialjax_scripts.toml").read_text(encoding="utf-8")
)
FAMILIES: dict[str, dict[str, Any]] = TABLE["families"]
GAMES: dict[str, dict[str, Any]] = TABLE["games"]
Metrics = list[dict[str, float]]


def train(family: str, config: dict[str, Any], sharing: bool = True, shown: bool = True) -> Metrics:
    """Trains for two updates; returns the means of the infos of each.

    Args:
      family: of the table.
      config: `ENV_NAME`, `ENV_KWARGS`, `NUM_ENVS`, `NUM_STEPS`, `SEED`.
      sharing: one policy for all agents, or one each.
      shown: draws two steps at the end, as the scripts do.
    """
    asked = FAMILIES[family]
    env = socialjax.make(config["ENV_NAME"], **config["ENV_KWARGS"])
    metrics = learn_policy(env, asked, config, sharing, jax.random.PRNGKey(config["SEED"]))
    if shown:
        evaluate(env, asked)
    return metrics


def learn_policy(
    env: Any, asked: dict[str, Any], config: dict[str, Any], sharing: bool, key: jax.Array
) -> Metrics:
    """Two policy-gradient steps, as IPPO, MAPPO, SVO, IRAT and TRANSFER collect their steps."""
    num_envs, agents = config["NUM_ENVS"], env.num_agents
    shape = env.observation_space()[0].shape
    actors = agents * num_envs
    init_key, reset_key, play_key = jax.random.split(key, 3)
    weights = 0.01 * jax.random.normal(
        init_key, (1 if sharing else agents, int(np.prod(shape)), env.action_space().n)
    )
    optimiser = optax.adam(1e-3)
    axes = (0, 0, 0, None) if asked.get("timestep") else (0, 0, 0)

    def logits_of(weights: jax.Array, observation: jax.Array) -> jax.Array:
        """`[E, N, rows, cols, channels]` -> `[N, E, A]`."""
        by_agent = jnp.transpose(observation, (1, 0, 2, 3, 4)).reshape(agents, num_envs, -1)
        return jnp.einsum(
            "nef,nfa->nea", by_agent, jnp.broadcast_to(weights, (agents, *weights.shape[1:]))
        )

    def play(carry: Any, _: None) -> Any:
        weights, state, observation, key, update = carry
        key, act_key, step_key = jax.random.split(key, 3)
        chosen = jax.random.categorical(act_key, logits_of(weights, observation))
        actions = [chosen[agent] for agent in env.agents]
        now = (update * config["NUM_STEPS"] * num_envs,) if asked.get("timestep") else ()
        step_keys = jax.random.split(step_key, num_envs)
        after, state, reward, done, info = jax.vmap(env.step, in_axes=axes)(
            step_keys, state, actions, *now
        )
        info = jax.tree.map(lambda x: x.reshape(actors), dict(info))
        if asked.get("joint"):
            world = jnp.transpose(observation, (0, 2, 3, 1, 4)).reshape(num_envs, *shape[:-1], -1)
            assert world.shape[-1] == shape[-1] * agents
            info["value"] = jnp.tile(world.sum(axis=(1, 2, 3)), agents)
            info["over"] = jnp.tile(done["__all__"], agents)
        ends = jnp.stack([done[str(agent)] for agent in env.agents]).reshape(actors)
        rewards = jnp.stack([reward[:, agent] for agent in env.agents]).reshape(agents, num_envs)
        return (weights, state, after, key, update), (
            observation,
            chosen,
            rewards,
            info | {"ends": ends},
        )

    def update(carry: Any, number: jax.Array) -> Any:
        weights, moments, state, observation, key = carry
        (_, state, observation, key, _), kept = jax.lax.scan(
            play, (weights, state, observation, key, number), None, config["NUM_STEPS"]
        )
        observations, chosen, rewards, info = kept

        def loss(weights: jax.Array) -> jax.Array:
            logits = jax.vmap(logits_of, in_axes=(None, 0))(weights, observations)
            taken = jnp.take_along_axis(jax.nn.log_softmax(logits), chosen[..., None], -1)[..., 0]
            return -(taken * rewards).mean()

        updates, moments = optimiser.update(jax.grad(loss)(weights), moments)
        metric = {
            **jax.tree.map(jnp.mean, info),
            "reward": rewards.mean(),
            "moved": jnp.abs(updates).sum(),
        }
        return (optax.apply_updates(weights, updates), moments, state, observation, key), metric

    observation, state = jax.vmap(env.reset, in_axes=(0,))(jax.random.split(reset_key, num_envs))
    start = (weights, optimiser.init(weights), state, observation, play_key)
    return unstacked(jax.jit(lambda start: jax.lax.scan(update, start, jnp.arange(2))[1])(start))


def evaluate(env: Any, asked: dict[str, Any]) -> None:
    """Two steps of one environment with pictures, outside of any compiled function."""
    observation, state = env.reset(jax.random.PRNGKey(0))
    pictures = [np.asarray(env.render(state))]
    for key in jax.random.split(jax.random.PRNGKey(1), 2):
        batch = jnp.stack([observation[agent] for agent in env.agents]).reshape(
            -1, *env.observation_space()[0].shape
        )
        actions = {
            agent: batch[agent].sum().astype(int) % env.action_space().n for agent in env.agents
        }
        observation, state, _, done, _ = env.step(
            key, state, [action.item() for action in actions.values()]
        )
        pictures.append(np.asarray(env.render(state)))
        assert not done["__all__"]
        if asked.get("locations"):
            assert state.agent_locs.shape == (env.num_agents, 3)
    assert {(picture.dtype, picture.ndim) for picture in pictures} == {(np.dtype(np.uint8), 3)}


def unstacked(metrics: dict[str, jax.Array]) -> Metrics:
    """Returns the metrics of each update."""
    return [
        {name: float(values[number]) for name, values in metrics.items()} for number in range(2)
    ]
