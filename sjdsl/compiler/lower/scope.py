"""What is in scope while statements are lowered: variables, axes, masks and instance numbers."""

from dataclasses import field, replace

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.ir.entity_types import AGENTS, EntityType
from sjdsl.compiler.lower.axes import TRUE, Axes, Axis, Value, iota
from sjdsl.compiler.program.expressions import Literal


class NotSupported(Exception):
    """The array program can't express this exactly; nothing is approximated.

    instead: what can be written.
    """

    def __init__(self, feature: str, origin: Span | None, instead: str = ""):
        super().__init__(feature)
        self.feature = feature
        self.origin = origin
        self.instead = instead


class SetOfOne(Record):
    """An agent of each instance as a set, which is empty where `mask` does not hold."""

    members: Value
    mask: Value


class AgentVar(Record):
    """Agents or movers: along `axis`, each once in order, or as computed numbers.

    number: their numbers among all of the type. alone: each as a set of one, if that has been
      computed.
    """

    number: Value
    axis: Axis | None = None
    entity_type: EntityType = AGENTS
    alone: SetOfOne | None = None


class CellVar(Record):
    """Cells of `kinds`: along `axis`, each once in order, or as computed numbers.

    number: their numbers among the cells of `kinds`, or how many there are for no such cell.
    painted: for cells of windows, the fields whose values are known, by name; `seen` then has the
      axes of observers and of a window's cells.
    beside: whether this is one of the cells around each cell. Its fields are then parameters of a
      function, which the writer collects.
    """

    number: Value
    kinds: tuple[str, ...]
    axis: Axis | None = None
    painted: tuple[tuple[str, Value], ...] | None = None
    seen: Axes = ()
    beside: bool = False

    @property
    def entity_type(self) -> EntityType:
        return EntityType("cell", self.kinds)


Variable = AgentVar | CellVar


def numbered(var: ir.Member, number: Value) -> Variable:
    """Returns the agents, movers or cells that a variable of a domain is, by their numbers."""
    if var.entity_type.what == "cell":
        return CellVar(number, var.kinds)
    return AgentVar(number, entity_type=var.entity_type)


class IterationScope(Record):
    """The instances of a statement.

    mask: which of them happen. digits: of the number of an instance, outermost first: the number
    of a member, and how many members there are.
    """

    axes: Axes = ()
    mask: Value = TRUE
    digits: tuple[tuple[Value, Literal], ...] = ()
    variables: dict[str, Variable] = field(default_factory=dict)
    locals: dict[str, Value] = field(default_factory=dict)

    def when(self, condition: Value) -> "IterationScope":
        """Returns this scope where the condition holds as well."""
        return replace(self, mask=self.mask & condition)

    def always(self) -> "IterationScope":
        """Returns this scope without its mask: for values that are masked later."""
        return replace(self, mask=TRUE)

    def binding(self, name: str, variable: Variable) -> "IterationScope":
        """Returns this scope with one more variable."""
        return replace(self, variables={**self.variables, name: variable})

    def letting(self, name: str, value: Value) -> "IterationScope":
        """Returns this scope with one more local value."""
        return replace(self, locals={**self.locals, name: value})


def scope_of_agents(axes: Axes) -> IterationScope:
    """Returns the scope of what is about `agent`, who is along the first axis."""
    return IterationScope(axes=axes, variables={"agent": AgentVar(iota(axes[0]), axes[0])})
