"""Trainers for any compiled game: PPO with shared parameters, evaluation, and the files of a run."""

from .config import Config, ConfigError
from .evaluate import Estimate, Evaluation, estimate, evaluate, save_evaluation, summarise
from .policies import Policy, PolicyError, load_policy, random_policy, trained_policy
from .ppo import Train, TrainState, make_train
from .preset import Preset, load_preset
from .run import Result, RunError, train

__all__ = [
    "Config",
    "ConfigError",
    "Estimate",
    "Evaluation",
    "Policy",
    "PolicyError",
    "Preset",
    "Result",
    "RunError",
    "Train",
    "TrainState",
    "estimate",
    "evaluate",
    "load_policy",
    "load_preset",
    "make_train",
    "random_policy",
    "save_evaluation",
    "summarise",
    "train",
    "trained_policy",
]
