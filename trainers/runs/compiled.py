"""Compiles the functions of a run for its seeds and devices, and predicts whether they fit into memory."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import jax
import jax.numpy as jnp
import psutil
from jax import Array

from ..algorithms.rollout import Worlds
from ..algorithms.training_functions import Metrics, Train, TrainState
from ..settings.config import Config
from .sharding import make_placement

MEGABYTE = 1_000_000

Over = Callable[
    [Callable[..., Any]], Callable[..., Any]
]  # maps a function of one seed to one of all seeds, with a first axis in everything


class NoMemoryError(Exception):
    """A run needs more memory than its device has."""


@dataclass(frozen=True)
class Compiled:
    """The compiled functions of a run; they reuse the memory of their arguments."""

    start: Callable[[], TrainState]
    collect: Callable[[TrainState], tuple[TrainState, Any]]
    learn: Callable[[TrainState, Any], tuple[TrainState, Metrics]]
    parameters: Callable[[TrainState], Any]
    state: TrainState  # shapes, dtypes and placement, without arrays
    seconds: float  # compile time
    megabytes: float  # memory of the larger of both functions, according to XLA


def compile_train(program: Train, config: Config, parameters: Any = None) -> Compiled:
    """Compiles a run.

    Args:
      parameters: that it starts with, with a first axis for several seeds; None: those of `program.init`.
    Raises:
      ConfigError: the environments don't divide evenly over the devices.
      NoMemoryError: the run doesn't fit into the device's memory.
    """
    began = time.perf_counter()
    placement = make_placement(config)
    at_once: Over = jax.vmap if config.seeds > 1 else (lambda function: function)
    loops = program.loops and config.seeds > 1 and jax.default_backend() == "cpu"
    over_seeds: Over = one_after_the_other if loops else at_once

    def first(seeds: Array, parameters: Any) -> TrainState:
        def start_seed(seed: Array, own: Any) -> TrainState:
            state = program.init(jax.random.key(seed))
            if own is None:
                return state
            assert program.adopt is not None
            return program.adopt(state, own)

        result: TrainState = at_once(start_seed)(
            seeds if config.seeds > 1 else seeds[0], parameters
        )
        return result

    seeds = jnp.asarray(config.seed_numbers, jnp.uint32)
    shapes = jax.eval_shape(first, seeds, parameters)
    places = placement.of_state(shapes)
    state = jax.tree.map(
        lambda leaf, place: jax.ShapeDtypeStruct(leaf.shape, leaf.dtype, sharding=place),
        shapes,
        places,
    )
    # Return leaves, not a tree: tracing again creates a new optimiser, which JAX would take for a different tree structure.
    init = jax.jit(
        lambda seeds, parameters: jax.tree.leaves(first(seeds, parameters)),
        out_shardings=jax.tree.leaves(places),
    )
    collect_over = over_seeds(program.collect)
    collect = (
        jax.jit(collect_over, donate_argnums=0, out_shardings=(places, None)).lower(state).compile()
    )
    played_shapes, played_places = (
        jax.eval_shape(collect_over, state)[1],
        collect.output_shardings[1],
    )
    played = jax.tree.map(
        lambda leaf, place: jax.ShapeDtypeStruct(leaf.shape, leaf.dtype, sharding=place),
        played_shapes,
        played_places,
    )
    learn_over = over_seeds(program.learn)
    learn = (
        jax.jit(learn_over, donate_argnums=0, out_shardings=(places, placement.everywhere))
        .lower(state, played)
        .compile()
    )
    need, free = max(_bytes(collect), _bytes(learn)), free_memory()
    if need > free:
        raise NoMemoryError(
            f"an update needs {need / MEGABYTE:,.0f} MB of memory on each of {placement.mesh.size} device(s), but only "
            f"{free / MEGABYTE:,.0f} MB are free; make num_envs, num_steps, seeds or buffer_size smaller"
        )
    return Compiled(
        lambda: jax.tree.unflatten(jax.tree.structure(shapes), init(seeds, parameters)),
        collect,
        learn,
        at_once(program.parameters),
        state,
        time.perf_counter() - began,
        need / MEGABYTE,
    )


def with_spread_starts(compiled: Compiled, config: Config, episode_length: int) -> Compiled:
    """Returns a run whose environments start at different steps of an episode, a rollout apart, if `config.spread_starts`.

    Environments that all start together stay in lockstep: each update would see only one part of an episode. Here, environment b of B first
    plays `b * K // B` rollouts with the initial policy, where K is the number of rollouts in an episode; none if a rollout is a whole
    episode. These steps are neither learnt from nor counted.

    Args:
      compiled: the run.
      config: its `num_steps`, `seeds` and `spread_starts`.
      episode_length: steps of an episode.
    """
    rollouts = -(-episode_length // config.num_steps)
    if rollouts <= 1 or not config.spread_starts:
        return compiled
    axis = int(config.seeds > 1)  # of environments

    @jax.jit
    def keep(number: int, worlds: Worlds, kept: Worlds) -> Worlds:
        """Returns the new worlds of the environments that play `number` rollouts or more, and the kept worlds of the others."""

        def of_leaf(new: Array, old: Array) -> Array:
            plays = jnp.arange(new.shape[axis]) * rollouts // new.shape[axis] >= number
            return jnp.where(plays.reshape(-1, *[1] * (new.ndim - 1 - axis)), new, old)

        result: Worlds = jax.tree.map(of_leaf, worlds, kept)
        return result

    def start() -> TrainState:
        state = compiled.start()
        places = jax.tree.map(lambda leaf: leaf.sharding, state.worlds)
        kept = jax.tree.map(jnp.copy, state.worlds)  # a copy, as the next rollout reuses the memory
        for number in range(1, rollouts):
            state, _ = compiled.collect(state)
            kept = keep(number, state.worlds, kept)
        return replace(state, worlds=jax.device_put(kept, places))

    return replace(compiled, start=start)


def one_after_the_other(function: Callable[..., Any]) -> Callable[..., Any]:
    """Returns the same as `jax.vmap`, computed in a loop.

    It is faster on a CPU: the windows of one seed may fit into a cache, and a `cond` computes only the branch that applies.
    """
    return lambda *arguments: jax.lax.map(lambda own: function(*own), arguments)


def _bytes(compiled: Any) -> int:
    """Returns the memory that a program needs on a device according to XLA: arguments, results and temporaries."""
    found = compiled.memory_analysis()
    if found is None:
        return 0
    result: int = (
        found.argument_size_in_bytes
        + found.output_size_in_bytes
        + found.temp_size_in_bytes
        - found.alias_size_in_bytes
    )
    return result


def free_memory() -> int:
    """Returns the bytes free for this process: on its first device, or in the machine if that is a CPU."""
    device = jax.local_devices()[0]
    if device.platform == "cpu":
        return int(psutil.virtual_memory().available)
    stats = device.memory_stats() or {}
    return (
        int(stats["bytes_limit"] - stats.get("bytes_in_use", 0))
        if "bytes_limit" in stats
        else 2**62
    )


def peak_megabytes() -> float:
    """Returns the peak memory use so far: of the first device, or of this process if that is a CPU."""
    device = jax.local_devices()[0]
    if device.platform != "cpu":
        result: float = (device.memory_stats() or {}).get("peak_bytes_in_use", 0) / MEGABYTE
        return result
    import resource
    import sys

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / MEGABYTE if sys.platform == "darwin" else peak * 1024 / MEGABYTE
