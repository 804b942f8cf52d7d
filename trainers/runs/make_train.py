"""Makes the training run of a configuration: its algorithm, partners and first parameters."""

from dataclasses import replace
from functools import partial

import jax
import jax.numpy as jnp

from ..algorithms.own_algorithm import make_own
from ..algorithms.ppo import make_ppo
from ..algorithms.training_functions import Train
from ..algorithms.vdn import make_vdn
from ..environment import Environment
from ..policies.loading import load_parameters, make_partners, trained_policy
from ..settings.config import Config, ConfigError, PPOConfig, VDNConfig


def make_train(env: Environment, config: Config) -> Train:
    """Returns the pure functions of a run; nothing is computed yet.

    Args:
      env: one environment.
      config: `seed` and `seeds` aren't read here: `init` takes the key.
    Raises:
      ConfigError: the rollout doesn't divide into minibatches, or something else doesn't fit the
        environment.
      PolicyError: the policy to start from, or a partner's, can't be read or doesn't fit.
    """
    match config:
        case PPOConfig() if "algorithm" in config.hooks:
            program = make_own(env, config)
        case PPOConfig():
            program = make_ppo(env, config, make_partners(env, config))
        case VDNConfig():
            program = make_vdn(env, config, make_partners(env, config))
    if program.policy is None:
        program = replace(program, policy=partial(trained_policy, env, config))
    if not config.init_from:
        return program
    parameters = jax.tree.map(jnp.asarray, load_parameters(config.init_from, env, config))
    adopt = program.adopt
    if adopt is None:
        raise ConfigError("this algorithm can't start from a policy: its `Train` has no `adopt`")
    return replace(program, init=lambda key: adopt(program.init(key), parameters))
