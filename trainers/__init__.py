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

__getattr__ = lazy_names(
    __name__,
    {
        "Batch": "losses",
        "Config": "config",
        "ConfigError": "config",
        "Estimate": "estimates",
        "Evaluation": "evaluation",
        "MemoryPolicy": "policies",
        "Metrics": "training_functions",
        "PPOConfig": "config",
        "Played": "ppo",
        "Policy": "policies",
        "PolicyError": "policies",
        "Preset": "preset",
        "Result": "run",
        "RunError": "run_errors",
        "Step": "step_record",
        "Train": "training_functions",
        "TrainState": "training_functions",
        "Update": "updates",
        "VDNConfig": "config",
        "allow_code": "extensions",
        "estimate": "estimates",
        "evaluate": "evaluation",
        "find_policy": "policies",
        "keep_if_finite": "training_functions",
        "load_policy": "policies",
        "load_preset": "preset",
        "make_actor_critics": "actor_critics",
        "make_config": "config",
        "make_train": "algorithms",
        "mean_episode": "episodes",
        "mixed_policy": "policies",
        "packing_of": "actor_critics",
        "ppo_loss": "ppo",
        "random_policy": "policies",
        "register": "extensions",
        "resume": "run",
        "save_evaluation": "evaluation",
        "stay_policy": "policies",
        "summarise": "evaluation",
        "train": "run",
        "trained_policy": "policies",
    },
)
