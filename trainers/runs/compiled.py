"""Compiles the functions of a run for its seeds and devices, and predicts if they fit in memory."""

import math
import resource
import sys
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
from ..environment import where_env
from ..settings.config import Config
from .sharding import everywhere, make_mesh, placement_of, with_placement

MEGABYTE = 1_000_000


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
      parameters: that it starts with, with a first axis for several seeds; None: those of
        `program.init`.
    Raises:
      ConfigError: the environments don't divide evenly over the devices.
      NoMemoryError: the run doesn't fit into the device's memory.
    """
    began = time.perf_counter()
    mesh = make_mesh(config)
    at_once = jax.vmap if config.seeds > 1 else _unchanged
    over_seeds = at_once
    if config.seeds > 1 and program.loops and jax.default_backend() == "cpu":
        over_seeds = one_after_the_other

    def start_seed(seed: Array, parameters: Any) -> TrainState:
        """Returns the first state of one seed."""
        state = program.init(jax.random.key(seed))
        if parameters is None:
            return state
        assert program.adopt is not None
        return program.adopt(state, parameters)

    start_all = at_once(start_seed)
    seeds = jnp.asarray(config.seed_numbers, jnp.uint32)
    if config.seeds == 1:
        seeds = seeds[0]
    shapes = jax.eval_shape(start_all, seeds, parameters)
    places = placement_of(shapes, mesh, config.seeds)
    state = with_placement(shapes, places)
    # Return leaves, not a tree: tracing again creates a new optimiser, which JAX would take for a
    # different tree structure.
    init = jax.jit(
        lambda seeds, parameters: jax.tree.leaves(start_all(seeds, parameters)),
        out_shardings=jax.tree.leaves(places),
    )
    collect_all = over_seeds(program.collect)
    jit_collect = jax.jit(collect_all, donate_argnums=0, out_shardings=(places, None))
    collect = jit_collect.lower(state).compile()
    _, played = jax.eval_shape(collect_all, state)
    played = with_placement(played, collect.output_shardings[1])
    learn_all = over_seeds(program.learn)
    jit_learn = jax.jit(learn_all, donate_argnums=0, out_shardings=(places, everywhere(mesh)))
    learn = jit_learn.lower(state, played).compile()
    need = max(_bytes_needed(collect), _bytes_needed(learn))
    free = free_memory()
    if need > free:
        raise NoMemoryError(
            f"an update needs {need / MEGABYTE:,.0f} MB of memory on each of {mesh.size} "
            f"device(s), but only {free / MEGABYTE:,.0f} MB are free; "
            "make num_envs, num_steps, seeds or buffer_size smaller"
        )
    return Compiled(
        start=lambda: jax.tree.unflatten(jax.tree.structure(shapes), init(seeds, parameters)),
        collect=collect,
        learn=learn,
        parameters=at_once(program.parameters),
        state=state,
        seconds=time.perf_counter() - began,
        megabytes=need / MEGABYTE,
    )


def with_spread_starts(compiled: Compiled, config: Config, episode_length: int) -> Compiled:
    """Returns a run whose environments start at different steps of an episode, a rollout apart.

    Environments that all start together stay in lockstep: each update would see only one part of an
    episode. Here, environment b of B first plays `b * K // B` rollouts with the initial policy,
    where K is the number of rollouts in an episode; none if a rollout is a whole episode, or
    without `config.spread_starts`. These steps are neither learnt from nor counted.

    Args:
      compiled: the run.
      config: its `num_steps`, `seeds` and `spread_starts`.
      episode_length: steps of an episode.
    """
    rollouts = math.ceil(episode_length / config.num_steps)
    if rollouts <= 1 or not config.spread_starts:
        return compiled
    axis = int(config.seeds > 1)  # of environments
    choose = jax.vmap(where_env, in_axes=(None, 0, 0)) if axis else where_env

    @jax.jit
    def keep(number: int, worlds: Worlds, kept: Worlds) -> Worlds:
        """Returns the new worlds of environments that play `number` rollouts, else the kept."""
        num_envs = jax.tree.leaves(worlds)[0].shape[axis]
        plays = jnp.arange(num_envs) * rollouts // num_envs >= number  # [B]
        new_worlds: Worlds = choose(plays, worlds, kept)
        return new_worlds

    def start() -> TrainState:
        """Returns the first state; on the way there, environments stop after their rollouts."""
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

    It is faster on a CPU: the windows of one seed may fit into a cache, and a `cond` computes only
    the branch that applies.
    """
    return lambda *arguments: jax.lax.map(lambda of_seed: function(*of_seed), arguments)


def _unchanged(function: Callable[..., Any]) -> Callable[..., Any]:
    """Stands in for `jax.vmap` where there is one seed, without an axis."""
    return function


def _bytes_needed(compiled: Any) -> int:
    """Returns the memory that a program needs on a device according to XLA, or 0."""
    memory = compiled.memory_analysis()
    if memory is None:
        return 0
    size = memory.argument_size_in_bytes + memory.output_size_in_bytes
    return int(size + memory.temp_size_in_bytes - memory.alias_size_in_bytes)


def free_memory() -> float:
    """Returns the bytes free for this process.

    It is of its first device, or of the machine if that is a CPU. They are infinite if the device
    doesn't say.
    """
    if jax.default_backend() == "cpu":
        return float(psutil.virtual_memory().available)
    memory = jax.local_devices()[0].memory_stats() or {}
    return float(memory.get("bytes_limit", math.inf) - memory.get("bytes_in_use", 0))


def peak_megabytes() -> float:
    """Returns the peak memory of the first device so far, or of this process if that is a CPU."""
    if jax.default_backend() != "cpu":
        memory = jax.local_devices()[0].memory_stats() or {}
        return float(memory.get("peak_bytes_in_use", 0)) / MEGABYTE
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    unit = 1 if sys.platform == "darwin" else 1024
    return peak * unit / MEGABYTE
