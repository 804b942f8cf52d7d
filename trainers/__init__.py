"""Trainers for any compiled game: PPO and value decomposition, evaluation, and the files of a run."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .config import Config, ConfigError, PPOConfig, VDNConfig, make_config
    from .evaluation import Estimate, Evaluation, estimate, evaluate, save_evaluation, summarise
    from .own import register
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
    from .program import Train, TrainState, make_train
    from .resuming import RunError
    from .run import Result, resume, train
    from .step import Step
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

_HOMES = {
    "Config": "config",
    "ConfigError": "config",
    "Estimate": "evaluation",
    "Evaluation": "evaluation",
    "MemoryPolicy": "policies",
    "PPOConfig": "config",
    "Policy": "policies",
    "PolicyError": "policies",
    "Preset": "preset",
    "Result": "run",
    "RunError": "resuming",
    "Step": "step",
    "Train": "program",
    "TrainState": "program",
    "Update": "updates",
    "VDNConfig": "config",
    "estimate": "evaluation",
    "evaluate": "evaluation",
    "find_policy": "policies",
    "load_policy": "policies",
    "load_preset": "preset",
    "make_config": "config",
    "make_train": "program",
    "mixed_policy": "policies",
    "random_policy": "policies",
    "register": "own",
    "resume": "run",
    "save_evaluation": "evaluation",
    "stay_policy": "policies",
    "summarise": "evaluation",
    "train": "run",
    "trained_policy": "policies",
}


def __getattr__(name: str) -> Any:
    """Loads public names when first used: what is wrong with a configuration is said before JAX is imported."""
    if name not in _HOMES:
        raise AttributeError(f"module 'sjdsl.trainers' has no attribute {name!r}")
    from importlib import import_module

    value = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value
