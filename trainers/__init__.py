"""Trainers for any compiled game: PPO and value decomposition, evaluation, and the files of a run."""

from typing import TYPE_CHECKING

from sjdsl.lazy_names import lazy_names

if TYPE_CHECKING:
    from .actor_critics import make_actor_critics as make_actor_critics
    from .actor_critics import packing_of as packing_of
    from .algorithms import make_train as make_train
    from .config import Config as Config
    from .config import ConfigError as ConfigError
    from .config import PPOConfig as PPOConfig
    from .config import VDNConfig as VDNConfig
    from .config import make_config as make_config
    from .episodes import mean_episode as mean_episode
    from .estimates import Estimate as Estimate
    from .estimates import estimate as estimate
    from .evaluation import Evaluation as Evaluation
    from .evaluation import evaluate as evaluate
    from .evaluation import save_evaluation as save_evaluation
    from .evaluation import summarise as summarise
    from .extensions import allow_code as allow_code
    from .extensions import register as register
    from .losses import Batch as Batch
    from .policies import MemoryPolicy as MemoryPolicy
    from .policies import Policy as Policy
    from .policies import PolicyError as PolicyError
    from .policies import find_policy as find_policy
    from .policies import load_policy as load_policy
    from .policies import mixed_policy as mixed_policy
    from .policies import random_policy as random_policy
    from .policies import stay_policy as stay_policy
    from .policies import trained_policy as trained_policy
    from .ppo import Played as Played
    from .ppo import ppo_loss as ppo_loss
    from .preset import Preset as Preset
    from .preset import load_preset as load_preset
    from .run import Result as Result
    from .run import Stage as Stage
    from .run import check_stages as check_stages
    from .run import resume as resume
    from .run import train as train
    from .run_errors import RunError as RunError
    from .step_record import Step as Step
    from .training_functions import Metrics as Metrics
    from .training_functions import Train as Train
    from .training_functions import TrainState as TrainState
    from .training_functions import keep_if_finite as keep_if_finite
    from .updates import Update as Update

__getattr__ = lazy_names(
    __name__,
    {
        "actor_critics": ("make_actor_critics", "packing_of"),
        "algorithms": ("make_train",),
        "config": ("Config", "ConfigError", "PPOConfig", "VDNConfig", "make_config"),
        "episodes": ("mean_episode",),
        "estimates": ("Estimate", "estimate"),
        "evaluation": ("Evaluation", "evaluate", "save_evaluation", "summarise"),
        "extensions": ("allow_code", "register"),
        "losses": ("Batch",),
        "policies": (
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
        "ppo": ("Played", "ppo_loss"),
        "preset": ("Preset", "load_preset"),
        "run": ("Result", "Stage", "check_stages", "resume", "train"),
        "run_errors": ("RunError",),
        "step_record": ("Step",),
        "training_functions": ("Metrics", "Train", "TrainState", "keep_if_finite"),
        "updates": ("Update",),
    },
)
