"""Algorithms of one's own: functions of an environment and a configuration that make a `Train`."""

from dataclasses import replace
from typing import Any

from .config import ConfigError, PPOConfig
from .environment import Environment
from .own_settings import filled
from .training_functions import Metrics, Train, TrainState

NEEDED = ("loss", "episodes", "collective_return", "agent_return")  # metrics that files and curves of a run are made of


def make_own(env: Environment, config: PPOConfig) -> Train:
    """Returns the run that a user's function makes.

    It is given the configuration with `ippo` as its algorithm, so that `make_train(env, config)` is a run to begin with, and without the
    policy to start from, which a run adopts afterwards.

    Raises:
      ConfigError: the function makes something else, or a run whose metrics lack what is needed; the latter while it is traced.
    """
    name = config.algorithm
    program = filled("algorithm", name, config.own)(env, config.model_copy(update={"algorithm": "ippo", "init_from": ""}))
    if not isinstance(program, Train) or program.policy is None:
        raise ConfigError(f"the algorithm `{name}` must return a sjdsl.trainers.Train that has a `policy`, not {program!r:.80}")

    def learn(state: TrainState, played: Any) -> tuple[TrainState, Metrics]:
        after, metrics = program.learn(state, played)
        missing = [figure for figure in NEEDED if figure not in metrics]
        if missing:
            raise ConfigError(f"the metrics of the algorithm `{name}` lack {', '.join(missing)}; `mean_episode` has all but the loss")
        return after, metrics

    return replace(program, learn=learn)
