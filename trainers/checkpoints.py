"""Checkpoints: saves and restores the whole state of a run with orbax, so that a stopped run continues exactly.

A checkpoint is a folder that orbax names only when all of it is written. Beside the arrays it has their digest: what does not
read back as it was written is not gone on from. Damaged files, and arrays of other shapes, are refused before orbax reads any array:
where one array fails, it closes its event loop under those that are still being read, and their threads complain to nobody.
"""

import os
import re
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
from jax.tree_util import keystr, tree_flatten_with_path

from sjdsl.files import naming

from .digest import digest_of
from .processes import is_first
from .seal import damage_of, seal

CHECKPOINTS = "checkpoints"
KEPT = 2  # the last one, and the one before should the last be damaged


class CheckpointError(Exception):
    """A checkpoint cannot be read, or is none of this run."""


class Checkpoints:
    """The checkpoints of one run, in the folder `checkpoints` of its own."""

    def __init__(self, run_dir: Path) -> None:
        import orbax.checkpoint as ocp  # here: importing it takes a second

        self._ocp = ocp
        self.folder = (run_dir / CHECKPOINTS).resolve()
        options = ocp.CheckpointManagerOptions(max_to_keep=KEPT, enable_async_checkpointing=False, cleanup_tmp_directories=True)
        self._manager = ocp.CheckpointManager(self.folder, options=options)

    def updates(self) -> list[int]:
        """Returns after which updates there is a checkpoint, the last first."""
        self._manager.reload()
        return sorted(self._manager.all_steps(), reverse=True)

    def save(self, update: int, state: Any, known: Mapping[str, Any]) -> None:
        """Writes the state after an update, and what else is known, JSON values. Raises OSError when there is no room."""
        arrays = _named_arrays(state)
        known = {**known, "digest": digest_of(arrays), "arrays": _kinds(arrays)}
        parts = self._ocp.args.Composite(state=self._ocp.args.StandardSave(arrays), known=self._ocp.args.JsonSave(known))
        try:
            with naming(self.folder / str(update)):
                self._manager.save(update, args=parts, force=True)
                if is_first():
                    seal(self.folder / str(update))
        except ValueError as error:  # tensorstore has no class for what the system refuses, but says its number
            said = re.search(r"os_error_code='(\d+)'", str(error))
            if said is None:
                raise
            raise OSError(int(said[1]), os.strerror(int(said[1])), str(self.folder / str(update))) from None

    def restore(self, update: int, like: Any) -> tuple[Any, dict[str, Any]]:
        """Returns the state after an update, with the structure, dtypes and placement of `like`, and what else was known.

        Raises:
          CheckpointError: it is damaged, or of another run.
        """
        ocp, folder = self._ocp, self.folder / str(update)
        if (file := damage_of(folder)) is not None:
            raise CheckpointError(f"{folder} is damaged: {file} is not as it was written")
        named = _named_arrays(like)
        wanted = {name: ocp.utils.to_shape_dtype_struct(leaf) for name, leaf in named.items()}
        known = dict(self._read(update, known=ocp.args.JsonRestore())["known"])
        if known.pop("arrays", _kinds(named)) != _kinds(named):
            raise CheckpointError(f"{folder} cannot be read: its arrays have other names, shapes or dtypes than this run's")
        arrays = self._read(update, state=ocp.args.StandardRestore(wanted))["state"]
        if digest_of(arrays) != known.pop("digest", None):
            raise CheckpointError(f"{folder} is damaged: its arrays are not those that were written")
        return _with_arrays(like, arrays), known

    def _read(self, update: int, **parts: Any) -> Any:
        """Returns parts of a checkpoint. Raises CheckpointError."""
        try:
            return self._manager.restore(update, args=self._ocp.args.Composite(**parts))
        except Exception as error:  # orbax and tensorstore have no common class of errors
            raise CheckpointError(f"{self.folder / str(update)} cannot be read: {_first_line(error)}") from None

    def drop(self, update: int) -> None:
        """Removes a checkpoint that cannot be read, so that the run may write it anew."""
        self.close()
        shutil.rmtree(self.folder / str(update), ignore_errors=True)
        self._manager = self._ocp.CheckpointManager(self.folder, options=self._manager._options)

    def close(self) -> None:
        self._manager.close()


def _named_arrays(state: Any) -> dict[str, Any]:
    """Returns the leaves of a state by their paths; keys as the words they are made of."""
    leaves, _ = tree_flatten_with_path(state)
    return {keystr(place): _words(leaf) for place, leaf in leaves}


def _kinds(arrays: Mapping[str, Any]) -> dict[str, str]:
    """Returns dtype and shape of each array, as text: `float32[4,2]`."""
    return {name: f"{array.dtype}[{','.join(map(str, array.shape))}]" for name, array in arrays.items()}


def _words(leaf: Any) -> Any:
    return jax.random.key_data(leaf) if jnp.issubdtype(leaf.dtype, jax.dtypes.prng_key) else leaf


def _with_arrays(like: Any, arrays: Mapping[str, Any]) -> Any:
    leaves, structure = tree_flatten_with_path(like)
    return jax.tree.unflatten(structure, [_as(leaf, arrays[keystr(place)]) for place, leaf in leaves])


def _as(leaf: Any, array: Any) -> Any:
    if jnp.issubdtype(leaf.dtype, jax.dtypes.prng_key):
        return jax.random.wrap_key_data(array, impl=jax.random.key_impl(leaf))
    return array


def _first_line(error: Exception) -> str:
    return str(error).strip().splitlines()[0][:300] if str(error).strip() else type(error).__name__
