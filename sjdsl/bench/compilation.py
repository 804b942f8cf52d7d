"""What XLA is given for one step of one environment: figures that are the same on every machine, and the seconds it takes."""

import re
import time
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

import jax
from jax.stages import Lowered

from sjdsl.runtime.env import Environment

COUNTED = ("scatter", "gather", "dynamic_slice", "sort", "while", "case")  # what XLA cannot fuse with its surroundings


@dataclass(frozen=True)
class Compilation:
    """What XLA has to do for one `env.step` under `jit`."""

    name: str
    num_agents: int
    observation: str
    compile_s: float
    stablehlo_lines: int
    operations: dict[str, int]


def compile_step(env: Environment, name: str = "") -> Compilation:
    """Returns the cost of compiling one step of a single environment, and the size of what XLA is given."""
    lowered = lower_step(env)
    began = time.perf_counter()
    lowered.compile()
    seconds = time.perf_counter() - began
    text = lowered.as_text()
    return Compilation(name or env.name, env.num_agents, env.observation, seconds, len(text.splitlines()), count_operations(text))


def lower_step(env: Environment) -> Lowered:
    """Returns one step of a single environment as XLA is given it."""
    key = jax.random.key(0)
    state = jax.eval_shape(env.reset, key)[1]
    return env.step.lower(key, state, jax.ShapeDtypeStruct((env.num_agents,), "int32"))


def count_operations(text: str, names: Iterable[str] = COUNTED) -> dict[str, int]:
    """Returns how often each operation is written in StableHLO text; one in a function counts once, however often it is called."""
    written = Counter(re.findall(r'(?<!#)\bstablehlo\.(\w+)"?[ (]', text))  # `#stablehlo.gather<...>` is an attribute
    return {name: written[name] for name in names}
