"""What a statement writes: a field of somebody, or an entry of a row, in the instances of its scope."""

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.ir.names import attribute_name
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import Axis, Value
from sjdsl.compiler.lower.entries import row_key, whole_axis
from sjdsl.compiler.lower.scope import IterationScope, Variable
from sjdsl.compiler.lower.writer import Writer


class Target(Record):
    """One field that a statement writes: of whom (None: the world), at which keys of its row, in which instances."""

    declared: ir.VarField
    who: Variable | None
    keys: tuple[ir.Expr, ...]
    read: ir.FieldRead
    scope: IterationScope

    @property
    def attribute(self) -> str:
        return attribute_name(self.declared)

    @property
    def own_axes(self) -> tuple[Axis, ...] | None:
        """The axis of those whose field it is, none for the world; None if they are computed numbers."""
        if self.who is None:
            return ()
        return None if self.who.axis is None else (self.who.axis,)

    def key(self, w: Writer) -> Value | None:
        """Returns the place of the entry of a row that is written; None for all of it."""
        return row_key(self.keys[0], self.read.type.by[0], self.scope.always(), w) if self.keys else None

    @property
    def along(self) -> Axis | None:
        """The axis that runs along the row that is written, one entry for each place; None where entries are found one by one."""
        axis = whole_axis(self.keys[0], self.scope) if self.keys else None
        return axis if axis is not None and self.own_axes is not None and axis not in self.own_axes else None


def past_the_end(who: Variable, w: Writer) -> Value:
    """Returns the number after that of the last agent, or cell of its kinds: what is written there is dropped."""
    return Value(state_reads.total_extent(who, w), "i32")
