"""Measures a game of SocialJax itself: environment steps a second under random actions, with its own automatic resets.

It runs in a Python of its own, with nothing of sjdsl, with the versions that SocialJax pins:

    git clone https://github.com/cooperativex/SocialJax && git -C SocialJax checkout 0d00e2b
    python3.11 -m venv original
    original/bin/pip install jax==0.4.23 jaxlib==0.4.23 flax==0.7.4 'numpy<2' 'scipy<1.13'
    original/bin/python bench/socialjax_original.py SocialJax coop_mining.coop_mining:CoopMining --agents 6

Only the game's own modules are loaded; what the rest of the package imports (Gymnax, Brax, pictures) is not needed for them. The
loop is that of `sjdsl bench`: actions are drawn within it, and all rewards and the last observations are summed up.
"""

import argparse
import importlib
import statistics
import sys
import time
import types
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp

CLIP = jnp.clip  # before others replace it by `clip`


def main() -> None:
    """Prints the steps a second: the median of the rounds, the slowest and the fastest, and the microseconds of processor time."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("checkout", help="a checkout of SocialJax")
    parser.add_argument(
        "game",
        help="module and class under socialjax/environments, such as coop_mining.coop_mining:CoopMining",
    )
    parser.add_argument("--agents", type=int, required=True)
    parser.add_argument("--envs", type=int, default=1024, help="environments side by side")
    parser.add_argument("--steps", type=int, default=25, help="of each environment in a round")
    parser.add_argument("--rounds", type=int, default=5)
    asked = parser.parse_args()
    env = load(Path(asked.checkout), asked.game)(num_agents=asked.agents, shared_rewards=False)
    run = jax.jit(make_loop(env, asked.envs, asked.steps))
    jax.block_until_ready(run(jax.random.PRNGKey(0)))
    steps = asked.envs * asked.steps
    rates = []
    microseconds = []
    for number in range(asked.rounds):
        start = time.perf_counter()
        processor_start = time.process_time()
        jax.block_until_ready(run(jax.random.PRNGKey(number + 1)))
        rates.append(steps / (time.perf_counter() - start))
        microseconds.append((time.process_time() - processor_start) / steps * 1e6)
    spread = f"{min(rates):,.0f} to {max(rates):,.0f}"
    print(f"JAX {jax.__version__}, {asked.game}, {asked.agents} agents, {asked.envs} environments")
    print(
        f"{statistics.median(rates):,.0f} steps a second ({spread}), {statistics.median(microseconds):.2f} us of processor time a step"
    )


def clip(x: Any, *bounds: Any, a_min: Any = None, a_max: Any = None, **named: Any) -> jax.Array:
    """As `jnp.clip`, but also takes its bounds by the names of JAX 0.4: newer versions need it in place of theirs."""
    if a_min is None:
        return CLIP(x, *bounds, **named)
    return CLIP(x, a_min, a_max)


def load(checkout: Path, game: str) -> Any:
    """Returns the class of a game (`module:class`). Its packages are empty modules: their own __init__ loads every game and what those need."""
    module, name = game.split(":")
    parts = ["socialjax", "environments", *module.split(".")[:-1]]
    for depth in range(1, len(parts) + 1):
        package = types.ModuleType(".".join(parts[:depth]))
        package.__path__ = [str(checkout.joinpath(*parts[:depth]))]
        sys.modules[package.__name__] = package
    return getattr(importlib.import_module(f"socialjax.environments.{module}"), name)


def make_step(env: Any) -> Any:
    """Returns a step of one environment, which begins anew at the end of an episode: (key, state, actions) to (state, rewards, observation)."""

    def step(key: jax.Array, state: Any, actions: jax.Array) -> tuple[Any, jax.Array, jax.Array]:
        """As `step` of SocialJax's MultiAgentEnv: both the next state and a new one are computed, and one of them is selected."""
        key, reset_key = jax.random.split(key)
        observation, state, reward, done, _ = env.step_env(key, state, actions)
        first_observation, new_state = env.reset(reset_key)
        state, observation = jax.tree_util.tree_map(
            lambda new, old: jax.lax.select(
                done["__all__"], jnp.asarray(new, jnp.result_type(old)), jnp.asarray(old)
            ),
            (new_state, first_observation),
            (state, observation),
        )
        return state, reward, observation

    return step


def make_loop(env: Any, num_envs: int, num_steps: int) -> Any:
    """Returns a function of a key that plays `num_steps` steps in each environment; its result is the sum of all rewards and last observations."""
    step = make_step(env)

    def run(key: jax.Array) -> jax.Array:
        reset_key, key = jax.random.split(key)
        observations, states = jax.vmap(env.reset)(jax.random.split(reset_key, num_envs))
        states = jax.tree_util.tree_map(jnp.asarray, states)

        def body(carry: Any, key: jax.Array) -> tuple[Any, None]:
            states, total, _ = carry
            action_key, step_key = jax.random.split(key)
            actions = jax.random.randint(action_key, (num_envs, env.num_agents), 0, env.num_actions)
            keys = jax.random.split(step_key, num_envs)
            states, rewards, observations = jax.vmap(step)(keys, states, actions)
            total += jnp.sum(jnp.asarray(rewards, jnp.float32))
            return (states, total, observations), None

        start = (states, jnp.float32(0), observations)
        (_, total, last), _ = jax.lax.scan(body, start, jax.random.split(key, num_steps))
        return total + jnp.sum(jnp.asarray(last, jnp.float32))

    return run


if __name__ == "__main__":
    main()
