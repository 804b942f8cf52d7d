"""A script laid out like JaxMARL's baselines: its configuration by Hydra, its imports, its calls; it plays at random."""

from pathlib import Path

import hydra
import jax
import jaxmarl
from jaxmarl.wrappers.baselines import LogWrapper
from omegaconf import OmegaConf


@hydra.main(version_base=None, config_path="config", config_name="ippo_ff")
def main(config):
    """Plays `NUM_STEPS` steps in `NUM_ENVS` environments and says how many episodes ended."""
    config = OmegaConf.to_container(config)
    env = LogWrapper(jaxmarl.make(config["ENV_NAME"], **config["ENV_KWARGS"]))
    size = env.observation_space(env.agents[0]).shape[0]

    def step(state, key):
        keys = jax.random.split(key, config["NUM_ENVS"])
        actions = {agent: jax.vmap(env.action_space(agent).sample)(keys) for agent in env.agents}
        observation, state, reward, _, info = jax.vmap(env.step)(keys, state, actions)
        assert observation[env.agents[0]].shape == (config["NUM_ENVS"], size)
        assert set(reward) == set(env.agents)
        return state, jax.tree.map(lambda x: x.reshape(-1), info)

    _, state = jax.vmap(env.reset)(jax.random.split(jax.random.PRNGKey(config["SEED"]), config["NUM_ENVS"]))
    _, info = jax.lax.scan(step, state, jax.random.split(jax.random.PRNGKey(1), config["NUM_STEPS"]))
    ended = info["returned_episode"]
    lengths = info["returned_episode_lengths"][ended]
    said = f"{env.name}: {int(ended.sum()) // len(env.agents)} episodes of {int(lengths[0])} steps"
    print(said)
    Path(f"ippo_ff_{config['ENV_NAME']}.txt").write_text(said)


main()
