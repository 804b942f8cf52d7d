"""Users' own algorithms: functions of an environment and a configuration that return a `Train`."""

from dataclasses import replace
from typing import Any

from ..environment import Environment
from ..settings.config import ConfigError, PPOConfig
from ..settings.own_settings import filled
from .training_functions import Metrics, Train, TrainState

# metrics that the files and curves of a run need
NEEDED = ("loss", "episodes", "collective_return", "agent_return")


def make_own(env: Environment, config: PPOConfig) -> Train:
    """Returns the run that a user's function makes.

    The function gets the configuration with `ippo` as its algorithm, so that it can build on
    `make_train(env, config)`, and without the policy to start from, which the run adopts
    afterwards.

    Raises:
      ConfigError: the function returns something else, or (while it is traced) a run that lacks a
        needed metric.
    """
    name = config.algorithm
    program = filled("algorithm", name, config.own)(
        env, config.model_copy(update={"algorithm": "ippo", "init_from": ""})
    )
    if not isinstance(program, Train) or program.policy is None:
        raise ConfigError(
            f"the algorithm `{name}` must return a sjdsl.trainers.Train that has a `policy`, "
            f"not {program!r:.80}"
        )

    def learn(state: TrainState, played: Any) -> tuple[TrainState, Metrics]:
        """Learns as the user's run does, once its metrics are known to be whole."""
        after, metrics = program.learn(state, played)
        missing = [figure for figure in NEEDED if figure not in metrics]
        if missing:
            raise ConfigError(
                f"the metrics of the algorithm `{name}` lack {', '.join(missing)}; "
                "`mean_episode` has all but the loss"
            )
        return after, metrics

    return replace(program, learn=learn)
