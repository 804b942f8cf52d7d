"""Clean Up in JaxMARL's interface: a batch of environments under its own LogWrapper, random actions.

pip install 'sjdsl[jaxmarl]'
"""

import jax
import jax.numpy as jnp
from jaxmarl.wrappers.baselines import LogWrapper

from sjdsl.interop.jaxmarl import JaxMARLGame

NUM_ENVS, NUM_STEPS = 16, 200


def main() -> float:
    """Returns the mean return of an agent over the episodes that ended."""
    env = LogWrapper(JaxMARLGame("clean_up", params={"length": 100}))

    def step(carry, key):
        state, _ = carry
        act_key, step_key = jax.random.split(key)
        keys = dict(zip(env.agents, jax.random.split(act_key, env.num_agents), strict=True))
        actions = {
            a: jax.random.randint(keys[a], (NUM_ENVS,), 0, env.action_space(a).n)
            for a in env.agents
        }
        observation, state, _, _, info = jax.vmap(env.step)(
            jax.random.split(step_key, NUM_ENVS), state, actions
        )
        return (state, observation), info

    reset_key, key = jax.random.split(jax.random.key(0))
    observation, state = jax.vmap(env.reset)(jax.random.split(reset_key, NUM_ENVS))
    _, info = jax.jit(lambda carry: jax.lax.scan(step, carry, jax.random.split(key, NUM_STEPS)))(
        (state, observation)
    )
    ended = info["returned_episode"]
    mean = float(jnp.where(ended, info["returned_episode_returns"], 0).sum() / ended.sum())
    print(f"{int(ended[..., 0].sum())} episodes, mean return of an agent {mean:.2f}")
    return mean


if __name__ == "__main__":
    main()
