"""Tasks of a split: which key an episode's task is drawn from, and the parts that its side fixes."""

from collections.abc import Callable, Sequence
from functools import lru_cache

import jax
import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.random_bits import below, random_bits


def numbered_key(key: Array, stream: int, num_tasks: int, seed: int) -> Array:
    """Returns the key of one of the tasks 0 .. `num_tasks` - 1 of a seed: `[2]` uint32."""
    task = below(random_bits(key, stream), num_tasks)
    return key_of(seed, task)


def key_of(seed: int, task: Array) -> Array:
    """Returns the key of a task by its number: `[2]` uint32."""
    return jnp.stack([jnp.uint32(seed), task.astype(jnp.uint32)])


def candidate_key(
    key: Array,
    stream: int,
    num_candidates: int,
    task_from: Callable[[Array], Array],
    num_training: int,
    seed: int,
) -> Array:
    """Returns a key from which a task is drawn that isn't one of those to train on.

    Candidates are drawn, and the first one with such a task is taken; the first of all if none has.

    Args:
      key: `[2]` uint32, of which the candidates' keys are drawn.
      task_from: returns the task that is drawn from a key, as its numbers: `[P]` int32.
      num_training, seed: the tasks to train on are drawn from (seed, 0 .. num_training - 1).
    """
    training_tasks = _training_tasks(task_from, num_training, seed)
    candidates = random_bits(key, stream, num_candidates, 2)
    tasks = jax.vmap(task_from)(candidates)
    is_same = jnp.all(tasks[:, None] == training_tasks[None], axis=2)
    is_held_out = ~jnp.any(is_same, axis=1)
    return candidates[jnp.argmax(is_held_out)]


@lru_cache(maxsize=8)
def _training_tasks(task_from: Callable[[Array], Array], num_training: int, seed: int) -> Array:
    """Returns the tasks to train on: `[num_training, P]` int32, known while tracing."""
    with jax.ensure_compile_time_eval():
        tasks_from = jax.jit(jax.vmap(lambda task: task_from(key_of(seed, task))))
        training: Array = tasks_from(jnp.arange(num_training, dtype=jnp.uint32))
    return training


def drawn_row(key: Array, stream: int, rows: Array) -> Array:
    """Returns one row of a table `[R, P]`, all equally likely: `[P]`."""
    row: Array = rows[below(random_bits(key, stream), rows.shape[0])]
    return row


def with_entries(
    row: Array, values: Array, places: Sequence[int], different: bool = False
) -> Array:
    """Returns a row in which the entries at some places have given values.

    Args:
      row: `[E]`. values: one for each of the places, of any integer type.
      different: all entries of the row differ, and go on doing so: where a given value was, the
        value comes that was at its place.
    """
    entries = jnp.arange(row.shape[0])
    for number, place in enumerate(places):
        value = values[number].astype(row.dtype)
        if different:
            row = jnp.where(row == value, row[place], row)
        row = jnp.where(entries == place, value, row)
    return row
