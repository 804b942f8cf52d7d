"""An episode of a compiled game as a PettingZoo ParallelEnv, made by its registry.

pip install 'sjdsl[pettingzoo]'
"""

import pettingzoo

import sjdsl.interop.pettingzoo  # noqa: F401, registers the games


def main() -> float:
    """Returns the collective return of the episode."""
    env = pettingzoo.make(
        "parallel", "sjdsl/harvest_open-v0", params={"length": 50}, render_mode="rgb_array"
    )
    env.reset(seed=0)
    for number, agent in enumerate(env.agents):
        env.action_space(agent).seed(number)
    total = 0.0
    while env.agents:
        _, rewards, _, _, _ = env.step(
            {agent: env.action_space(agent).sample() for agent in env.agents}
        )
        total += sum(rewards.values())
    print(f"collective return {total:g}, a picture of {env.render().shape}")
    return total


if __name__ == "__main__":
    main()
