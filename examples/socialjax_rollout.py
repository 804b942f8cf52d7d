"""A SocialJax script after changing its import line: coins under individual reward, at that suite's scale."""

import jax
import jax.numpy as jnp

from sjdsl.interop import socialjax  # before: import socialjax

NUM_ENVS, NUM_STEPS = 8, 100


def main() -> float:
    """Returns the mean reward of a step."""
    env = socialjax.make(
        "coin_game", num_agents=2, num_inner_steps=50, shared_rewards=False, regrow_rate=0.005
    )
    network_input = (env.observation_space()[0]).shape
    print(f"observations {network_input}, {env.action_space().n} actions")

    def step(carry, key):
        state, _ = carry
        act_key, step_key = jax.random.split(key)
        chosen = jax.random.randint(act_key, (env.num_agents, NUM_ENVS), 0, env.action_space().n)
        actions = [chosen[agent] for agent in env.agents]
        observation, state, reward, done, info = jax.vmap(env.step)(
            jax.random.split(step_key, NUM_ENVS), state, actions
        )
        return (state, observation), (reward, done["__all__"], info["eat_own_coins"])

    reset_key, key = jax.random.split(jax.random.PRNGKey(0))
    observation, state = jax.vmap(env.reset)(jax.random.split(reset_key, NUM_ENVS))
    run = jax.jit(lambda carry: jax.lax.scan(step, carry, jax.random.split(key, NUM_STEPS))[1])
    reward, done, own = run((state, observation))
    print(
        f"{int(done.sum())} episodes, mean reward {float(reward.mean()):.4f}, own coins {float(jnp.sum(own)) / env.num_agents:.0f}"
    )
    return float(reward.mean())


if __name__ == "__main__":
    main()
