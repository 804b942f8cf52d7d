"""What lowering keeps while it writes one function: names, lines, constants, and the variables in scope."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.ir.names import RESERVED, Names, attribute_name, identifier
from sjdsl.compiler.lower.axes import Axis, Value, both, literal
from sjdsl.compiler.lower.map_tables import Layout, Table
from sjdsl.compiler.program import Constant, Line


class NotSupported(Exception):
    """The array program cannot say this exactly; nothing is approximated. `instead`: what can be written."""

    def __init__(self, what: str, origin: Span | None, instead: str = ""):
        super().__init__(what)
        self.what, self.origin, self.instead = what, origin, instead


@dataclass(frozen=True)
class AgentVar:
    """An agent: its id along `axis` (each agent once), or computed ids `index`."""

    index: Value
    axis: Axis | None = None


@dataclass(frozen=True)
class CellVar:
    """A cell of `kinds`: its number along `axis` (each cell once), or computed numbers `site` (S for none)."""

    site: Value
    kinds: tuple[str, ...]
    axis: Axis | None = None


@dataclass(frozen=True)
class Frame:
    """One place in a phase: the axes of its instances, which of them happen, their numbers, and the variables.

    `digits`: (number of the member, how many there are), outermost first.
    """

    axes: tuple[Axis, ...] = ()
    mask: Value | None = None
    digits: tuple[tuple[Value, int], ...] = ()
    variables: dict[str, AgentVar | CellVar] = field(default_factory=dict)
    locals: dict[str, Value] = field(default_factory=dict)

    def when(self, condition: Value | None) -> "Frame":
        """Returns this place where the condition holds as well."""
        return replace(self, mask=both(self.mask, condition))

    def always(self) -> "Frame":
        """Returns this place without its condition: for values that are masked later."""
        return replace(self, mask=None)


@dataclass
class Module:
    """What all functions of a module share."""

    game: ir.Game
    layout: Layout
    constants: dict[str, Constant] = field(default_factory=dict)
    names: Names = field(default_factory=Names)
    writer: "Writer | None" = None  # the last one, whose sentence is at fault where nothing else is known
    _by_content: dict[tuple[str, bytes, tuple[int, ...]], str] = field(default_factory=dict)

    def constant(self, name: str, array: np.ndarray | Table, comment: str) -> str:
        """Returns the name of a module-level array; equal arrays are kept once."""
        value, text = (array.value, array.text) if isinstance(array, Table) else (array, "")
        key = (str(value.dtype), value.tobytes(), value.shape)
        if key not in self._by_content:
            fresh = self.names.fresh(name.upper())
            self.constants[fresh] = Constant(fresh, value, comment, text)
            self._by_content[key] = fresh
        return self._by_content[key]

    @property
    def num_agents(self) -> int:
        return self.game.agents.number

    @property
    def set_dtype(self) -> str:
        """How a set of agents is kept: a bit for each agent."""
        return "u8" if self.num_agents <= 8 else "u32"

    @cached_property
    def can_be_away(self) -> bool:
        """Whether agents can be off the map during a step."""
        return self.stores_away or any(isinstance(n, ir.Remove) for n in ir.walk(self.game))

    @cached_property
    def stores_away(self) -> bool:
        """Whether somebody can be sent away for some ticks."""
        return any(s.after is not None for s in self.sends)

    @cached_property
    def sends(self) -> tuple[ir.Send, ...]:
        """All sentences that send agents somewhere, in the order of the game."""
        return tuple(n for n in ir.walk(self.game) if isinstance(n, ir.Send))

    def field(self, read: ir.FieldRead, kind: str = "") -> ir.VarField:
        """Returns the declaration of a field."""
        if read.place == "world":
            return next(f for f in self.game.fields if f.name == read.name)
        if read.place == "agent":
            return next(f for f in self.game.agents.fields if f.name == read.name)
        declared = next(k for k in self.game.kinds if k.name == (kind or read.kinds[0]))
        return next(f for f in declared.fields if f.name == read.name)

    def shape(self, name: str) -> ir.Shape:
        return next(s for s in self.game.shapes if s.name == name)


@dataclass
class Writer:
    """Writes the lines of one function."""

    module: Module
    lines: list[Line] = field(default_factory=list)
    names: Names = field(default_factory=lambda: Names(set(RESERVED)))
    starting: bool = False
    origin: Span | None = None
    known: dict[tuple[str, str], str] = field(default_factory=dict)
    axes_made: int = 0
    changed: dict[str, str] = field(default_factory=dict)
    outcome: dict[str, str] = field(default_factory=dict)
    added: dict[str, list[Value]] = field(default_factory=dict)
    marked: dict[str, int] = field(default_factory=dict)
    joined: dict[str, list[str]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.module.writer = self

    def line(self, text: str) -> None:
        self.lines.append(Line(text, self.origin))

    def axis(self, name: str, size: int) -> Axis:
        """Returns a new axis, to the right of all made before."""
        self.axes_made += 1
        return Axis(f"{name}{self.axes_made}", size, self.axes_made)

    def keep(self, name: str, value: Value) -> Value:
        """Gives a value a name in the function; the same text is named once."""
        if value.literal or value.text.isidentifier():
            return value
        key = (value.text, value.dtype)
        if key not in self.known:
            fresh = self.names.fresh(identifier(name.lower()))
            self.line(f"{fresh} = {value.text}")
            self.known[key] = fresh
        return replace(value, text=self.known[key])

    def current(self, attribute: str) -> str:
        """Returns where a state attribute's new value stands so far."""
        return self.changed.get(attribute, f"state.{attribute}")

    def assign(self, attribute: str, text: str) -> None:
        """Gives a state attribute a new value."""
        if attribute not in self.changed:
            self.changed[attribute] = self.names.fresh(attribute)
        self.line(f"{self.changed[attribute]} = {text}")

    def total(self, attribute: str) -> str:
        """Returns where an attribute of the outcome stands so far."""
        return self.outcome.get(attribute, f"out.{attribute}")

    def accumulate(self, attribute: str, text: str) -> None:
        """Gives an attribute of the outcome a new value."""
        if attribute not in self.outcome:
            self.outcome[attribute] = self.names.fresh(attribute)
        self.line(f"{self.outcome[attribute]} = {text}")


def iota(axis: Axis, dtype: str = "i32") -> Value:
    """Returns 0, 1, … along an axis."""
    from sjdsl.compiler.lower.axes import DTYPES

    return Value(f"jnp.arange({axis.size}, dtype={DTYPES[dtype]})", dtype, (axis,))


__all__ = ["AgentVar", "CellVar", "Frame", "Module", "NotSupported", "Writer", "attribute_name", "iota", "literal"]
