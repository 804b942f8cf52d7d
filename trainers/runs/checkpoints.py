"""Checkpoints: saves and restores the whole state of a run with orbax, so that a stopped run continues exactly.

A checkpoint is a folder that orbax names only when all of it is written. It also has the digest of the arrays: if they read back
differently, the checkpoint isn't used. Damaged files, and arrays of other shapes, are refused before orbax reads any array: if one array
fails, orbax closes its event loop under those still being read, whose threads then print errors.
"""

import logging
import os
import re
import shutil
import sys
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
from jax.tree_util import keystr, tree_flatten_with_path

from sjdsl.files import naming

from ..algorithms.training_functions import TrainState
from ..devices.processes import is_first
from ..policies.digest import digest_of
from .seal import damage_of, seal

CHECKPOINTS = "checkpoints"
KEPT = 2  # the last one, and the one before it in case the last is damaged


class CheckpointError(Exception):
    """A checkpoint can't be read, or isn't of this run."""


def last_checkpoint(run_dir: Path) -> int:
    """Returns the update after which the last checkpoint of a run was written; 0 if there is none."""
    return max(
        (int(path.name) for path in (run_dir / CHECKPOINTS).glob("*") if path.name.isdecimal()),
        default=0,
    )


def resumption(done: int) -> str:
    """Returns where a run resumes, in words. `done`: the update of its checkpoint; 0 without one."""
    return (
        f"resuming after update {done:,}"
        if done
        else "there is no checkpoint yet: starting again at update 1"
    )


class Checkpoints:
    """The checkpoints of one run, in its folder `checkpoints`."""

    def __init__(self, run_dir: Path) -> None:
        import orbax.checkpoint as ocp  # here: importing it takes a second

        self._ocp = ocp
        self.folder = (run_dir / CHECKPOINTS).resolve()
        options = ocp.CheckpointManagerOptions(
            max_to_keep=KEPT, enable_async_checkpointing=False, cleanup_tmp_directories=True
        )
        self._manager = ocp.CheckpointManager(self.folder, options=options)

    def updates(self) -> list[int]:
        """Returns the updates that have a checkpoint, the last first."""
        self._manager.reload()
        return sorted(self._manager.all_steps(), reverse=True)

    def save(self, update: int, state: Any) -> None:
        """Writes the state after an update. Raises OSError when there is no room."""
        arrays = _named_arrays(state)
        known = {"digest": digest_of(arrays), "arrays": _kinds(arrays)}
        parts = self._ocp.args.Composite(
            state=self._ocp.args.StandardSave(arrays), known=self._ocp.args.JsonSave(known)
        )
        try:
            with naming(self.folder / str(update)), _without_further_errors():
                self._manager.save(update, args=parts, force=True)
                if is_first():
                    seal(self.folder / str(update))
        except (
            ValueError
        ) as error:  # tensorstore has no class for errors of the system, but names their number
            number = re.search(r"os_error_code='(\d+)'", str(error))
            if number is None:
                raise
            raise OSError(
                int(number[1]), os.strerror(int(number[1])), str(self.folder / str(update))
            ) from None

    def restore(self, update: int, like: Any) -> Any:
        """Returns the state after an update, with the structure, dtypes and placement of `like`.

        Raises:
          CheckpointError: it is damaged, or of another run.
        """
        ocp, folder = self._ocp, self.folder / str(update)
        if (file := damage_of(folder)) is not None:
            raise CheckpointError(f"{folder} is damaged: {file} has changed since it was written")
        named = _named_arrays(like)
        wanted = {name: ocp.utils.to_shape_dtype_struct(leaf) for name, leaf in named.items()}
        known = self._read(update, known=ocp.args.JsonRestore())["known"]
        if known.get("arrays", _kinds(named)) != _kinds(named):
            raise CheckpointError(
                f"{folder} can't be read: its arrays have other names, shapes or dtypes than this run's"
            )
        arrays = self._read(update, state=ocp.args.StandardRestore(wanted))["state"]
        if digest_of(arrays) != known.get("digest"):
            raise CheckpointError(f"{folder} is damaged: its arrays aren't those that were written")
        leaves, structure = tree_flatten_with_path(like)
        restored = [(leaf, arrays[keystr(place)]) for place, leaf in leaves]
        keys = [
            jax.random.wrap_key_data(array, impl=jax.random.key_impl(leaf))
            if _is_key(leaf)
            else array
            for leaf, array in restored
        ]
        return jax.tree.unflatten(structure, keys)

    def restore_last(self, start: TrainState) -> tuple[TrainState, int]:
        """Returns the state after the last checkpoint that can be read, and its update; `start` and 0 without one.

        An unreadable checkpoint is dropped with a warning; the run reaches the same figures again from the one before.
        """
        for update in self.updates():
            try:
                return self.restore(update, start), update
            except CheckpointError as error:
                warnings.warn(f"{error}; resuming from the one before", stacklevel=2)
                self.drop(update)
        return start, 0

    def _read(self, update: int, **parts: Any) -> Any:
        """Returns parts of a checkpoint. Raises CheckpointError."""
        try:
            return self._manager.restore(update, args=self._ocp.args.Composite(**parts))
        except Exception as error:  # orbax and tensorstore have no common class of errors
            message = (str(error).strip().splitlines() or [type(error).__name__])[0][:300]
            raise CheckpointError(
                f"{self.folder / str(update)} cannot be read: {message}"
            ) from None

    def drop(self, update: int) -> None:
        """Removes a checkpoint that can't be read, so that the run can write it again."""
        self.close()
        shutil.rmtree(self.folder / str(update), ignore_errors=True)
        self._manager = self._ocp.CheckpointManager(self.folder, options=self._manager._options)

    def close(self) -> None:
        self._manager.close()


@contextmanager
def _without_further_errors() -> Iterator[None]:
    """Has the threads that write print nothing, because the block raises the first error.

    Writes that end later report to an event loop that orbax has closed; so if the block fails, their errors stay hidden.
    """
    before = sys.unraisablehook
    log = logging.getLogger("absl")
    level = log.level

    def print_others(fault: Any) -> None:
        if str(fault.exc_value) != "Event loop is closed":
            before(fault)

    sys.unraisablehook = print_others
    log.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        log.setLevel(level)
    sys.unraisablehook = before


def _named_arrays(state: Any) -> dict[str, Any]:
    """Returns the leaves of a state by their paths; random keys as their words."""
    leaves, _ = tree_flatten_with_path(state)
    return {
        keystr(place): jax.random.key_data(leaf) if _is_key(leaf) else leaf
        for place, leaf in leaves
    }


def _is_key(leaf: Any) -> bool:
    return jnp.issubdtype(leaf.dtype, jax.dtypes.prng_key)


def _kinds(arrays: Mapping[str, Any]) -> dict[str, str]:
    """Returns dtype and shape of each array, as text: `float32[4,2]`."""
    return {
        name: f"{array.dtype}[{','.join(map(str, array.shape))}]" for name, array in arrays.items()
    }
