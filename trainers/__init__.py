"""Trainers for any compiled game: PPO and value decomposition, evaluation, and the files of a run."""

from typing import TYPE_CHECKING

from sjdsl.lazy_names import lazy_names

if TYPE_CHECKING:
    from .actor_critics import make_actor_critics, packing_of
    from .algorithms import make_train
    from .config import Config, ConfigError, PPOConfig, VDNConfig, make_config
    from .episodes import mean_episode
    from .estimates import Estimate, estimate
    from .evaluation import Evaluation, evaluate, save_evaluation, summarise
    from .extensions import allow_code, register
    from .losses import Batch
    from .policies import (
        MemoryPolicy,
        Policy,
        PolicyError,
        find_policy,
        load_policy,
        mixed_policy,
        random_policy,
        stay_policy,
        trained_policy,
    )
    from .ppo import Played, ppo_loss
    from .preset import Preset, load_preset
    from .run import Result, resume, train
    from .run_errors import RunError
    from .step_record import Step
    from .training_functions import Metrics, Train, TrainState, keep_if_finite
    from .updates import Update

__all__ = [
    "Batch",
    "Config",
    "ConfigError",
    "Estimate",
    "Evaluation",
    "MemoryPolicy",
    "Metrics",
    "PPOConfig",
    "Played",
    "Policy",
    "PolicyError",
    "Preset",
    "Result",
    "RunError",
    "Step",
    "Train",
    "TrainState",
    "Update",
    "VDNConfig",
    "allow_code",
    "estimate",
    "evaluate",
    "find_policy",
    "keep_if_finite",
    "load_policy",
    "load_preset",
    "make_actor_critics",
    "make_config",
    "make_train",
    "mean_episode",
    "mixed_policy",
    "packing_of",
    "ppo_loss",
    "random_policy",
    "register",
    "resume",
    "save_evaluation",
    "stay_policy",
    "summarise",
    "train",
    "trained_policy",
]

__getattr__ = lazy_names(__name__)
