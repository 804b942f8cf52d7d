"""Stored policies: parameters as safetensors, and beside them, as JSON, what they are parameters of."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jax
import numpy as np
from jax.tree_util import keystr, tree_flatten_with_path
from safetensors import SafetensorError
from safetensors.numpy import load, save

from .config import Config, ConfigError, make_config
from .run_files import write_json, write_whole

POLICIES = "policies"
SUFFIX = ".safetensors"


class PolicyError(Exception):
    """A stored policy cannot be read, or does not fit the environment."""


@dataclass(frozen=True)
class Described:
    """What a stored policy is one of."""

    game: Mapping[str, Any]  # name, hash, action_names, observation_shape
    config: Config
    update: int
    env_steps: int


def write_policy(path: Path, parameters: Any, described: Mapping[str, Any]) -> None:
    """Writes `path` (.safetensors) and the `.json` beside it; each is there whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    leaves, _ = tree_flatten_with_path(jax.device_get(parameters))
    tensors = {keystr(place): np.ascontiguousarray(leaf) for place, leaf in leaves}
    write_json(path.with_suffix(".json"), described)
    write_whole(path, save(tensors))


def policy_path(source: Path, which: str | int) -> Path:
    """Returns the file of a policy: `source` itself, or that of the run in the folder `source`.

    Args:
      source: a `.safetensors` file or the folder of a run.
      which: `last`, `best`, or the number of an update.
    Raises:
      PolicyError: there is no such file.
    """
    if source.suffix == SUFFIX:
        if not source.is_file():
            raise PolicyError(f"{source} does not exist")
        return source
    if not (source / "manifest.json").is_file() and not (source / POLICIES).is_dir():  # the folder of one seed has no manifest
        raise PolicyError(f"{source} is no run folder: it has no manifest.json")
    stored = sorted(path.stem for path in (source / POLICIES).glob(f"*{SUFFIX}"))
    name = f"{which:08d}" if isinstance(which, int) else which
    if name in stored:
        return source / POLICIES / f"{name}{SUFFIX}"
    seeds = sorted(path.name for path in source.glob("seed_*") if path.is_dir())
    if seeds:
        raise PolicyError(f"{source} holds a run of several seeds; name one: {', '.join(str(source / name) for name in seeds)}")
    updates = ", ".join(str(int(stem)) for stem in stored if stem.isdigit())
    if not stored:
        raise PolicyError(f"{source} holds no policy yet")
    wanted = f"of update {which}" if isinstance(which, int) else f"called {which}"
    raise PolicyError(f"{source} has no policy {wanted}, but of {updates or ', '.join(stored)}")


def read_policy(path: Path, shapes_of: Callable[[Config], Any]) -> tuple[Any, Described]:
    """Returns the parameters and what they are of; None for parameters that have not the shapes wanted.

    Args:
      path: the `.safetensors` file.
      shapes_of: the tree of shapes that a configuration's parameters have.
    Raises:
      PolicyError: a file is missing, damaged, or of no configuration this version knows.
    """
    try:
        content = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
        described = Described(content["game"], make_config(content["config"]), content["update"], content["env_steps"])
        tensors = load(path.read_bytes())
    except (OSError, ValueError, KeyError, SafetensorError, ConfigError) as error:
        raise PolicyError(f"{path} cannot be read: {error}") from None
    leaves, structure = tree_flatten_with_path(shapes_of(described.config))
    wanted = {keystr(place): leaf.shape for place, leaf in leaves}
    if {name: tensor.shape for name, tensor in tensors.items()} != wanted:
        return None, described
    return jax.tree.unflatten(structure, [tensors[name] for name in wanted]), described
