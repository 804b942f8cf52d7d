"""The array program: everything a generated module consists of, in order, before it becomes text."""

from typing import Literal

from sjdsl.compiler.program.expressions import Expression, Node, Statement
from sjdsl.runtime.planes import TokenPlane


class Fact(Node):
    """A constant by which the environment around a module knows the game."""

    name: str
    value: Expression
    comment: str = ""


Group = Literal["size", "action", "word", "other", "stream"]


class Number(Node):
    """A module-level number, such as how many cells of a kind there are. Those of one group stand together."""

    name: str
    value: int
    comment: str = ""
    group: Group = "other"


class Constant(Node):
    """A module-level array, as what makes it when the module is loaded: from the map, or from numbers that are written out."""

    name: str
    value: Expression
    comment: str


class Field(Node):
    """One attribute of State, Params or Outcome: `shape` as text, `dtype` as jax.numpy names it, its default."""

    name: str
    shape: str
    dtype: str
    comment: str
    default: Expression


class Function(Node):
    """A function of the module. `parameters`: (name, type); `returns`: the type."""

    name: str
    parameters: tuple[tuple[str, str], ...]
    returns: str
    doc: str
    body: tuple[Statement, ...]


class Program(Node):
    """A whole module.

    facts: what the module says of itself (NAME, NUM_AGENTS, …). map: its rows. planes: what an observation holds.
    numbers, constants: those that functions or defaults use. functions: in the order in which they stand in the module; `step` calls
    the phases in schedule order, after it has cleared marks and replaced forbidden actions.
    """

    name: str
    title: str
    source: str
    hash: str
    facts: tuple[Fact, ...]
    map: tuple[str, ...]
    planes: tuple[TokenPlane, ...]
    numbers: tuple[Number, ...]
    constants: tuple[Constant, ...]
    state: tuple[Field, ...]
    params: tuple[Field, ...]
    outcome: tuple[Field, ...]
    functions: tuple[Function, ...]
