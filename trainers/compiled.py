"""Compiles the functions of a run for its seeds and devices, and predicts whether they fit into memory."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import psutil
from jax import Array

from .config import Config
from .sharding import Placement, make_placement
from .training_functions import Metrics, Train, TrainState

MEGABYTE = 1_000_000


class NoMemoryError(Exception):
    """A run needs more memory than its device has."""


@dataclass(frozen=True)
class Compiled:
    """The functions of a run; they reuse the memory of what they are given."""

    start: Callable[[], TrainState]
    collect: Callable[[TrainState], tuple[TrainState, Any]]
    learn: Callable[[TrainState, Any], tuple[TrainState, Metrics]]
    parameters: Callable[[TrainState], Any]
    state: TrainState  # shapes, dtypes and placement, without arrays
    seconds: float  # that compiling took
    megabytes: float  # that XLA says the larger of both functions needs


def compile_train(program: Train, config: Config) -> Compiled:
    """Compiles a run.

    Raises:
      ConfigError: the environments do not divide into the devices.
      NoMemoryError: the run would not fit the device.
    """
    began = time.perf_counter()
    placement = make_placement(config)
    over_seeds: Callable[..., Callable[..., Any]] = jax.vmap if config.seeds > 1 else (lambda function: function)

    def first(seeds: Array) -> TrainState:
        return over_seeds(lambda seed: program.init(jax.random.key(seed)))(seeds if config.seeds > 1 else seeds[0])

    seeds = jnp.asarray(config.seed_numbers, jnp.uint32)
    shapes = jax.eval_shape(first, seeds)
    places = placement.of_state(shapes)
    state = jax.tree.map(lambda leaf, place: jax.ShapeDtypeStruct(leaf.shape, leaf.dtype, sharding=place), shapes, places)
    init = jax.jit(first, out_shardings=places)
    collect = jax.jit(over_seeds(program.collect), donate_argnums=0, out_shardings=(places, None)).lower(state).compile()
    played = _played_shapes(over_seeds(program.collect), state, collect)
    learn_over = jax.jit(over_seeds(program.learn), donate_argnums=0, out_shardings=(places, placement.everywhere))
    learn = learn_over.lower(state, played).compile()
    need = max(_bytes(collect), _bytes(learn))
    _check_memory(need, placement)
    return Compiled(
        lambda: init(seeds), collect, learn, over_seeds(program.parameters), state, time.perf_counter() - began, need / MEGABYTE
    )


def _played_shapes(collect: Callable[..., Any], state: TrainState, compiled: Any) -> Any:
    """Returns the shapes of what `collect` hands to `learn`, placed as the compiled function leaves them."""
    shapes = jax.eval_shape(collect, state)[1]
    return jax.tree.map(
        lambda leaf, place: jax.ShapeDtypeStruct(leaf.shape, leaf.dtype, sharding=place), shapes, compiled.output_shardings[1]
    )


def _bytes(compiled: Any) -> int:
    """Returns the memory that XLA says a program needs on a device: arguments, results, and what lies between."""
    said = compiled.memory_analysis()
    if said is None:
        return 0
    return said.argument_size_in_bytes + said.output_size_in_bytes + said.temp_size_in_bytes - said.alias_size_in_bytes


def _check_memory(need: int, placement: Placement) -> None:
    free = free_memory()
    if need > free:
        raise NoMemoryError(
            f"an update needs {need / MEGABYTE:,.0f} MB of memory on each of {placement.mesh.size} device(s), and {free / MEGABYTE:,.0f} MB "
            "are free; make num_envs, num_steps, seeds or buffer_size smaller"
        )


def free_memory() -> int:
    """Returns the bytes that are free for this process: on its first device, or in the machine if that is a CPU."""
    device = jax.local_devices()[0]
    if device.platform == "cpu":
        return int(psutil.virtual_memory().available)
    said = device.memory_stats() or {}
    return int(said["bytes_limit"] - said.get("bytes_in_use", 0)) if "bytes_limit" in said else 2**62


def peak_megabytes() -> float:
    """Returns the most memory held so far: by the first device, or by this process if that is a CPU."""
    device = jax.local_devices()[0]
    if device.platform != "cpu":
        return (device.memory_stats() or {}).get("peak_bytes_in_use", 0) / MEGABYTE
    import resource
    import sys

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / MEGABYTE if sys.platform == "darwin" else peak * 1024 / MEGABYTE
