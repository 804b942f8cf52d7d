"""The array program: everything a generated module consists of, in order, before it becomes text."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from sjdsl.compiler.diagnostics.source import Span


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
