"""Trainers for any compiled game: PPO and value decomposition, evaluation, the files of a run."""

from typing import TYPE_CHECKING

from sjdsl.lazy_names import lazy_names

if TYPE_CHECKING:
    from .algorithms.episodes import mean_episode as mean_episode
    from .algorithms.losses import Batch as Batch
    from .algorithms.ppo import Played as Played
    from .algorithms.ppo import ppo_loss as ppo_loss
    from .algorithms.step_record import Step as Step
    from .algorithms.training_functions import Metrics as Metrics
    from .algorithms.training_functions import Train as Train
    from .algorithms.training_functions import TrainState as TrainState
    from .algorithms.training_functions import keep_if_finite as keep_if_finite
    from .networks.actor_critics import make_actor_critics as make_actor_critics
    from .networks.actor_critics import packing_of as packing_of
    from .policies.estimates import Estimate as Estimate
    from .policies.estimates import estimate as estimate
    from .policies.evaluation import Evaluation as Evaluation
    from .policies.evaluation import evaluate as evaluate
    from .policies.evaluation import save_evaluation as save_evaluation
    from .policies.evaluation import summarise as summarise
    from .policies.loading import MemoryPolicy as MemoryPolicy
    from .policies.loading import Policy as Policy
    from .policies.loading import PolicyError as PolicyError
    from .policies.loading import find_policy as find_policy
    from .policies.loading import load_policy as load_policy
    from .policies.loading import mixed_policy as mixed_policy
    from .policies.loading import random_policy as random_policy
    from .policies.loading import stay_policy as stay_policy
    from .policies.loading import trained_policy as trained_policy
    from .runs.make_train import make_train as make_train
    from .runs.run import Result as Result
    from .runs.run import Stage as Stage
    from .runs.run import check_stages as check_stages
    from .runs.run import resume as resume
    from .runs.run import train as train
    from .runs.run_errors import RunError as RunError
    from .runs.updates import Update as Update
    from .settings.config import Config as Config
    from .settings.config import ConfigError as ConfigError
    from .settings.config import PPOConfig as PPOConfig
    from .settings.config import VDNConfig as VDNConfig
    from .settings.config import make_config as make_config
    from .settings.extensions import allow_code as allow_code
    from .settings.extensions import register as register
    from .settings.preset import Preset as Preset
    from .settings.preset import load_preset as load_preset

__getattr__ = lazy_names(
    __name__,
    {
        "networks.actor_critics": ("make_actor_critics", "packing_of"),
        "runs.make_train": ("make_train",),
        "settings.config": ("Config", "ConfigError", "PPOConfig", "VDNConfig", "make_config"),
        "algorithms.episodes": ("mean_episode",),
        "policies.estimates": ("Estimate", "estimate"),
        "policies.evaluation": ("Evaluation", "evaluate", "save_evaluation", "summarise"),
        "settings.extensions": ("allow_code", "register"),
        "algorithms.losses": ("Batch",),
        "policies.loading": (
            "MemoryPolicy",
            "Policy",
            "PolicyError",
            "find_policy",
            "load_policy",
            "mixed_policy",
            "random_policy",
            "stay_policy",
            "trained_policy",
        ),
        "algorithms.ppo": ("Played", "ppo_loss"),
        "settings.preset": ("Preset", "load_preset"),
        "runs.run": ("Result", "Stage", "check_stages", "resume", "train"),
        "runs.run_errors": ("RunError",),
        "algorithms.step_record": ("Step",),
        "algorithms.training_functions": ("Metrics", "Train", "TrainState", "keep_if_finite"),
        "runs.updates": ("Update",),
    },
)
