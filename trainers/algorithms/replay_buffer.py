"""A replay buffer: the latest transitions, stored as bytes and sampled uniformly."""

from typing import Any

import flax
import jax
import jax.numpy as jnp
from jax import Array


@flax.struct.dataclass
class ReplayBuffer:
    """A ring buffer of `capacity` transitions."""

    entries: Any  # leaves [capacity, ...]
    filled: Array  # [] int32, entries ever written, at most capacity
    cursor: Array  # [] int32, where the next are written


def empty_replay(entry: Any, capacity: int) -> ReplayBuffer:
    """Returns an empty buffer; `entry` is a tree with the shapes and dtypes of an entry."""
    entries = jax.tree.map(lambda leaf: jnp.zeros((capacity, *leaf.shape), leaf.dtype), entry)
    return ReplayBuffer(entries, jnp.int32(0), jnp.int32(0))


def add_entries(replay: ReplayBuffer, new: Any) -> ReplayBuffer:
    """Returns the buffer with entries `[M, ...]` in place of its oldest; M divides its capacity."""
    number = jax.tree.leaves(new)[0].shape[0]
    capacity = jax.tree.leaves(replay.entries)[0].shape[0]

    def write(stored: Array, leaf: Array) -> Array:
        return jax.lax.dynamic_update_slice_in_dim(stored, leaf, replay.cursor, axis=0)

    entries = jax.tree.map(write, replay.entries, new)
    filled = jnp.minimum(replay.filled + number, capacity)
    return ReplayBuffer(entries, filled, (replay.cursor + number) % capacity)


def draw_entries(replay: ReplayBuffer, key: Array, number: int) -> Any:
    """Returns `number` entries `[number, ...]`, each drawn from all that are filled."""
    indices = jax.random.randint(key, (number,), 0, jnp.maximum(replay.filled, 1), jnp.int32)
    return jax.tree.map(lambda leaf: leaf[indices], replay.entries)
