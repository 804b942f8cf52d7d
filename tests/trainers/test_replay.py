"""The replay buffer against a queue, and its draws against equal chances."""

from collections import deque
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import stats

from sjdsl.trainers.algorithms.replay_buffer import (
    ReplayBuffer,
    add_entries,
    draw_entries,
    empty_replay,
)

CAPACITY, ADDED = 12, 4
ENTRY = {
    "name": jax.ShapeDtypeStruct((), jnp.int32),
    "window": jax.ShapeDtypeStruct((2, 3), jnp.uint8),
}
add = jax.jit(add_entries)


def entries(first: int) -> dict[str, Any]:
    """Returns the entries `first`, `first` + 1, ...: each knows its name, and its window is full of it."""
    names = jnp.arange(first, first + ADDED, dtype=jnp.int32)
    return {
        "name": names,
        "window": jnp.broadcast_to(names[:, None, None], (ADDED, 2, 3)).astype(jnp.uint8),
    }


def filled_with(rounds: int) -> ReplayBuffer:
    replay = empty_replay(ENTRY, CAPACITY)
    for number in range(rounds):
        replay = add(replay, entries(1 + number * ADDED))
    return replay


@pytest.mark.parametrize("rounds", range(9))
def test_it_holds_the_last_entries_as_a_queue_does(rounds: int) -> None:
    queue: deque[int] = deque(maxlen=CAPACITY)
    for number in range(1, 1 + rounds * ADDED):
        queue.append(number)
    replay = filled_with(rounds)
    kept = np.asarray(replay.entries["name"])[: int(replay.filled)]
    assert int(replay.filled) == len(queue)
    assert sorted(kept.tolist()) == sorted(queue)
    np.testing.assert_array_equal(
        replay.entries["window"][: len(kept)],
        np.broadcast_to(kept[:, None, None], (len(kept), 2, 3)),
    )
    assert replay.entries["window"].dtype == jnp.uint8


@pytest.mark.parametrize("rounds", [1, 2, 3, 7])
def test_entries_are_drawn_whole_with_equal_chances_from_what_is_filled(rounds: int) -> None:
    """Chi-square of 20,000 draws; a fair buffer is refused by one of the four with a probability of 4 x 1e-4."""
    replay = filled_with(rounds)
    drawn = jax.jit(draw_entries, static_argnums=2)(replay, jax.random.key(rounds), 20_000)
    names, counts = np.unique(drawn["name"], return_counts=True)
    last = rounds * ADDED
    assert names.tolist() == list(range(max(1, last - CAPACITY + 1), last + 1))
    assert stats.chisquare(counts).pvalue > 1e-4
    np.testing.assert_array_equal(
        drawn["window"], np.broadcast_to(np.asarray(drawn["name"])[:, None, None], (20_000, 2, 3))
    )


def test_draws_of_one_batch_are_independent() -> None:
    """Neighbours in a batch are the same entry 1 time in 12: over 20,000 with a standard error of 0.002."""
    names = np.asarray(draw_entries(filled_with(3), jax.random.key(0), 20_000)["name"])
    assert (names[1:] == names[:-1]).mean() == pytest.approx(1 / 12, abs=0.008)
