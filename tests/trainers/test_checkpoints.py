"""Checkpoints give back what was put in: keys, integers, brains of several layers, bit for bit."""

import logging
import sys
from pathlib import Path
from types import SimpleNamespace

import flax
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.trainers.runs.checkpoints import (
    KEPT,
    CheckpointError,
    Checkpoints,
    _without_further_errors,
)


@flax.struct.dataclass
class State:
    """One leaf of each sort."""

    key: jax.Array
    keys: jax.Array
    bytes_: jax.Array
    numbers: dict[str, jax.Array]
    flag: jax.Array
    nothing: tuple[()] = ()


def _state(seed: int, width: int = 3) -> State:
    key = jax.random.key(seed)
    odd = jnp.array([0.1, jnp.inf, -0.0, 1e-45] + [0.0] * (width - 3))
    return State(
        jax.random.fold_in(key, 1),
        jax.random.split(key, 4),
        jnp.arange(5, dtype=jnp.uint8),
        {"odd": odd, "one": jnp.int32(7)},
        jnp.bool_(1),
    )


def _bits(tree: State) -> list[tuple[str, bytes]]:
    plain = jax.tree.map(
        lambda leaf: (
            jax.random.key_data(leaf) if jnp.issubdtype(leaf.dtype, jax.dtypes.prng_key) else leaf
        ),
        tree,
    )
    return [(str(leaf.dtype), np.asarray(leaf).tobytes()) for leaf in jax.tree.leaves(plain)]


def test_what_is_restored_is_what_was_saved(tmp_path: Path) -> None:
    checkpoints = Checkpoints(tmp_path)
    for update in (2, 4, 6):
        checkpoints.save(update, _state(update))
    assert checkpoints.updates() == [6, 4], f"the last {KEPT}"
    checkpoints.close()
    again = Checkpoints(tmp_path)
    for update in (6, 4):
        state = again.restore(update, _state(0))
        assert _bits(state) == _bits(_state(update))
        assert jax.random.key_impl(state.key) == jax.random.key_impl(_state(0).key)
    again.close()


def test_another_shape_is_refused(tmp_path: Path) -> None:
    checkpoints = Checkpoints(tmp_path)
    checkpoints.save(1, _state(1))
    with pytest.raises(CheckpointError, match="checkpoints/1"):
        checkpoints.restore(1, _state(1, width=4))
    checkpoints.close()


def test_another_digest_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever the files say of themselves: the arrays are those that were written, or they are not used."""
    from sjdsl.trainers.runs import checkpoints as module

    checkpoints = Checkpoints(tmp_path)
    checkpoints.save(1, _state(1))
    made = module.digest_of
    monkeypatch.setattr(module, "digest_of", lambda arrays: made({**arrays, ".flag": jnp.bool_(0)}))
    with pytest.raises(CheckpointError, match="is damaged"):
        checkpoints.restore(1, _state(1))
    checkpoints.close()


def test_an_unfinished_one_is_none(tmp_path: Path) -> None:
    """As a process leaves it that is killed while it saves."""
    checkpoints = Checkpoints(tmp_path)
    checkpoints.save(1, _state(1))
    checkpoints.close()
    (tmp_path / "checkpoints" / "2.orbax-checkpoint-tmp" / "state.orbax-checkpoint-tmp").mkdir(
        parents=True
    )
    again = Checkpoints(tmp_path)
    assert again.updates() == [1]
    again.save(2, _state(2))
    assert _bits(again.restore(2, _state(0))) == _bits(_state(2))
    again.close()
    assert sorted(path.name for path in (tmp_path / "checkpoints").iterdir()) == ["1", "2"]


def test_damage_in_any_file_is_found_before_an_array_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Reading it would leave an event loop of orbax that is closed while threads still use it."""
    checkpoints = Checkpoints(tmp_path)
    checkpoints.save(1, _state(1))
    folder = tmp_path / "checkpoints" / "1"
    monkeypatch.setattr(checkpoints, "_read", lambda *_, **__: pytest.fail("orbax was asked"))
    files = [path for path in folder.rglob("*") if path.is_file() and path.stat().st_size]
    assert len(files) > 5
    for path in files:
        content = path.read_bytes()
        path.write_bytes(bytes([content[0] ^ 0xFF]) + content[1:])
        with pytest.raises(CheckpointError, match=f"is damaged: .*{path.name}"):
            checkpoints.restore(1, _state(1))
        path.write_bytes(content)
    monkeypatch.undo()
    assert _bits(checkpoints.restore(1, _state(0))) == _bits(_state(1))
    checkpoints.close()


def test_a_checkpoint_without_its_seal_is_read(tmp_path: Path) -> None:
    """As an older version wrote it, or a process that was killed just before."""
    checkpoints = Checkpoints(tmp_path)
    checkpoints.save(1, _state(1))
    (tmp_path / "checkpoints" / "1" / "files.json").unlink()
    assert _bits(checkpoints.restore(1, _state(0))) == _bits(_state(1))
    checkpoints.close()


def test_writes_that_fail_after_the_first_print_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    printed: list[str] = []
    monkeypatch.setattr(sys, "unraisablehook", lambda fault: printed.append(str(fault.exc_value)))
    level = logging.getLogger("absl").level
    with pytest.raises(OSError, match="full"), _without_further_errors():
        raise OSError("full")
    for message in ("Event loop is closed", "something else"):
        sys.unraisablehook(SimpleNamespace(exc_value=RuntimeError(message)))  # type: ignore[arg-type]
    assert printed == ["something else"]
    assert logging.getLogger("absl").level == level
