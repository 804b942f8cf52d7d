"""Policies: functions `(key, observation [N, P, V, V]) -> actions [N] int32` of one environment."""

import json
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

from .config import Config
from .environment import Environment, abstract_key, reset_shapes
from .ppo import make_network
from .run_folder import CHECKPOINTS, MANIFEST, read_parameters

Policy = Callable[[Array, Array], Array]


class PolicyError(Exception):
    """A stored policy cannot be read, or does not fit the environment."""


def random_policy(env: Environment) -> Policy:
    """Returns the policy that draws every action with equal probability."""

    def act(key: Array, observation: Array) -> Array:
        del observation
        return jax.random.randint(key, (env.num_agents,), 0, env.num_actions, jnp.int32)

    return act


def trained_policy(env: Environment, config: Config, parameters: Any, greedy: bool = False) -> Policy:
    """Returns the policy of `parameters`: it samples each agent's action, or takes the likeliest one if `greedy`."""
    network = make_network(env, config)

    def act(key: Array, observation: Array) -> Array:
        logits, _ = network.apply(parameters, observation)
        action = jnp.argmax(logits, axis=-1) if greedy else jax.random.categorical(key, logits)
        return action.astype(jnp.int32)

    return act


def load_policy(run_dir: Path | str, env: Environment, update: int | None = None, greedy: bool = False) -> Policy:
    """Returns the policy that a run stored.

    Args:
      run_dir: folder that `train` wrote.
      env: environment to act in; it must have the actions and observation planes of the one trained on. Another
        variant or other parameters are allowed, with a warning.
      update: which checkpoint; the last one if None.
      greedy: take the likeliest action instead of drawing one.
    Raises:
      PolicyError: no such run or checkpoint, or it does not fit `env`.
    """
    run_dir = Path(run_dir)
    if not (run_dir / MANIFEST).is_file():
        raise PolicyError(f"{run_dir} is no run folder: it has no {MANIFEST}")
    manifest = json.loads((run_dir / MANIFEST).read_text(encoding="utf-8"))
    config = Config(**manifest["config"])
    if manifest["game"]["hash"] != env.hash:
        warnings.warn(
            f"{run_dir} was trained on another form of the game: {manifest['game']['name']} {manifest['game']['hash']},"
            f" not {env.name} {env.hash}",
            stacklevel=2,
        )
    checkpoint = _checkpoint_path(run_dir, update)
    observation, _ = reset_shapes(env)
    expected = jax.eval_shape(make_network(env, config).init, abstract_key(), observation)
    parameters = read_parameters(checkpoint)
    if _shapes(parameters) != _shapes(expected):
        raise PolicyError(
            f"{checkpoint} does not fit {env.name}: it was trained on {manifest['game']['name']} with "
            f"{len(manifest['game']['action_names'])} actions and observations {manifest['game']['observation_shape']}; "
            f"here are {env.num_actions} actions and observations {list(observation.shape)}"
        )
    return trained_policy(env, config, parameters, greedy)


def _shapes(parameters: Any) -> dict[str, tuple[int, ...]]:
    leaves = jax.tree_util.tree_leaves_with_path(parameters)
    return {jax.tree_util.keystr(path): tuple(leaf.shape) for path, leaf in leaves}


def _checkpoint_path(run_dir: Path, update: int | None) -> Path:
    stored = {int(path.stem): path for path in (run_dir / CHECKPOINTS).glob("*.msgpack")}
    if not stored:
        raise PolicyError(f"{run_dir} holds no checkpoint")
    if update is not None and update not in stored:
        raise PolicyError(f"{run_dir} has no checkpoint of update {update}, but of {', '.join(map(str, sorted(stored)))}")
    return stored[max(stored) if update is None else update]
