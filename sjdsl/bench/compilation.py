"""Compilation figures of one step: the size of the XLA program, which is the same on every machine,
and the seconds to compile it."""

import re
import time
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from statistics import median
from typing import Any

import jax
from jax.stages import Lowered

from sjdsl.runtime.env import Environment

# Operations that XLA can't fuse with others.
COUNTED = ("scatter", "gather", "dynamic_slice", "sort", "while", "case")
REPEATS = 3  # compilations whose median is reported


@dataclass(frozen=True)
class Compilation:
    """The compilation of one `env.step` under `jit`."""

    name: str
    num_agents: int
    observation: str
    compile_s: float
    stablehlo_lines: int
    operations: dict[str, int]


def compile_step(env: Environment, name: str = "") -> Compilation:
    """Returns the seconds to compile one step of a single environment (the median of some), and the
    size of the program."""
    seconds = median(_seconds_to_compile(env) for _ in range(REPEATS))
    text = lower_step(env).as_text()
    return Compilation(
        name or env.name,
        env.num_agents,
        env.observation,
        seconds,
        len(text.splitlines()),
        count_operations(text),
    )


def _seconds_to_compile(env: Environment) -> float:
    """Returns XLA's time for a step that isn't in its caches."""
    jax.clear_caches()
    # A new function, of which JAX has no program.
    new_step = jax.jit(lambda key, state, actions: env._step(key, state, actions))
    lowered = new_step.lower(*_argument_shapes(env))
    start = time.perf_counter()
    lowered.compile()
    return time.perf_counter() - start


def lower_step(env: Environment) -> Lowered:
    """Returns the program of one step of a single environment, before XLA compiles it."""
    step: Any = env.step
    result: Lowered = step.lower(*_argument_shapes(env))
    return result


def _argument_shapes(env: Environment) -> tuple[Any, Any, Any]:
    """Returns the key, state and actions of a step; state and actions only as shapes."""
    key = jax.random.key(0)
    _, state = jax.eval_shape(env.reset, key)
    return key, state, jax.ShapeDtypeStruct((env.num_agents,), "int32")


def count_operations(text: str, names: Iterable[str] = COUNTED) -> dict[str, int]:
    """Returns how often each operation is written in StableHLO text.

    An operation in a function counts once, however often the function is called.
    """
    # `#stablehlo.gather<...>` is an attribute, no operation.
    counts = Counter(re.findall(r'(?<!#)\bstablehlo\.(\w+)"?[ (]', text))
    return {name: counts[name] for name in names}
