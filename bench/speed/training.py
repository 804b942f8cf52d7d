"""Splits the time of a training update into environment steps, acting and learning, with a lower bound from its matrices."""

import math
import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

from bench.speed.extrapolation import Hours, hours_to
from bench.speed.training_setups import Setup
from bench.speed.training_split import Split
from sjdsl.bench.machine import describe_machine
from sjdsl.bench.timing import race

SIDE = 2048  # of the square matrices whose product shows what the machine can do
TIMED = 2048  # environment steps of one timing, at least: an update of one short rollout is over too soon to be timed alone


@dataclass(frozen=True)
class Training:
    """The updates measured, and the floating-point operations a second of a large float32 matrix product on the same machine.

    `hours`: of training for `hours_to` environment steps, extrapolated from the updates, in the order of `splits`. `left_out`: what could
    not be measured, and why.
    """

    machine: dict[str, Any]
    flops_per_s: float
    splits: tuple[Split, ...]
    hours_to: int | None = None
    hours: tuple[Hours, ...] = ()
    left_out: tuple[str, ...] = ()


def measure_training(
    setups: Sequence[Setup],
    repeats: int = 5,
    tell: Callable[[str], object] = lambda _: None,
    env_steps: int | None = None,
    left_out: Sequence[str] = (),
    keep: Callable[[Training], object] = lambda _: None,
) -> Training:
    """Returns where updates spend their time; one that does not fit into memory is left out.

    Args:
      setups: what is trained, of `training_setups`.
      repeats: rounds.
      tell: called with a line whenever something is compiled.
      env_steps: environment steps of the run whose hours are extrapolated; None: no hours.
      left_out: what cannot be measured, a line each.
      keep: called with all figures so far whenever there are new ones.
    """
    from sjdsl.trainers.compiled import NoMemoryError

    found = Training(describe_machine(), matrix_flops_per_s(repeats), (), env_steps, (), tuple(left_out))
    for setup in setups:
        tell(f"compiling {setup}")
        try:
            split = measure_split(setup, repeats)
        except NoMemoryError as error:
            found = replace(found, left_out=(*found.left_out, f"{setup}: {error}"))
        else:
            hours = () if env_steps is None else hours_to(env_steps, [split])
            found = replace(found, splits=(*found.splits, split), hours=(*found.hours, *hours))
        keep(found)
    return found


def measure_split(setup: Setup, repeats: int) -> Split:
    """Returns the parts of one update, as a run computes it; all are timed in turn, round by round."""
    from bench.speed.training_parts import flops_of, idle_rollout
    from sjdsl.trainers import make_train
    from sjdsl.trainers.compiled import compile_train

    env, config = setup.env, setup.config
    compiled = compile_train(make_train(env, config), config)
    idle = jax.jit(idle_rollout(env, config))
    first = compiled.start()
    flops, worlds = flops_of(env, config, compiled.parameters(first)), jax.tree.map(jnp.copy, first.worlds)
    state, played = compiled.collect(first)

    def collect() -> Any:
        nonlocal state
        state, found = compiled.collect(state)  # the memory of what it is given is used again
        return found

    def learn(found: Any) -> Any:
        nonlocal state
        state, metrics = compiled.learn(state, found)
        return metrics

    updates = math.ceil(TIMED / config.steps_per_update)
    loops = [
        lambda _: _repeated(lambda: learn(collect()), updates),
        lambda key: _repeated(lambda: idle(worlds, key), updates),
        lambda _: _repeated(collect, updates),
        lambda _: _repeated(lambda: learn(played), updates),
    ]
    rates = race(loops, [updates] * len(loops), repeats, lambda _: None)
    whole, idle_s, collect_s, learn_s = (tuple(1 / rate for rate in rounds) for rounds in rates)
    sizes = (setup.network, config.num_envs, config.num_steps)
    return Split(setup.name, env.num_agents, *sizes, compiled.seconds, whole, idle_s, collect_s, learn_s, flops, *setup.learning)


def _repeated(part: Callable[[], Any], number: int) -> Array:
    """Returns the first leaf of what the last of so many calls gives, when all is computed."""
    found = None
    for _ in range(number):
        found = part()
    result: Array = jax.tree.leaves(jax.block_until_ready(found))[0]
    return result


def matrix_flops_per_s(repeats: int) -> float:
    """Returns the floating-point operations a second of a large matrix product in float32, the median of the rounds."""
    matrix = jnp.ones((SIDE, SIDE), jnp.float32)
    product = jax.jit(jnp.matmul)
    product(matrix, matrix).block_until_ready()
    rates = []
    for _ in range(repeats):
        began = time.perf_counter()
        product(matrix, matrix).block_until_ready()
        rates.append(2 * SIDE**3 / (time.perf_counter() - began))
    return statistics.median(rates)
