"""Compilation figures of one step: the size of the XLA program, the same on every machine, and the seconds to compile it."""

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

COUNTED = (
    "scatter",
    "gather",
    "dynamic_slice",
    "sort",
    "while",
    "case",
)  # what XLA cannot fuse with its surroundings
REPEATS = 3  # compilations whose median is reported


@dataclass(frozen=True)
class Compilation:
    """What XLA has to do for one `env.step` under `jit`."""

    name: str
    num_agents: int
    observation: str
    compile_s: float
    stablehlo_lines: int
    operations: dict[str, int]


def compile_step(env: Environment, name: str = "", repeats: int = REPEATS) -> Compilation:
    """Returns the cost of compiling one step of a single environment (the median of some), and the size of what XLA is given."""
    seconds = median(_seconds_to_compile(env) for _ in range(repeats))
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
    """Returns XLA's time for a step that it has not seen before: a new function, and none of this process's programs."""
    jax.clear_caches()
    lowered = jax.jit(lambda key, state, actions: env._step(key, state, actions)).lower(
        *_described(env)
    )
    began = time.perf_counter()
    lowered.compile()
    return time.perf_counter() - began


def lower_step(env: Environment) -> Lowered:
    """Returns one step of a single environment as XLA is given it."""
    step: Any = env.step
    result: Lowered = step.lower(*_described(env))
    return result


def _described(env: Environment) -> tuple[Any, Any, Any]:
    """Returns what a step takes, as shapes."""
    key = jax.random.key(0)
    return key, jax.eval_shape(env.reset, key)[1], jax.ShapeDtypeStruct((env.num_agents,), "int32")


def count_operations(text: str, names: Iterable[str] = COUNTED) -> dict[str, int]:
    """Returns how often each operation is written in StableHLO text; one in a function counts once, however often it is called."""
    written = Counter(
        re.findall(r'(?<!#)\bstablehlo\.(\w+)"?[ (]', text)
    )  # `#stablehlo.gather<...>` is an attribute
    return {name: written[name] for name in names}
