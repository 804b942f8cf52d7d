"""RLlib's own modules on what agents see: by its wrapper of PettingZoo's environments, with the network that the page gives."""

import re
from pathlib import Path

import numpy as np
import pytest
import torch

from sjdsl.interop.pettingzoo import parallel_env

pytest.importorskip(
    "ray.rllib.algorithms.ppo", reason="RLlib is not installed", exc_type=ImportError
)

from ray.rllib.algorithms.ppo.torch.default_ppo_torch_rl_module import DefaultPPOTorchRLModule
from ray.rllib.core.rl_module.default_model_config import DefaultModelConfig
from ray.rllib.core.rl_module.rl_module import RLModuleSpec
from ray.rllib.env.wrappers.pettingzoo_env import ParallelPettingZooEnv

PAGE = (Path(__file__).parents[2] / "docs/interop/rllib.md").read_text()


def module_of(env: ParallelPettingZooEnv, config: DefaultModelConfig) -> DefaultPPOTorchRLModule:
    spaces = {
        "observation_space": env.observation_space["agent_0"],
        "action_space": env.action_space["agent_0"],
    }
    return RLModuleSpec(module_class=DefaultPPOTorchRLModule, model_config=config, **spaces).build()


def test_the_network_of_the_page_fits() -> None:
    """Its inputs are the channels, not the rows; it has an output for each action. Without it RLlib has no network for these windows."""
    env = ParallelPettingZooEnv(parallel_env("clean_up"))
    filters, dense = re.search(
        r"conv_filters=(\[.*\]), head_fcnet_hiddens=(\[.*?\])", PAGE
    ).groups()
    made = module_of(
        env, DefaultModelConfig(conv_filters=eval(filters), head_fcnet_hiddens=eval(dense))
    )
    seen, infos = env.reset(seed=0)
    assert {info["action_mask"].shape for info in infos.values()} == {(9,)}
    first = next(layer for layer in made.modules() if isinstance(layer, torch.nn.Conv2d))
    assert first.in_channels == env.observation_space["agent_0"].shape[-1]
    out = made.forward_inference({"obs": torch.as_tensor(np.stack(list(seen.values()))).float()})
    assert out["action_dist_inputs"].shape == (7, 9)
    with pytest.raises(ValueError, match="No default"):
        module_of(env, DefaultModelConfig())
