"""The variables in scope while statements are lowered, and the iteration scope: axes, mask, instance index and bindings."""

from dataclasses import field, replace

from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.ir.sorts import AGENTS, Sort
from sjdsl.compiler.lower.axes import TRUE, Axis, Value, both
from sjdsl.compiler.program.expressions import Literal


class NotSupported(Exception):
    """The array program cannot say this exactly; nothing is approximated. `instead`: what can be written."""

    def __init__(self, what: str, origin: Span | None, instead: str = ""):
        super().__init__(what)
        self.what, self.origin, self.instead = what, origin, instead


class SetOfOne(Record):
    """An agent of each instance as a set, which is empty where `mask` does not hold."""

    members: Value
    mask: Value


class AgentVar(Record):
    """An agent or a mover: its number along `axis` (each once), or computed numbers `index`; `alone`: as a set, if known."""

    index: Value
    axis: Axis | None = None
    sort: Sort = AGENTS
    alone: SetOfOne | None = None

    @property
    def number(self) -> Value:
        """The number of the agent or mover among all of its sort."""
        return self.index


class CellVar(Record):
    """A cell of `kinds`: its number along `axis` (each cell once), or computed numbers `site` (S for none).

    `painted`: of a cell of a window these fields are known, by their names, and where it is; its axes are those of `seen`, the observer and
    the cell. `beside`: the cell is one of those around each cell, a parameter of a function as its fields are, which the writer collects.
    """

    site: Value
    kinds: tuple[str, ...]
    axis: Axis | None = None
    painted: tuple[tuple[str, Value], ...] | None = None
    seen: tuple[Axis, ...] = ()
    beside: bool = False

    @property
    def sort(self) -> Sort:
        return Sort("cell", self.kinds)

    @property
    def number(self) -> Value:
        """The number of the cell among those of its kinds."""
        return self.site


Variable = AgentVar | CellVar


class IterationScope(Record):
    """The instances of a statement: their axes, which of them happen (mask), their index, and the bindings.

    `digits` make up the index: (number of the member, how many there are), outermost first.
    """

    axes: tuple[Axis, ...] = ()
    mask: Value = TRUE
    digits: tuple[tuple[Value, Literal], ...] = ()
    variables: dict[str, Variable] = field(default_factory=dict)
    locals: dict[str, Value] = field(default_factory=dict)

    def when(self, condition: Value) -> "IterationScope":
        """Returns this scope where the condition holds as well."""
        return replace(self, mask=both(self.mask, condition))

    def always(self) -> "IterationScope":
        """Returns this scope without its mask: for values that are masked later."""
        return replace(self, mask=TRUE)

    def binding(self, **variables: Variable) -> "IterationScope":
        """Returns this scope with more variables."""
        return replace(self, variables={**self.variables, **variables})
