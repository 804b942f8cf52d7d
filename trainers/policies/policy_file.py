"""Stored policies: parameters as safetensors, and a JSON file that describes them."""

import hashlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any

import jax
import numpy as np
from jax.tree_util import keystr, tree_flatten_with_path
from pydantic import BaseModel, ConfigDict, PlainValidator
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save

from sjdsl.files import parse_json, read_bytes, write_whole

from ..json_files import json_text
from ..settings.config import Config, ConfigError, require_code, stored_config
from ..settings.extensions import NotAllowed
from ..settings.policy_names import LARGEST_DESCRIPTION, split_name
from .digest import digest_of

POLICIES = "policies"
START = "start.safetensors"  # in the folder of a run that started from a stored policy: its copy
SUFFIX = ".safetensors"
# The key of the file's metadata: two digests, of its tensors, with their names, dtypes and shapes,
# and of the bytes of the `.json` beside it. They share a key, because safetensors writes several
# keys in no fixed order, and equal files must have equal bytes.
DIGEST = "sha256"
UNREADABLE = (
    OSError,
    ValueError,
    KeyError,
    TypeError,
    AttributeError,
    OverflowError,
    SafetensorError,
    ConfigError,
)


class PolicyError(Exception):
    """A stored policy can't be read, or doesn't fit the environment."""


class TrainedGame(BaseModel):
    """The game of a stored policy."""

    model_config = ConfigDict(strict=True)

    name: str
    hash: str
    action_names: list[str]
    observation_shape: list[int]


class Described(BaseModel):
    """The description of a stored policy."""

    model_config = ConfigDict(strict=True)

    game: TrainedGame
    config: Annotated[Config, PlainValidator(stored_config)]
    update: int
    env_steps: int
    seed: int


def write_policy(path: Path, parameters: Any, described: Mapping[str, Any]) -> None:
    """Writes `path` (.safetensors) and the `.json` beside it, each whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    leaves, _ = tree_flatten_with_path(jax.device_get(parameters))
    tensors = {keystr(place): np.asarray(leaf, order="C") for place, leaf in leaves}
    text = json_text(described).encode()
    write_whole(path.with_suffix(".json"), text)
    write_whole(path, save(tensors, {DIGEST: digests_of(tensors, text)}))


def copy_policy(name: str, path: Path) -> None:
    """Copies the policy of a name to `path`, with the `.json` beside it."""
    source = policy_path(*split_name(name))
    for suffix in (".json", SUFFIX):  # the tensors last, as they make it a policy
        write_whole(path.with_suffix(suffix), source.with_suffix(suffix).read_bytes())


def remove_policies(folder: Path, kept: int) -> None:
    """Removes the policies stored by number, except the last `kept`; 0 keeps all."""
    numbered = sorted(path for path in folder.glob(f"*{SUFFIX}") if path.stem.isdecimal())
    if kept == 0:
        return
    for path in numbered[:-kept]:
        for suffix in (SUFFIX, ".json"):  # the tensors first: a description alone isn't a policy
            path.with_suffix(suffix).unlink(missing_ok=True)


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
    policies = source / POLICIES
    # The folder of a single seed has no manifest.
    if not (source / "manifest.json").is_file() and not policies.is_dir():
        raise PolicyError(f"{source} is not the folder of a training run: it has no manifest.json")
    name = f"{which:08d}" if isinstance(which, int) else which
    stored = sorted(path.stem for path in policies.glob(f"*{SUFFIX}"))
    if name in stored:
        return policies / f"{name}{SUFFIX}"
    seeds = sorted(str(path) for path in source.glob("seed_*") if path.is_dir())
    if seeds:
        raise PolicyError(f"{source} holds a run of several seeds; name one: {', '.join(seeds)}")
    if not stored:
        raise PolicyError(f"{source} holds no policy yet")
    updates = [str(int(stem)) for stem in stored if stem.isdecimal()]
    wanted = f"of update {which}" if isinstance(which, int) else f"called {which}"
    raise PolicyError(f"{source} has no policy {wanted}, but of {', '.join(updates or stored)}")


def read_policy(path: Path, shapes_of: Callable[[Config], Any]) -> tuple[Any, Described]:
    """Returns the parameters, or None if they don't have the wanted shapes, and their description.

    Args:
      path: the `.safetensors` file.
      shapes_of: the tree of shapes of a configuration's parameters.
    Raises:
      PolicyError: a file is missing, damaged, or of a configuration that this version doesn't know;
        a number in it isn't finite; or it leads to code that the caller hasn't allowed
        (`allow_code`). A user's own reward isn't needed to act, and isn't imported.
    """
    description = path.with_suffix(".json")
    try:
        with safe_open(path, "np") as file:
            metadata = file.metadata() or {}
            if DIGEST not in metadata:
                raise ValueError("it has no digests, so sjdsl didn't write it")
            tensors_digest, _, json_digest = metadata[DIGEST].partition(" ")
            described = _read_description(description, json_digest)
            require_code(described.config, str(description), to_act=True)
            leaves, structure = tree_flatten_with_path(shapes_of(described.config))
            wanted = {keystr(place): leaf.shape for place, leaf in leaves}
            names = list(file.keys())
            shapes = {name: tuple(file.get_slice(name).get_shape()) for name in names}
            if shapes != wanted:  # before any of the file, which may be large, is read
                return None, described
            tensors = {name: file.get_tensor(name) for name in wanted}
    except NotAllowed as error:
        raise PolicyError(str(error)) from None
    except UNREADABLE as error:
        raise PolicyError(f"{path} cannot be read: {error}") from None
    if metadata.keys() != {DIGEST} or digest_of(tensors) != tensors_digest:
        raise PolicyError(
            f"{path} is damaged: its tensors aren't those that were written; "
            "use another policy of the run"
        )
    bad = [name for name, tensor in tensors.items() if not np.isfinite(tensor).all()]
    if bad:
        raise PolicyError(
            f"{path} holds non-finite numbers, in {', '.join(bad)}: no agent can act by it; "
            "use another policy"
        )
    return jax.tree.unflatten(structure, [*tensors.values()]), described


def update_of(path: Path) -> int:
    """Returns the update after which a policy that can be read was stored.

    Args:
      path: the `.safetensors` file.
    """
    return _read_description(path.with_suffix(".json")).update


def digests_of(tensors: Mapping[str, np.ndarray], description: bytes) -> str:
    """Returns the digests of a policy's tensors and of its description, for the metadata."""
    return f"{digest_of(tensors)} {hashlib.sha256(description).hexdigest()}"


def _read_description(path: Path, digest: str | None = None) -> Described:
    """Returns the description of a policy, which must have the digest if one is given."""
    written = read_bytes(path, LARGEST_DESCRIPTION)
    if digest is not None and hashlib.sha256(written).hexdigest() != digest:
        raise ValueError(
            f"{path} is damaged: it isn't the one that was written; use another policy of the run"
        )
    return Described.model_validate(parse_json(written))
