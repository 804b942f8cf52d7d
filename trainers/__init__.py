"""Trainers for any compiled game: PPO and value decomposition, evaluation, and the files of a run."""

from .config import Config, ConfigError, PPOConfig, VDNConfig, make_config
from .evaluate import Estimate, Evaluation, estimate, evaluate, save_evaluation, summarise
from .policies import MemoryPolicy, Policy, PolicyError, load_policy, random_policy, trained_policy
from .preset import Preset, load_preset
from .program import Train, TrainState, make_train
from .resuming import RunError
from .run import Result, resume, train

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
    "Train",
    "TrainState",
    "VDNConfig",
    "estimate",
    "evaluate",
    "load_policy",
    "load_preset",
    "make_config",
    "make_train",
    "random_policy",
    "resume",
    "save_evaluation",
    "summarise",
    "train",
    "trained_policy",
]
