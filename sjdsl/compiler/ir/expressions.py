"""The typed IR: expressions, and the domains and shapes that quantifiers range over."""

from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias, TypeGuard

from sjdsl.compiler.ir.entity_types import EntityType
from sjdsl.compiler.ir.node import (
    AGENT,
    CELL,
    CONDITION,
    INSTANCE,
    Expression,
    Node,
    RestrictionNode,
    Type,
)

# Pydantic checks that a child is *some* expression. With the closed union each schema would hold
# all others: half a second at import.
if TYPE_CHECKING:
    Expr: TypeAlias = (
        "Number | Word | Truth | Nobody | Nowhere | ParamRef | Member | Local | FieldRead | "
        "Attribute | Distance | Bearing | At | Step | Arithmetic | Compare | Same | InRange | InWords | "
        "InSet | IsEmpty | Chose | ChoseWith | ArgumentOf | Unoccupied | StandsOn | StandsAt | "
        "Not | Logic | Count | Sum | SumRow | ShiftRow | Extreme | Case | Lowest | Mix | Named | "
        "Narrowed | Before | EventTotal | MatrixClass"
    )
    Restriction: TypeAlias = "Near | InAgents | InCell | Among"
else:
    Expr = Annotated[Expression, INSTANCE]
    Restriction = Annotated[RestrictionNode, INSTANCE]


def is_expression(node: Node) -> TypeGuard[Expr]:
    return isinstance(node, Expression)


Comparison: TypeAlias = Literal["<", "<=", ">", ">=", "==", "!="]


class Number(Expression):
    type: Type
    value: int | float


class Word(Expression):
    """One of `type.words`."""

    type: Type
    value: str


class Truth(Expression):
    type: Type = CONDITION
    value: bool


class Nobody(Expression):
    type: Type = AGENT


class Nowhere(Expression):
    """No cell."""

    type: Type = CELL


class ParamRef(Expression):
    """A run-time parameter; a whole table if `type.by`."""

    type: Type
    name: str


class Member(Expression):
    """A variable bound by a domain: an agent, a cell or a mover."""

    type: Type = Type(kind="member")
    name: str
    entity_type: Annotated[EntityType, INSTANCE]

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds that the cell may be of."""
        assert self.entity_type.what == "cell", self
        return self.entity_type.names


class Local(Expression):
    """A variable bound by `let` or `draw`."""

    type: Type
    name: str


class FieldRead(Expression):
    """A field at the start of the phase.

    `owner` is a Member, an expression of type agent or cell, or None for a world field.

    `held_by`: the sort of the owner. A whole row if `type.by`.
    """

    type: Type
    owner: Expr | None
    held_by: Annotated[EntityType, INSTANCE]
    name: str


class Attribute(Expression):
    """A fact that rules only read.

    Of an agent or a mover: `index`, `moved`, `away`; of an agent: `heading` (an enum value); of any
    of them or a cell: `row`, `col`.
    """

    type: Type
    owner: Expr
    name: Literal["index", "heading", "moved", "away", "row", "col"]


class Distance(Expression):
    """The steps along rows and columns between two agents or cells, whatever stands between.

    That is |row - row| + |col - col|.
    """

    type: Type
    left: Expr
    right: Expr


class Bearing(Expression):
    """How many steps ahead of an agent or mover, or to its right, somebody or a cell is.

    Negative behind it, or to its left.
    """

    type: Type
    fn: Literal["steps_ahead", "steps_right"]
    left: Expr
    right: Expr


class At(Expression):
    """One entry of a row or table.

    `key` has type word, or mix: then the entry is the expected one (shares times entries).
    """

    type: Type
    row: Expr
    key: Expr


class Step(Expression):
    """The number of finished steps of the episode."""

    type: Type


class Arithmetic(Expression):
    """A number made of others; `fn` is the name of its row in `CALCULATIONS` (`ir/operations.py`).

    Rows go entry by entry.
    """

    type: Type
    fn: str
    args: tuple[Expr, ...]


class Compare(Expression):
    type: Type = CONDITION
    fn: Comparison
    left: Expr
    right: Expr


class Same(Expression):
    """Both are words (perhaps of different sets), both agents, or both cells; the same one."""

    type: Type = CONDITION
    left: Expr
    right: Expr


class InRange(Expression):
    type: Type = CONDITION
    value: Expr
    low: Expr
    high: Expr


class InWords(Expression):
    type: Type = CONDITION
    value: Expr
    words: tuple[str, ...]


class InSet(Expression):
    """`value` is an agent, `container` a set of agents."""

    type: Type = CONDITION
    value: Expr
    container: Expr


class IsEmpty(Expression):
    """A set of agents has nobody in it."""

    type: Type = CONDITION
    container: Expr


class Chose(Expression):
    """The agent's action of this step (after `forbid`) is action number `action`."""

    type: Type = CONDITION
    agent: Expr
    action: int


class Given(Node):
    """What an argument of an action is to be.

    `type`: the values the argument has; `name`: as declared, perhaps empty.

    `value`: an agent (or the number of one), a whole number, or a word.
    """

    name: str = ""
    type: Type
    value: Expr


class ChoseWith(Expression):
    """The agent's action of this step (after `forbid`) is the one of this name with arguments.

    With just these, or with any if none are given.
    """

    type: Type = CONDITION
    agent: Expr
    action: str
    given: tuple[Given, ...] = ()


class ArgumentOf(Expression):
    """Argument `number` of the action that an agent chose, where that is surely this action.

    `name`: of the argument, as the rules write it.
    """

    type: Type
    agent: Expr
    action: str
    number: int
    name: str = ""


class Unoccupied(Expression):
    """`nobody on soil`.

    No agent and no mover is on this cell (a cell Member) at the start of the phase.
    """

    type: Type = CONDITION
    cell: Expr


class StandsOn(Expression):
    """`agent on grass`: the cell of the agent (or mover) is of one of `kinds`."""

    type: Type = CONDITION
    agent: Expr
    kinds: tuple[str, ...]


class StandsAt(Expression):
    """`agent on gate` where a statement around has bound the cell `gate`.

    The agent (or mover) is on this very cell, a Member.
    """

    type: Type = CONDITION
    agent: Member
    cell: Member


class Not(Expression):
    type: Type = CONDITION
    value: Expr


class Logic(Expression):
    """`and` or `or` of two or more conditions.

    Both sides are read; guards only matter to the checks.
    """

    type: Type = CONDITION
    fn: Literal["and", "or"]
    args: tuple[Expr, ...]


class Count(Expression):
    type: Type
    domain: "Domain"


class Sum(Expression):
    type: Type
    value: Expr
    domain: "Domain"


class SumRow(Expression):
    """All entries of a row in one: their sum, the least, the greatest."""

    type: Type
    row: Expr
    fn: Literal["sum", "min", "max"] = "sum"


class ShiftRow(Expression):
    """A row whose entries stand `by` places further on; `filler` where none comes from."""

    type: Type
    row: Expr
    by: int
    filler: Expr


class Extreme(Expression):
    """The least or greatest value over the members.

    `otherwise`, which sees none of them, if there are none (None: there is one).
    """

    type: Type
    fn: Literal["min", "max"]
    value: Expr
    domain: "Domain"
    otherwise: Expr | None = None


Aggregate: TypeAlias = Count | Sum | Extreme  # of the members of a domain


class Arm(Node):
    """One of the arms of a case.

    Numbers from `low` to `high` (ends included, None: open), or `words` (`yes`, `no` for a
    condition).
    """

    low: int | None = None
    high: int | None = None
    words: tuple[str, ...] = ()
    value: Expr


class Case(Expression):
    """Exactly one arm applies (checked).

    Arms are in the order written, `otherwise` already spelt out.
    """

    type: Type
    subject: Expr
    arms: tuple[Arm, ...]


class Lowest(Expression):
    """`lowest(row)`, or with `last` `highest(row)`: the first (last) word with a positive entry.

    If there is none, the first (last) word of all.
    """

    type: Type
    row: Expr
    last: bool = False


class Mix(Expression):
    """Shares of a row's entries: entry / sum, as float32."""

    type: Type
    row: Expr


class Named(Expression):
    """A `define`, written out here; the name is kept for the reader."""

    type: Type
    name: str
    value: Expr


class Narrowed(Expression):
    """A word that guards leave fewer words to.

    `type.words` are those of `value.type.words` that remain.
    """

    type: Type
    value: Expr


class Before(Expression):
    """In `always` and `once`: the value when the step began.

    Variables bound outside stand for the same agents, cells and movers.
    """

    type: Type
    value: Expr


class EventTotal(Expression):
    """In `checks`: how often the event was counted so far, over all agents.

    `word` one entry of a `by` event.
    """

    type: Type
    name: str
    word: str | None = None


class MatrixClass(Expression):
    """In `require`: a two-level table belongs to a class of 2 x 2 games, `PAYOFF_CLASSES`."""

    type: Type = CONDITION
    name: str
    table: Expr


# ---- domains


class Shape(Node):
    """Cells in a frame: (ahead, right) of the anchor.

    Lanes, each nearest first; a see-through shape ends no lane.

    The cells' order, lane by lane, is their number (draws inside `in SHAPE of x` are indexed by
    it).
    """

    name: str
    lanes: tuple[tuple[tuple[int, int], ...], ...]
    see_through: bool
    directed: bool

    @property
    def num_cells(self) -> int:
        return sum(map(len, self.lanes))


class Near(RestrictionNode):
    """The shape's cells around `anchor`, a Member; `shape` names one of `Game.shapes`."""

    shape: str
    anchor: Member


class InAgents(RestrictionNode):
    """The members of a field of type agent or set of agent."""

    value: Expr


class InCell(RestrictionNode):
    """The cell that a field holds, if it holds one."""

    value: Expr


class Among(RestrictionNode):
    """One of the named agent variables."""

    members: tuple[Member, ...]


class Domain(Node):
    """All (present) agents or movers, or all cells of `kinds`, restricted.

    Binds `var`, and `on` to the cell under the agent or mover.
    """

    var: Member
    on: Member | None = None
    restriction: Restriction | None = None
    where: Expr | None = None
