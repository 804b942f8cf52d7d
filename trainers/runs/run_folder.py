"""The folder of a run: its manifest, and a folder for each seed."""

import importlib.metadata
import platform
from collections.abc import Mapping
from datetime import UTC, datetime
from hashlib import sha256
from typing import Any

import jax
from jax.tree_util import keystr, tree_leaves_with_path

from ..devices.device import device_name
from ..environment import Environment, reset_shapes
from ..json_files import plain
from ..settings.config import Config
from ..settings.extensions import file_of

PACKAGES = ("sjdsl", "jax", "jaxlib", "flax", "optax", "numpy")


def describe_run(env: Environment, config: Config, provenance: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the manifest of a run that starts now. provenance: how `env` was made."""
    device = jax.devices()[0]
    return {
        "status": "running",
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
        "seed": config.seed,
        "game": describe_game(env),
        "provenance": dict(provenance),
        "config": config.record(),
        "own_files": own_files(config),
        "derived": {"updates": config.num_updates, "steps_per_update": config.steps_per_update},
        "versions": versions(),
        "device": {
            "platform": device.platform,
            "kind": device_name(device),
            "count": jax.device_count(),
        },
    }


def own_files(config: Config) -> dict[str, str | None]:
    """Returns the user's own files that a run uses, with their SHA-256, or None if one is gone."""
    names = (*config.hooks.values(), *(policy for _, policy in config.partners))
    files = [file for file in map(file_of, names) if file is not None]
    return {
        str(file): sha256(file.read_bytes()).hexdigest() if file.is_file() else None
        for file in files
    }


def describe_game(env: Environment) -> dict[str, Any]:
    """Returns what the files of a run and of a policy say of their game."""
    observation, _ = reset_shapes(env)
    params = tree_leaves_with_path(env.params)
    tasks = getattr(env, "tasks", None)
    played = {} if tasks is None else {"tasks": tasks, "split": getattr(env, "split", "")}
    return {
        "name": env.name,
        "hash": env.hash,
        **played,
        "params": {keystr(path, simple=True): plain(leaf) for path, leaf in params},
        "num_agents": env.num_agents,
        "action_names": list(env.action_names),
        "observation_shape": list(observation.shape),
    }


def versions() -> dict[str, str]:
    """Returns the versions of Python and of the packages that a run's figures depend on."""
    return {"python": platform.python_version()} | {
        package: importlib.metadata.version(package) for package in PACKAGES
    }
