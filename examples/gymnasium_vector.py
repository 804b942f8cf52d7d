"""A compiled game as a Gymnasium vector environment: each agent of each environment is a sub-environment.

pip install 'sjdsl[gymnasium]'
"""

from gymnasium.wrappers.vector import RecordEpisodeStatistics

from sjdsl.interop.gymnasium import VectorGame


def main() -> float:
    """Returns the mean return of a sub-environment."""
    env = RecordEpisodeStatistics(
        VectorGame("coins", num_envs=8, params={"length": 50, "spawn": 0.01})
    )
    env.reset(seed=0)
    env.action_space.seed(0)
    for _ in range(50):
        _, _, _, truncated, infos = env.step(env.action_space.sample())
    mean = float(infos["episode"]["r"].mean())
    print(f"{int(truncated.sum())} sub-environments ended, mean return {mean:.2f}")
    return mean


if __name__ == "__main__":
    main()
