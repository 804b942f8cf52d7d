"""Measures a parameter sweep: many values as arguments of one program, compared with one program
for each value.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import harmonic_mean
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from sjdsl.bench.loop import Task, game_task, make_loop, play, steps_for
from sjdsl.bench.machine import describe_machine
from sjdsl.bench.timing import compile_timed, memory_of, race
from sjdsl.compiler import ir
from sjdsl.library.parameters import build_params
from sjdsl.near_names import meant
from sjdsl.runtime.env import Environment

# Of the game's own value: narrow enough that the `require`s of most games still hold.
FACTORS = (0.75, 1.25)

APART = 3  # so many of the programs with a constant are compiled and measured


@dataclass(frozen=True)
class Sweep:
    """The cost of `num_values` values of `param`, with `num_envs` environments each: environment
    steps a second by round.

    `together`: all in one program. `apart`: a program with the value as a constant, for some of the
    values, one for each entry of `apart_compile_s`; the rounds run them in turn. `constant`: one
    such program with as many environments as `together`, which shows the cost of values as
    arguments.
    """

    machine: dict[str, Any]
    name: str
    param: str
    num_values: int
    num_envs: int
    together_compile_s: float
    together: tuple[float, ...]
    together_memory_bytes: int
    apart_compile_s: tuple[float, ...]
    apart: tuple[float, ...]
    constant_compile_s: float
    constant: tuple[float, ...]


def measure_sweep(
    task: Task,
    param: str,
    values: Sequence[Any],
    num_envs: int,
    repeats: int = 5,
    num_steps: int | None = None,
    tell: Callable[[str], object] = lambda _: None,
) -> Sweep:
    """Returns the cost of a sweep in one compilation and in many.

    Args:
      task: a game.
      param, values: the parameter that is varied, and `Params` with each of its values
        (`swept_params`).
      num_envs: environments of each value.
      repeats, num_steps: rounds, and steps of one timing (by default `steps_for` the number of
        environments of a program).
      tell: called with a line at the start of each compilation and round.
    """
    env = task.env
    if env is None:
        raise ValueError(f"{task.name} has no parameters")
    num_values = len(values)
    all_envs = num_values * num_envs
    all_steps = num_steps or steps_for(all_envs)
    few_steps = num_steps or steps_for(num_envs)
    # One program for all values, which are its arguments.
    tell(f"compiling one program for {num_values} values")
    stacked = jax.tree.map(lambda *leaves: jnp.repeat(jnp.stack(leaves), num_envs, axis=0), *values)
    together, together_s = compile_timed(make_sweep_loop(env, all_envs, all_steps), stacked)
    # A program for each of some values, which is a constant in it.
    indices = np.linspace(0, num_values - 1, min(APART, num_values)).round().astype(int)
    programs = []
    apart_compile_s = []
    for number, index in enumerate(indices, start=1):
        tell(f"compiling program {number} of {len(indices)} for one value each")
        program, seconds = compile_timed(_constant_loop(env, values[index], num_envs, few_steps))
        programs.append(program)
        apart_compile_s.append(seconds)
    # The same in as many environments as all values have.
    tell("compiling one program for one value")
    constant_loop = _constant_loop(env, values[indices[0]], all_envs, all_steps)
    constant, constant_s = compile_timed(constant_loop)
    loops: list[Callable[[Array], Array]] = [
        lambda key: together(key, stacked),
        constant,
        *programs,
    ]
    env_steps = [all_envs * all_steps] * 2 + [num_envs * few_steps] * len(programs)
    together_rates, constant_rates, *rates_of_programs = race(
        loops, env_steps, repeats, lambda number: tell(f"round {number} of {repeats}")
    )
    # The programs ran in turn, so the rate of a round is the harmonic mean of theirs.
    apart_rates = map(harmonic_mean, zip(*rates_of_programs, strict=True))
    return Sweep(
        machine=describe_machine(),
        name=task.name,
        param=param,
        num_values=num_values,
        num_envs=num_envs,
        together_compile_s=together_s,
        together=tuple(together_rates),
        together_memory_bytes=memory_of(together),
        apart_compile_s=tuple(apart_compile_s),
        apart=tuple(apart_rates),
        constant_compile_s=constant_s,
        constant=tuple(constant_rates),
    )


def swept_params(env: Environment, name: str, number: int) -> list[Any]:
    """Returns `Params` with `number` values of one parameter: the game's own times evenly spaced
    factors.

    A table is multiplied as a whole; whole numbers are rounded. Raises ValueError: no such
    parameter, or values the game does not admit.
    """
    params = {param.name: param for param in env.game.params}
    if name not in params:
        raise ValueError(f"{env.name} has no parameter `{name}`{meant(name, params, 'it has')}")
    param = params[name]
    if param.type.kind == "word":
        raise ValueError(f"`{name}` is a word; only numbers can be swept")
    factors = np.linspace(*FACTORS, number)
    values = [_scale(param.value, factor, param.type) for factor in factors.tolist()]
    if len(set(values)) < number:
        raise ValueError(
            f"`{name}` has only {len(set(values))} different values near {param.value}, "
            f"not {number}"
        )
    return [build_params(env.game, env.module, {name: value}) for value in values]


def _scale(value: Any, factor: float, type_: ir.Type) -> Any:
    """Returns a value, or each entry of a table, times a factor, within the limits of its type."""
    if isinstance(value, tuple):
        return tuple(_scale(entry, factor, type_) for entry in value)
    scaled = min(max(value * factor, type_.low), type_.high)
    return round(scaled) if type_.kind == "int" else scaled


def make_sweep_loop(
    env: Environment, num_envs: int, num_steps: int
) -> Callable[[Array, Any], Array]:
    """Returns the loop over environments with a value each, as a function of a key and the
    values.
    """

    def run(key: Array, params: Any) -> Array:
        def step(states: Any, actions: Array, keys: Array) -> tuple[Any, Array, Array]:
            observation, states, reward, _, _ = jax.vmap(env.step)(keys, states, actions, params)
            return states, reward, observation

        start = jax.vmap(lambda one: env.reset(jax.random.key(0), one)[1])(params)
        return play(step, start, (num_envs, env.num_agents), env.num_actions, num_steps, key)

    return run


def _constant_loop(
    env: Environment, params: Any, num_envs: int, num_steps: int
) -> Callable[[Array], Array]:
    """Returns the loop over environments with one value, a constant of the program.

    It has an environment of its own, so that JAX doesn't reuse a trace with another value.
    """
    new_env = Environment(env.module, params, env.observation, env.game)
    return make_loop(game_task(new_env), num_envs, num_steps)
