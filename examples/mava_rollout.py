"""Clean Up in Mava's interface: a batch of environments under Jumanji's auto-reset wrapper, random actions that are allowed.

pip install 'sjdsl[mava]'
"""

import jax
import jax.numpy as jnp
from jumanji.wrappers import VmapAutoResetWrapper

from sjdsl.interop.mava import MavaGame

NUM_ENVS, NUM_STEPS = 16, 200


def main() -> float:
    """Returns the mean return of an agent over the episodes that ended."""
    env = VmapAutoResetWrapper(MavaGame("clean_up", params={"length": 100}))

    def step(carry, key):
        state, mask, returns = carry
        actions = jax.random.categorical(key, jnp.where(mask, 0.0, -jnp.inf))
        state, timestep = env.step(state, actions)
        returns = returns + timestep.reward
        ended = timestep.last()[:, None]
        return (state, timestep.observation.action_mask, jnp.where(ended, 0, returns)), (ended, jnp.where(ended, returns, 0))

    reset_key, key = jax.random.split(jax.random.PRNGKey(0))
    state, timestep = env.reset(jax.random.split(reset_key, NUM_ENVS))
    start = state, timestep.observation.action_mask, jnp.zeros((NUM_ENVS, env.num_agents))
    _, (ended, returns) = jax.jit(lambda carry: jax.lax.scan(step, carry, jax.random.split(key, NUM_STEPS)))(start)
    mean = float(returns.sum() / (ended.sum() * env.num_agents))
    print(f"{int(ended.sum())} episodes, mean return of an agent {mean:.2f}")
    return mean


if __name__ == "__main__":
    main()
