"""An episode in the shape of a Melting Pot substrate: lists over players, RGB observations.

pip install 'sjdsl[dm_env]'
"""

import numpy as np

from sjdsl.interop.dm_env import build, get_config


def main() -> float:
    """Returns the collective return of the episode."""
    config = get_config("clean_up")
    env = build("clean_up", roles=config.default_player_roles, seed=0, params={"length": 30})
    draws = np.random.default_rng(0)
    step, total = env.reset(), 0.0
    while not step.last():
        step = env.step([int(draws.integers(spec.num_values)) for spec in env.action_spec()])
        total += sum(step.reward)
    print(
        f"collective return {total:g}, windows of {step.observation[0]['RGB'].shape}, actions {', '.join(config.action_names)}"
    )
    return total


if __name__ == "__main__":
    main()
