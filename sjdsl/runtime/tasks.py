"""Tasks of a split: which key an episode's task is drawn from, and the parts that its side fixes."""

from collections.abc import Callable, Sequence
from functools import lru_cache

import jax
import jax.numpy as jnp
from jax import Array

from sjdsl.runtime.random_bits import below, random_bits


def numbered_key(key: Array, stream: int, number: int, seed: int) -> Array:
    """Returns the key of one of the tasks 0 .. `number` - 1 of a seed: `[2]` uint32."""
    task = below(random_bits(key, stream), number)
    return key_of(seed, task)


def key_of(seed: int, task: Array) -> Array:
    """Returns the key of a task by its number: `[2]` uint32."""
    return jnp.stack([jnp.uint32(seed), task.astype(jnp.uint32)])


def candidate_key(
    key: Array,
    stream: int,
    candidates: int,
    numbers: Callable[[Array], Array],
    number: int,
    seed: int,
) -> Array:
    """Returns the key of the first candidate whose task isn't one of those to train on.

    That of candidate 0 if all are.

    Args:
      key: `[2]` uint32, of which the candidates' keys are drawn.
      candidates: how many there are.
      numbers: returns all numbers of the task that is drawn from a key: `[P]` int32.
      number, seed: the tasks to train on are drawn from the keys (seed, 0 .. number - 1).
    """
    training = _training_tasks(numbers, number, seed)
    keys = random_bits(key, stream, candidates, 2)

    def is_held_out(candidate: Array) -> Array:
        is_equal = jnp.all(training == numbers(candidate)[None], axis=1)
        return ~jnp.any(is_equal)

    first = jnp.argmax(jax.vmap(is_held_out)(keys))
    return keys[first]


@lru_cache(maxsize=8)
def _training_tasks(numbers: Callable[[Array], Array], number: int, seed: int) -> Array:
    """Returns the numbers of all tasks to train on: `[number, P]` int32, known while tracing."""
    with jax.ensure_compile_time_eval():
        of_task = jax.jit(jax.vmap(lambda task: numbers(key_of(seed, task))))
        training: Array = of_task(jnp.arange(number, dtype=jnp.uint32))
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
