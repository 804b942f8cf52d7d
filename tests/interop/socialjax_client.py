"""A training script in the released suite's manner: the calls that its families of scripts make, with a small policy of our own.

What each family asks for stands in `socialjax_scripts.toml`. It takes the module `socialjax` and the module of wrappers as
arguments: ours, the stand-ins for the suite's, or the suite's.
"""

import tomllib
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import optax

TABLE = tomllib.loads((Path(__file__).parent / "socialjax_scripts.toml").read_text(encoding="utf-8"))
FAMILIES: dict[str, dict[str, Any]] = TABLE["families"]
GAMES: dict[str, dict[str, Any]] = TABLE["games"]
Metrics = list[dict[str, float]]


def train(family: str, suite: Any, wrappers: Any, config: dict[str, Any], sharing: bool = True, shown: bool = True) -> Metrics:
    """Trains for two updates; returns the means of the infos of each.

    Args:
      family: of the table.
      config: `ENV_NAME`, `ENV_KWARGS`, `NUM_ENVS`, `NUM_STEPS`, `SEED`.
      sharing: one policy for all agents, or one each.
      shown: draws two steps at the end, as the scripts do.
    """
    asked = FAMILIES[family]
    env = suite.make(config["ENV_NAME"], **config["ENV_KWARGS"])
    key = jax.random.PRNGKey(config["SEED"])
    if family == "VDN":
        return learn_values(env, wrappers, config, key)
    for name in asked["wrappers"]:
        wrapped = getattr(wrappers, name)
        env = wrapped(env) if name == "MAPPOWorldStateWrapper" else wrapped(env, replace_info=False)
    metrics = learn_policy(env, asked, config, sharing, key)
    if shown:
        evaluate(suite.make(config["ENV_NAME"], **config["ENV_KWARGS"]), asked)
    return metrics


def learn_policy(env: Any, asked: dict[str, Any], config: dict[str, Any], sharing: bool, key: jax.Array) -> Metrics:
    """Two policy-gradient steps, as IPPO, MAPPO, SVO, IRAT and TRANSFER collect their steps."""
    num_envs, agents = config["NUM_ENVS"], env.num_agents
    shape = env.observation_space()[0].shape
    actors = agents * num_envs
    init_key, reset_key, play_key = jax.random.split(key, 3)
    weights = 0.01 * jax.random.normal(init_key, (1 if sharing else agents, int(np.prod(shape)), env.action_space().n))
    optimiser = optax.adam(1e-3)
    axes = (0, 0, 0, None) if asked.get("timestep") else (0, 0, 0)

    def logits_of(weights: jax.Array, observation: jax.Array) -> jax.Array:
        """`[E, N, rows, cols, channels]` -> `[N, E, A]`."""
        by_agent = jnp.transpose(observation, (1, 0, 2, 3, 4)).reshape(agents, num_envs, -1)
        return jnp.einsum("nef,nfa->nea", by_agent, jnp.broadcast_to(weights, (agents, *weights.shape[1:])))

    def play(carry: Any, _: None) -> Any:
        weights, state, observation, key, update = carry
        key, act_key, step_key = jax.random.split(key, 3)
        chosen = jax.random.categorical(act_key, logits_of(weights, observation))
        actions = [chosen[agent] for agent in env.agents]
        now = (update * config["NUM_STEPS"] * num_envs,) if asked.get("timestep") else ()
        step_keys = jax.random.split(step_key, num_envs)
        after, state, reward, done, info = jax.vmap(env.step, in_axes=axes)(step_keys, state, actions, *now)
        info = jax.tree.map(lambda x: x.reshape(actors), dict(info))
        if asked.get("joint"):
            world = jnp.transpose(observation, (0, 2, 3, 1, 4)).reshape(num_envs, *shape[:-1], -1)
            assert world.shape[-1] == shape[-1] * agents
            info["value"] = jnp.tile(world.sum(axis=(1, 2, 3)), agents)
            info["over"] = jnp.tile(done["__all__"], agents)
        ends = jnp.stack([done[str(agent)] for agent in env.agents]).reshape(actors)
        rewards = jnp.stack([reward[:, agent] for agent in env.agents]).reshape(agents, num_envs)
        return (weights, state, after, key, update), (observation, chosen, rewards, info | {"ends": ends})

    def update(carry: Any, number: jax.Array) -> Any:
        weights, moments, state, observation, key = carry
        (_, state, observation, key, _), kept = jax.lax.scan(play, (weights, state, observation, key, number), None, config["NUM_STEPS"])
        observations, chosen, rewards, info = kept

        def loss(weights: jax.Array) -> jax.Array:
            logits = jax.vmap(logits_of, in_axes=(None, 0))(weights, observations)
            taken = jnp.take_along_axis(jax.nn.log_softmax(logits), chosen[..., None], -1)[..., 0]
            return -(taken * rewards).mean()

        updates, moments = optimiser.update(jax.grad(loss)(weights), moments)
        metric = {**jax.tree.map(jnp.mean, info), "reward": rewards.mean(), "moved": jnp.abs(updates).sum()}
        return (optax.apply_updates(weights, updates), moments, state, observation, key), metric

    observation, state = jax.vmap(env.reset, in_axes=(0,))(jax.random.split(reset_key, num_envs))
    start = (weights, optimiser.init(weights), state, observation, play_key)
    return unstacked(jax.jit(lambda start: jax.lax.scan(update, start, jnp.arange(2))[1])(start))


def learn_values(env: Any, wrappers: Any, config: dict[str, Any], key: jax.Array) -> Metrics:
    """Two updates of joint action values, for one seed of a batch of seeds, as VDN's scripts have it."""
    env = wrappers.LogWrapper(env, replace_info=False)

    def run(key: jax.Array) -> Any:
        wrapped = wrappers.CTRolloutManager(env, batch_size=config["NUM_ENVS"], preprocess_obs=False)
        tested = wrappers.CTRolloutManager(env, batch_size=config["NUM_ENVS"] + 1, preprocess_obs=False)
        shape = env.observation_space()[0].shape
        weights = jnp.zeros((int(np.prod(shape)), wrapped.max_action_space))
        batched = lambda x: jnp.stack([x[str(agent)] for agent in env.agents])  # noqa: E731
        values = lambda weights, seen: jnp.einsum("nef,fa->nea", batched(seen).reshape(len(env.agents), -1, len(weights)), weights)  # noqa: E731
        observation, state = wrapped.batch_reset(key)
        sampled = {str(agent): wrapped.batch_sample(key, agent) for agent in env.agents}
        wrapped.batch_step(key, state, sampled)

        def step(carry: Any, key: jax.Array) -> Any:
            weights, observation, state = carry
            allowed = wrapped.get_valid_actions(state)
            best = jnp.argmax(values(weights, observation) - 1e10 * (1 - batched(allowed)), axis=-1)
            keys = jax.random.split(key, len(env.agents))
            tried = jnp.stack([wrapped.batch_sample(keys[number], agent) for number, agent in enumerate(env.agents)])
            best = jnp.where(jax.random.bernoulli(key, 0.7, best.shape), tried, best)
            wanted = {str(agent): best[number] for number, agent in enumerate(env.agents)}
            after, state, reward, done, info = wrapped.batch_step(key, state, wanted)

            def loss(weights: jax.Array) -> jax.Array:
                taken = jnp.take_along_axis(values(weights, observation), best[..., None], axis=-1)[..., 0].sum(axis=0)
                aim = reward["__all__"] + (1 - done["__all__"]) * values(weights, after).max(axis=-1).sum(axis=0)
                return jnp.mean((taken - jax.lax.stop_gradient(aim)) ** 2)

            moved = jax.grad(loss)(weights)
            infos = jax.tree.map(jnp.mean, dict(info))
            metric = infos | {"reward": reward["__all__"].mean(), "moved": jnp.abs(moved).sum(), "joint": observation["__all__"].mean()}
            return (weights - 1e-3 * moved, after, state), metric | {"ends": done["__all__"].mean()}

        seen, _ = tested.batch_reset(key)
        assert seen["0"].shape == (config["NUM_ENVS"] + 1, *shape)
        _, metrics = jax.lax.scan(step, (weights, observation, state), jax.random.split(key, 2 * config["NUM_STEPS"]))
        return jax.tree.map(lambda x: x.reshape(2, -1).mean(axis=1), metrics)

    return unstacked(jax.tree.map(lambda x: x[0], jax.jit(jax.vmap(run))(jax.random.split(key, 1))))


def evaluate(env: Any, asked: dict[str, Any]) -> None:
    """Two steps of one environment with pictures, outside of any compiled function."""
    observation, state = env.reset(jax.random.PRNGKey(0))
    pictures = [np.asarray(env.render(state))]
    for key in jax.random.split(jax.random.PRNGKey(1), 2):
        batch = jnp.stack([observation[agent] for agent in env.agents]).reshape(-1, *env.observation_space()[0].shape)
        actions = {agent: batch[agent].sum().astype(int) % env.action_space().n for agent in env.agents}
        observation, state, _, done, _ = env.step(key, state, [action.item() for action in actions.values()])
        pictures.append(np.asarray(env.render(state)))
        assert not done["__all__"]
        if asked.get("locations"):
            assert state.agent_locs.shape == (env.num_agents, 3)
    assert {(picture.dtype, picture.ndim) for picture in pictures} == {(np.dtype(np.uint8), 3)}


def unstacked(metrics: dict[str, jax.Array]) -> Metrics:
    """Returns the metrics of each update."""
    return [{name: float(values[number]) for name, values in metrics.items()} for number in range(2)]
