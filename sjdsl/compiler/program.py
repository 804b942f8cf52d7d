"""The array program: what a generated module consists of, in order, before it becomes text."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from sjdsl.compiler.source import Span


@dataclass(frozen=True)
class Constant:
    """A module-level array; `text` is the source that computes it from the map, empty if its numbers are written out."""

    name: str
    value: np.ndarray
    comment: str
    text: str = ""


@dataclass(frozen=True)
class Attribute:
    """One attribute of State, Params or Outcome: `shape` as text, `dtype` as jax.numpy names it, its default as source."""

    name: str
    shape: str
    dtype: str
    comment: str
    default: str = ""


@dataclass(frozen=True)
class Line:
    """One statement, with the line of the `.sj` file it comes from."""

    text: str
    origin: Span | None = None


@dataclass(frozen=True)
class Function:
    name: str
    arguments: str
    doc: str
    lines: tuple[Line, ...]


@dataclass(frozen=True)
class Program:
    """A whole module. `observe_lines` cut windows from `state`; `plane_names` describe what they hold."""

    name: str
    title: str
    source: str
    constants: tuple[Constant, ...]
    state: tuple[Attribute, ...]
    params: tuple[Attribute, ...]
    outcome: tuple[Attribute, ...]
    functions: tuple[Function, ...]
    facts: tuple[tuple[str, str], ...] = ()


@dataclass
class Names:
    """Hands out names of one scope, each once; what is asked for twice gets a number."""

    taken: set[str] = field(default_factory=set)

    def fresh(self, wanted: str) -> str:
        """Returns `wanted`, or `wanted_2`, `wanted_3`, …"""
        name, number = wanted, 1
        while name in self.taken:
            number += 1
            name = f"{wanted}_{number}"
        self.taken.add(name)
        return name


def dump(program: Program) -> Iterator[str]:
    """Yields the program as stable text, line by line."""
    yield f"program {program.name} from {program.source}"
    for constant in program.constants:
        shown = f"{constant.value.dtype}{list(constant.value.shape)}"
        yield f"constant {constant.name} = {shown}  # {constant.comment}"
    for label, attributes in (("state", program.state), ("param", program.params), ("outcome", program.outcome)):
        for attribute in attributes:
            yield f"{label} {attribute.name} : {attribute.dtype}{attribute.shape}  # {attribute.comment}"
    for function in program.functions:
        yield f"function {function.name}({function.arguments})"
        for line in function.lines:
            yield "    " + line.text
