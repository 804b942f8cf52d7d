"""A script laid out like the released suite's: its command line, its Hydra configurations, its imports; the training is our client's."""

import argparse
import sys

import hydra
import socialjax
import wandb
from omegaconf import OmegaConf
from socialjax.wrappers import baselines

from tests.interop.socialjax_client import FAMILIES, train

parser = argparse.ArgumentParser(add_help=False)
parser.add_argument("--algo", required=True)
parser.add_argument("--env", required=True)
chosen, sys.argv[1:] = parser.parse_known_args()


@hydra.main(version_base=None, config_path=f"{chosen.algo}/config", config_name=f"{FAMILIES[chosen.algo]['prefix']}_cnn_{chosen.env}")
def main(config):
    """Trains, and logs each update."""
    config = OmegaConf.to_container(config)
    config = {**config, **config.get("alg", {})}
    assert not (config["TUNE"] or config["HYP_TUNE"])
    assert config["TOTAL_TIMESTEPS"] == 2 * config["NUM_STEPS"] * config["NUM_ENVS"]
    wandb.init(project=config["PROJECT"], mode=config["WANDB_MODE"])
    for number, metric in enumerate(train(chosen.algo, socialjax, baselines, config)):
        wandb.log(metric, step=number)
    wandb.log({"Episode GIF": wandb.Video("episode.gif", caption="an episode", format="gif")})


main()
