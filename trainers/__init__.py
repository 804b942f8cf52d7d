"""Trainers for any compiled game: PPO and value decomposition, evaluation, and the files of a run."""

from typing import TYPE_CHECKING

from sjdsl.lazy_names import lazy_names

if TYPE_CHECKING:
    from .algorithms import make_train
    from .config import Config, ConfigError, PPOConfig, VDNConfig, make_config
    from .estimates import Estimate, estimate
    from .evaluation import Evaluation, evaluate, save_evaluation, summarise
    from .extensions import allow_code, register
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
    from .preset import Preset, load_preset
    from .run import Result, resume, train
    from .run_errors import RunError
    from .step_record import Step
    from .training_functions import Train, TrainState
    from .updates import Update

__all__ = [
    "Config",
    "ConfigError",
    "Estimate",
    "Evaluation",
    "MemoryPolicy",
    "PPOConfig",
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
    "load_policy",
    "load_preset",
    "make_config",
    "make_train",
    "mixed_policy",
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
        "Config": "config",
        "ConfigError": "config",
        "Estimate": "estimates",
        "Evaluation": "evaluation",
        "MemoryPolicy": "policies",
        "PPOConfig": "config",
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
        "load_policy": "policies",
        "load_preset": "preset",
        "make_config": "config",
        "make_train": "algorithms",
        "mixed_policy": "policies",
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
