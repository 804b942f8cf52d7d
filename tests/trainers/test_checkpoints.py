"""Checkpoints give back what was put in: keys, integers, networks of several layers, bit for bit."""

from pathlib import Path

import flax
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.trainers.runs.checkpoints import KEPT, CheckpointError, Checkpoints, last_checkpoint


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
        {"odd": odd, "one": jnp.int32(7), "half": jnp.bfloat16(0.1), "none": jnp.zeros((0, 2))},
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
    assert (checkpoints.updates(), last_checkpoint(tmp_path)) == ([], 0)
    for update in (2, 4, 16):
        checkpoints.save(update, _state(update))
    assert checkpoints.updates() == [16, 4], f"the last {KEPT}"
    assert last_checkpoint(tmp_path) == 16
    for update in (16, 4):
        state = checkpoints.restore(update, _state(0))
        assert _bits(state) == _bits(_state(update))
        assert jax.random.key_impl(state.key) == jax.random.key_impl(_state(0).key)


def test_another_shape_is_refused(tmp_path: Path) -> None:
    checkpoints = Checkpoints(tmp_path)
    checkpoints.save(1, _state(1))
    with pytest.raises(CheckpointError, match=r"checkpoints/1\.safetensors can't be read"):
        checkpoints.restore(1, _state(1, width=4))


def test_no_byte_can_change(tmp_path: Path) -> None:
    checkpoints = Checkpoints(tmp_path)
    checkpoints.save(1, _state(1))
    path = tmp_path / "checkpoints" / "1.safetensors"
    whole = path.read_bytes()
    for place in range(0, len(whole), 3):
        flipped = bytes([whole[place] ^ 1 << place % 8])
        path.write_bytes(whole[:place] + flipped + whole[place + 1 :])
        with pytest.raises(CheckpointError, match=r"checkpoints/1\.safetensors"):
            checkpoints.restore(1, _state(1))
    path.write_bytes(whole[:-1])
    with pytest.raises(CheckpointError, match=r"checkpoints/1\.safetensors"):
        checkpoints.restore(1, _state(1))


def test_an_unreadable_one_is_dropped(tmp_path: Path) -> None:
    checkpoints = Checkpoints(tmp_path)
    for update in (1, 2):
        checkpoints.save(update, _state(update))
    (tmp_path / "checkpoints" / "2.safetensors").write_bytes(b"")
    with pytest.warns(UserWarning, match=r"2\.safetensors .*; resuming from the one before"):
        state, done = checkpoints.restore_last(_state(0))  # type: ignore[arg-type]
    assert (done, _bits(state)) == (1, _bits(_state(1)))  # type: ignore[arg-type]
    assert checkpoints.updates() == [1]
