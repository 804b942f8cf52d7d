"""Checkpoints: saves and restores the whole state of a run, so that a stopped run continues exactly.

A checkpoint is one safetensors file with the digest of its arrays: if they read back differently, it isn't used. Of several processes the
first writes it, and all read it, from a file system that they share.
"""

import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from jax.tree_util import keystr, tree_flatten_with_path, tree_map_with_path
from safetensors import safe_open
from safetensors.numpy import save

from sjdsl.files import write_whole

from ..algorithms.training_functions import TrainState
from ..devices.processes import gathered, is_first
from ..policies.digest import digest_of
from ..policies.policy_file import SUFFIX, UNREADABLE

CHECKPOINTS = "checkpoints"
DIGEST = "sha256"  # in the metadata of a checkpoint
KEPT = 2  # the last one, and the one before it in case the last is damaged


class CheckpointError(Exception):
    """A checkpoint can't be read, or isn't of this run."""


def last_checkpoint(run_dir: Path) -> int:
    """Returns the update after which the last checkpoint of a run was written; 0 if there is none."""
    return max(Checkpoints(run_dir).updates(), default=0)


def resumption(done: int) -> str:
    """Returns where a run resumes, in words. `done`: the update of its checkpoint; 0 without one."""
    if done:
        return f"resuming after update {done:,}"
    return "there is no checkpoint yet: starting again at update 1"


class Checkpoints:
    """The checkpoints of one run, in its folder `checkpoints`."""

    def __init__(self, run_dir: Path) -> None:
        self.folder = run_dir / CHECKPOINTS

    def updates(self) -> list[int]:
        """Returns the updates that have a checkpoint, the last first."""
        stems = (path.stem for path in self.folder.glob(f"*{SUFFIX}"))
        return sorted((int(stem) for stem in stems if stem.isdecimal()), reverse=True)

    def save(self, update: int, state: Any) -> None:
        """Writes the state after an update, and removes all checkpoints but the last two. All processes have to call it.

        Raises:
          OSError: there is no room.
        """
        arrays = {name: gathered(array) for name, array in _named_arrays(state).items()}
        if not is_first():
            return
        self.folder.mkdir(parents=True, exist_ok=True)
        write_whole(self._path(update), save(arrays, {DIGEST: digest_of(arrays)}))
        for old in self.updates()[KEPT:]:
            self._path(old).unlink()

    def restore(self, update: int, like: Any) -> Any:
        """Returns the state after an update, with the structure, dtypes and placement of `like`.

        Raises:
          CheckpointError: it is damaged, or of another run.
        """
        path = self._path(update)
        try:
            with safe_open(path, "np") as file:
                digest = (file.metadata() or {}).get(DIGEST)
                arrays = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118 (it isn't a mapping)
        except UNREADABLE as error:
            raise CheckpointError(f"{path} can't be read: {error}") from None
        if digest_of(arrays) != digest:
            raise CheckpointError(f"{path} is damaged: its arrays aren't those that were written")
        if _dtypes_and_shapes(arrays) != _dtypes_and_shapes(_named_arrays(like)):
            raise CheckpointError(
                f"{path} can't be read: its arrays have other names, shapes or dtypes than this run's"
            )
        return tree_map_with_path(
            lambda place, leaf: _place_like(arrays[keystr(place)], leaf), like
        )

    def restore_last(self, start: TrainState) -> tuple[TrainState, int]:
        """Returns the state after the last checkpoint that can be read, and its update; `start` and 0 without one.

        An unreadable checkpoint is dropped with a warning; the run reaches the same figures again from the one before.
        """
        for update in self.updates():
            try:
                return self.restore(update, start), update
            except CheckpointError as error:
                warnings.warn(f"{error}; resuming from the one before", stacklevel=2)
                if is_first():
                    self._path(update).unlink(missing_ok=True)
        return start, 0

    def _path(self, update: int) -> Path:
        return self.folder / f"{update}{SUFFIX}"


def _named_arrays(state: Any) -> dict[str, Array]:
    """Returns the leaves of a state by their paths; random keys as their words."""
    leaves, _ = tree_flatten_with_path(state)
    return {
        keystr(place): jax.random.key_data(leaf) if _is_key(leaf) else leaf
        for place, leaf in leaves
    }


def _is_key(leaf: Any) -> bool:
    return jnp.issubdtype(leaf.dtype, jax.dtypes.prng_key)


def _dtypes_and_shapes(arrays: Mapping[str, Any]) -> dict[str, tuple[str, tuple[int, ...]]]:
    """Returns the dtype and the shape of each array."""
    return {name: (str(array.dtype), array.shape) for name, array in arrays.items()}


def _place_like(array: np.ndarray, like: Array) -> Array:
    """Returns an array on the devices, and in the parts, of `like`; random keys from their words."""
    if _is_key(like):
        words = _place_like(array, jax.random.key_data(like))
        key: Array = jax.random.wrap_key_data(words, impl=jax.random.key_impl(like))
        return key
    return jax.make_array_from_callback(array.shape, like.sharding, lambda index: array[index])
