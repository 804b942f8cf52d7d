"""One agent of Coins as a Gymnasium environment, by its registry; the other agent plays at random.

pip install 'sjdsl[gymnasium]'
"""

import gymnasium

import sjdsl.interop.gymnasium  # noqa: F401, registers the games


def main() -> float:
    """Returns the agent's return of an episode in which it takes allowed actions at random."""
    env = gymnasium.make(
        "sjdsl/Coins-v0", agent=0, others="random", params={"length": 50, "spawn": 0.02}
    )
    env.action_space.seed(0)
    _, info = env.reset(seed=0)
    total, over = 0.0, False
    while not over:
        _, reward, terminated, truncated, info = env.step(
            env.action_space.sample(info["action_mask"])
        )
        total, over = total + reward, terminated or truncated
    print(f"return {total:g}, own coins in the last step {info['own_coins']}")
    return total


if __name__ == "__main__":
    main()
