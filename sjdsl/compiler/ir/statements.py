"""The typed IR: statements of a phase."""

from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

from sjdsl.compiler.ir.entity_types import IndexSet
from sjdsl.compiler.ir.expressions import Domain, Expr, Member
from sjdsl.compiler.ir.node import INSTANCE, CourseNode, Node, Statement, Type

if TYPE_CHECKING:  # as `Expr` in expressions.py
    Stmt: TypeAlias = (
        "Let | Draw | Each | Pick | First | Match | When | Chance | Set | Add | Give | Tally | "
        "Send | Shift | Face | Remove | Move | Mark | End"
    )
    Course: TypeAlias = "Wander | Along"
else:
    Stmt = Annotated[Statement, INSTANCE]
    Course = Annotated[CourseNode, INSTANCE]


# By this the streams of those who return from being away differ from those of their `Send`:
# "RETU" in ASCII.
RETURN = 0x52455455


class Let(Statement):
    name: str
    value: Expr


class Draw(Statement):
    """Draws from one source.

    From `low` to `high` (ends included), or from `words`, with `weights` unless they are fair, or
    from `numbers` with weights.

    by: the entries of the row that is drawn, each by itself; None: one value.
    different: no two of them are equal.
    """

    name: str
    type: Type
    low: Expr | None = None
    high: Expr | None = None
    words: tuple[str, ...] = ()
    numbers: tuple[int, ...] = ()
    weights: tuple[Expr, ...] = ()
    by: Annotated[IndexSet | None, INSTANCE] = None
    different: bool = False
    stream: int


class Each(Statement):
    domain: Domain
    body: tuple[Stmt, ...]


class Pick(Statement):
    """`most`: the largest value `number` can have, as written.

    It fixes how many words of the stream an instance owns.
    """

    number: Expr
    most: int
    domain: Domain
    body: tuple[Stmt, ...]
    otherwise: tuple[Stmt, ...] = ()
    stream: int


class First(Statement):
    """In each lane of the domain's shape the nearest member, if any."""

    domain: Domain
    body: tuple[Stmt, ...]


class Match(Statement):
    """Greedy pairs in random order; `first`: only pairs that `first RIGHT` would give."""

    left: Domain
    right: Domain
    first: bool
    body: tuple[Stmt, ...]
    stream: int


class When(Statement):
    """The first branch whose condition holds, else `otherwise`."""

    branches: tuple["Branch", ...]
    otherwise: tuple[Stmt, ...] = ()


class Chance(Statement):
    """One draw per instance.

    Branch k has its condition's probability given that none before it came.
    """

    branches: tuple["Branch", ...]
    otherwise: tuple[Stmt, ...] = ()
    stream: int


class Branch(Node):
    """`test` is a condition (When) or a probability (Chance)."""

    test: Expr
    body: tuple[Stmt, ...]


class Set(Statement):
    """`target` is a FieldRead, or an At of one.

    A whole row is set if the target is a row and the value is not.

    `lot`: of all that write one target one does, drawn on this stream; None: all write the same.
    """

    target: Expr
    value: Expr
    lot: int | None = None


class Add(Statement):
    """To a number, a row (row value), or an agent to a set."""

    target: Expr
    value: Expr


class Give(Statement):
    """`receiver`: an agent (Member or agent-typed), a set of agents, None for all.

    `but`: all but this one.
    """

    value: Expr
    receiver: Expr | None
    but: Member | None = None


class Tally(Statement):
    """Counts an event, `amount` times (1 unless `by`).

    For an agent, each agent of a set, or the game (`receiver` None).

    `word`: the entry of a `by` event.
    """

    event: str
    word: Expr | None = None
    amount: Expr | None = None
    receiver: Expr | None = None


class Send(Statement):
    """To a free cell of `domain`, at once or after n ticks.

    All sends of one phase use with one `pool` share one order. `way`: the heading to face, read
    when it is sent, if that is not the word `facing`.
    """

    who: Expr
    domain: Domain
    after: Expr | None = None
    facing: Literal["north", "east", "south", "west", "same"] | None = None
    way: Expr | None = None
    stay: bool = False
    pool: int
    cell_stream: int
    heading_stream: int


class Shift(Statement):
    """To one cell: `to`, or the one so many `steps` away if the way is free.

    All shifts of one phase are settled together.

    The way: in the direction of the word `heading`, or toward the agent or cell `other`, turned by
    so many `quarters` to the right. `way`: as in Send.
    """

    who: Expr
    to: Expr | None = None
    steps: Expr | None = None
    heading: Expr | None = None
    other: Expr | None = None
    quarters: int = 0
    facing: Literal["north", "east", "south", "west", "same"] | None = None
    way: Expr | None = None
    stream: int
    heading_stream: int | None = None


class Face(Statement):
    """Turns an agent: `set agent.heading = e`. (The heading of a mover is a field of it.)"""

    who: Expr
    heading: Expr


class Remove(Statement):
    who: Expr


class Move(Statement):
    """All members of a domain step at once: agents as they chose, movers on their `course`."""

    domain: Domain
    course: Course | None = None
    stream: int


class Wander(CourseNode):
    """To one of the neighbouring cells that are open and free, by lot; it stays if there is none.

    `goal`: only those nearer to its nearest member, or (`away`) those farther from it. `avoided`:
    cells, or whose cells, are not open.
    """

    goal: Domain | None = None
    away: bool = False
    avoided: Domain | None = None
    stream: int


class Along(CourseNode):
    """One cell this way."""

    heading: Expr


class Mark(Statement):
    shape: str
    anchor: Member


class End(Statement):
    """The episode is over."""
