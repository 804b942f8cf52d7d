"""The record of one environment step from which a user's own reward is computed."""

from typing import Any

import flax
import jax
import jax.numpy as jnp
from jax import Array

from ..environment import Environment, array_shape, info_shapes, reset_shapes
from ..settings.config import Config, ConfigError
from ..settings.own_settings import filled


@flax.struct.dataclass
class Step:
    """One step of one environment."""

    reward: Array  # [N] float32, the game's
    # [N] float32, rewards of the episode so far, decayed by `reward_smoothing` a step; with 0, this
    # step's only
    trace: Array
    action: Array  # [N] int32
    observation: Array  # [N, P, V, V] uint8, acted on
    state: Any  # the environment's, before the action
    # after it, before a new episode begins; None if the environment's info has no `terminal_state`
    next_state: Any
    events: dict[str, Array]  # name -> [N] or [] int32, counts of this step
    metrics: dict[str, Array]  # name -> [] float32, at the end of the step
    done: Array  # [] bool, the episode ends with this step
    truncated: Array  # [] bool, by the time limit


def check_own_reward(env: Environment, config: Config) -> None:
    """Raises ConfigError unless the user's reward gives a number for each agent."""
    observation, state = reset_shapes(env)
    info = info_shapes(env)
    per_agent = array_shape((env.num_agents,), jnp.float32)
    flag = array_shape((), jnp.bool_)
    step = Step(
        reward=per_agent,
        trace=per_agent,
        action=array_shape((env.num_agents,), jnp.int32),
        observation=observation,
        state=state,
        next_state=info.get("terminal_state"),
        events=info["events"],
        metrics=info["metrics"],
        done=flag,
        truncated=flag,
    )
    paid = jax.eval_shape(
        lambda step: jnp.asarray(filled("reward", config.reward, config.own)(step)), step
    )
    if paid.shape != (env.num_agents,):
        raise ConfigError(
            f"the reward `{config.reward}` must give a number for each of the {env.num_agents} "
            f"agents, an array of shape ({env.num_agents},), not {paid.shape}"
        )
