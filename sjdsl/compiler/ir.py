"""The typed IR: one game with every name resolved, every size a number, every phase use written out, every draw named.

Words and agents are values; numbers carry their unit and the interval they provably stay in. Variables are named as in
the text; an inner one never has the name of an outer one. All nodes are frozen and compare by content; `origin` is the
only part that two equal programs may differ in.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, InstanceOf

from sjdsl.compiler.source import Span

Unit = Literal["count", "steps", "cells", "reward", "probability", "fraction", "number"]


class Node(BaseModel):
    """A frozen part of the IR. `origin` is where the author wrote it."""

    model_config = ConfigDict(frozen=True, extra="forbid", arbitrary_types_allowed=True)
    origin: Span | None = Field(default=None, repr=False)


class Expression(Node):
    """Something with a value."""


class Sentence(Node):
    """Something a phase does."""


class PlaceNode(Node):
    """Where the members of a domain are looked for."""


class TurnNode(Node):
    """One place of the schedule."""


# Pydantic checks that a child is *some* expression; the closed unions are for `match` and the type checker. (Discriminated
# unions would make every model's schema contain every other: half a second at import.)
if TYPE_CHECKING:
    Expr: TypeAlias = (
        "Number | Word | Truth | Nobody | ParamRef | Member | Local | FieldRead | Attribute | At | Step | Arithmetic"
        " | Compare | Same | InRange | InWords | InSet | IsEmpty | Chose | Unoccupied | StandsOn | Not | Logic | Count"
        " | Sum | SumRow | Case | Lowest | Mix | Ramp | Named | Narrowed | EventTotal | MatrixClass"
    )
    Stmt: TypeAlias = (
        "Let | Draw | Each | Pick | First | Match | When | Chance | Set | Add | Give | Tally | Send | Remove | Move"
        " | Mark | End"
    )
    Place: TypeAlias = "Near | InAgents | Among"
    Turn: TypeAlias = "Phase | Tick"
else:
    Expr = InstanceOf[Expression]
    Stmt = InstanceOf[Sentence]
    Place = InstanceOf[PlaceNode]
    Turn = InstanceOf[TurnNode]


class Type(BaseModel):
    """What values an expression has.

    kind: `word` (one of `words`), `int` and `real` (`unit`, `low` .. `high`), `condition`, `agent` (one or nobody),
      `agents` (a set), `mix` (shares over `words`), `member` (a variable of a domain: an agent or a cell).
    by: word sets of the table or row levels, outermost first; empty for a single value.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")
    kind: Literal["word", "int", "real", "condition", "agent", "agents", "mix", "member"]
    words: tuple[str, ...] = ()
    unit: Unit = "number"
    low: float = float("-inf")
    high: float = float("inf")
    by: tuple[tuple[str, ...], ...] = ()


CONDITION = Type(kind="condition")
AGENT = Type(kind="agent")
AGENTS = Type(kind="agents")


# ---- expressions


class Number(Expression):
    op: Literal["number"] = "number"
    type: Type
    value: int | float


class Word(Expression):
    """One of `type.words`."""

    op: Literal["word"] = "word"
    type: Type
    value: str


class Truth(Expression):
    op: Literal["truth"] = "truth"
    type: Type = CONDITION
    value: bool


class Nobody(Expression):
    op: Literal["nobody"] = "nobody"
    type: Type = AGENT


class ParamRef(Expression):
    """A run-time parameter; a whole table if `type.by`."""

    op: Literal["param"] = "param"
    type: Type
    name: str


class Member(Expression):
    """A variable bound by a domain: an agent (`who` agent) or a cell of one of `kinds`."""

    op: Literal["member"] = "member"
    type: Type = Type(kind="member")
    name: str
    who: Literal["agent", "cell"]
    kinds: tuple[str, ...] = ()


class Local(Expression):
    """A variable bound by `let` or `draw`."""

    op: Literal["local"] = "local"
    type: Type
    name: str


class FieldRead(Expression):
    """A field at the start of the phase. `owner` is a Member, an expression of type agent, or None for a world field.

    `kinds`: the kinds of the owner, for a cell's field. A whole row if `type.by`.
    """

    op: Literal["field"] = "field"
    type: Type
    owner: Expr | None
    place: Literal["agent", "cell", "world"]
    kinds: tuple[str, ...] = ()
    name: str


class Attribute(Expression):
    """Read-only facts: of an agent `index`, `heading` (word), `moved`, `away`; of an agent or cell `row`, `col`."""

    op: Literal["attribute"] = "attribute"
    type: Type
    owner: Expr
    name: Literal["index", "heading", "moved", "away", "row", "col"]


class At(Expression):
    """One entry of a row or table. `key` has type word, or mix: then the entry is the expected one (shares times entries)."""

    op: Literal["at"] = "at"
    type: Type
    row: Expr
    key: Expr


class Step(Expression):
    """The number of finished steps of the episode."""

    op: Literal["step"] = "step"
    type: Type


class Arithmetic(Expression):
    """`neg` has one argument; `min` and `max` have two or more; `+` `-` `*` `/` `%` have two. Rows go entry by entry.

    `/` of integers is a real; `%` is of integers, with the sign of the divisor.
    """

    op: Literal["arithmetic"] = "arithmetic"
    type: Type
    fn: Literal["+", "-", "*", "/", "%", "neg", "min", "max"]
    args: tuple[Expr, ...]


class Compare(Expression):
    op: Literal["compare"] = "compare"
    type: Type = CONDITION
    fn: Literal["<", "<=", ">", ">=", "==", "!="]
    left: Expr
    right: Expr


class Same(Expression):
    """Both are words (perhaps of different sets), both agents, or both members; the same one."""

    op: Literal["same"] = "same"
    type: Type = CONDITION
    left: Expr
    right: Expr


class InRange(Expression):
    op: Literal["in_range"] = "in_range"
    type: Type = CONDITION
    value: Expr
    low: Expr
    high: Expr


class InWords(Expression):
    op: Literal["in_words"] = "in_words"
    type: Type = CONDITION
    value: Expr
    words: tuple[str, ...]


class InSet(Expression):
    """`value` is an agent, `container` a set of agents."""

    op: Literal["in_set"] = "in_set"
    type: Type = CONDITION
    value: Expr
    container: Expr


class IsEmpty(Expression):
    """A set of agents has nobody in it."""

    op: Literal["is_empty"] = "is_empty"
    type: Type = CONDITION
    container: Expr


class Chose(Expression):
    """The agent's action of this step (after `forbid`) is action number `action`."""

    op: Literal["chose"] = "chose"
    type: Type = CONDITION
    agent: Expr
    action: int


class Unoccupied(Expression):
    """`nobody on soil`: no agent is on this cell (a cell Member) at the start of the phase."""

    op: Literal["unoccupied"] = "unoccupied"
    type: Type = CONDITION
    cell: Expr


class StandsOn(Expression):
    """`agent on grass`: the agent's cell is of one of `kinds`."""

    op: Literal["stands_on"] = "stands_on"
    type: Type = CONDITION
    agent: Expr
    kinds: tuple[str, ...]


class Not(Expression):
    op: Literal["not"] = "not"
    type: Type = CONDITION
    value: Expr


class Logic(Expression):
    """`and` or `or` of two or more conditions. Both sides are read; guards only matter to the checks."""

    op: Literal["logic"] = "logic"
    type: Type = CONDITION
    fn: Literal["and", "or"]
    args: tuple[Expr, ...]


class Count(Expression):
    op: Literal["count"] = "count"
    type: Type
    domain: Domain


class Sum(Expression):
    op: Literal["sum"] = "sum"
    type: Type
    value: Expr
    domain: Domain


class SumRow(Expression):
    op: Literal["sum_row"] = "sum_row"
    type: Type
    row: Expr


class Arm(Node):
    """Numbers `low` .. `high` (ends included, None: open), or `words` (`yes`, `no` for a condition)."""

    low: int | None = None
    high: int | None = None
    words: tuple[str, ...] = ()
    value: Expr


class Case(Expression):
    """Exactly one arm applies (checked); arms are in the order written, `otherwise` already spelt out."""

    op: Literal["case"] = "case"
    type: Type
    subject: Expr
    arms: tuple[Arm, ...]


class Lowest(Expression):
    """First (`last`: last) word of the row with a positive entry; the first word of all if there is none."""

    op: Literal["lowest"] = "lowest"
    type: Type
    row: Expr
    last: bool = False


class Mix(Expression):
    """Shares of a row's entries: entry / sum, as float32."""

    op: Literal["mix"] = "mix"
    type: Type
    row: Expr


class Ramp(Expression):
    """(x - zero_at) / (one_at - zero_at), clipped to 0 .. 1."""

    op: Literal["ramp"] = "ramp"
    type: Type
    value: Expr
    zero_at: Expr
    one_at: Expr


class Named(Expression):
    """A `define`, written out here; the name is kept for the reader."""

    op: Literal["named"] = "named"
    type: Type
    name: str
    value: Expr


class Narrowed(Expression):
    """A word that guards leave fewer words to: `type.words` are those of `value.type.words` that remain."""

    op: Literal["narrowed"] = "narrowed"
    type: Type
    value: Expr


class EventTotal(Expression):
    """In `checks`: how often the event was counted so far, over all agents; `word` one entry of a `by` event."""

    op: Literal["event_total"] = "event_total"
    type: Type
    name: str
    word: str | None = None


class MatrixClass(Expression):
    """In `require`: a two-level table belongs to a class of 2 x 2 games (`prisoners_dilemma`, `stag_hunt`, `chicken`)."""

    op: Literal["matrix_class"] = "matrix_class"
    type: Type = CONDITION
    name: Literal["prisoners_dilemma", "stag_hunt", "chicken"]
    table: Expr


# ---- who


class Shape(Node):
    """Cells in a frame: (ahead, right) of the anchor. Lanes, each nearest first; a see-through shape ends no lane.

    The cells' order, lane by lane, is their number (draws inside `in SHAPE of x` are indexed by it).
    """

    name: str
    lanes: tuple[tuple[tuple[int, int], ...], ...]
    see_through: bool
    directed: bool


class Near(PlaceNode):
    """The shape's cells around `anchor`, an agent or cell Member; `shape` names one of `Game.shapes`."""

    op: Literal["near"] = "near"
    shape: str
    anchor: Member


class InAgents(PlaceNode):
    """The members of a field of type agent or set of agent."""

    op: Literal["in_agents"] = "in_agents"
    value: Expr


class Among(PlaceNode):
    """One of the named agent variables."""

    op: Literal["among"] = "among"
    members: tuple[Member, ...]


class Domain(Node):
    """All (present) agents, or all cells of `kinds`, restricted; binds `var`, and `on_var` to the cell under the agent."""

    var: Member
    on: Member | None = None
    place: Place | None = None
    where: Expr | None = None


# ---- sentences


class Let(Sentence):
    op: Literal["let"] = "let"
    name: str
    value: Expr


class Draw(Sentence):
    """Exactly one source: `low` .. `high` (ends included), or `words`, with `weights` unless they are fair."""

    op: Literal["draw"] = "draw"
    name: str
    type: Type
    low: Expr | None = None
    high: Expr | None = None
    words: tuple[str, ...] = ()
    weights: tuple[Expr, ...] = ()
    stream: int


class Each(Sentence):
    op: Literal["each"] = "each"
    domain: Domain
    body: tuple[Stmt, ...]


class Pick(Sentence):
    op: Literal["pick"] = "pick"
    number: Expr
    domain: Domain
    body: tuple[Stmt, ...]
    otherwise: tuple[Stmt, ...] = ()
    stream: int


class First(Sentence):
    """In each lane of the domain's shape the nearest member, if any; `otherwise` for each lane without one."""

    op: Literal["first"] = "first"
    domain: Domain
    body: tuple[Stmt, ...]
    otherwise: tuple[Stmt, ...] = ()


class Match(Sentence):
    """Greedy pairs in random order; `first`: only pairs that `first RIGHT` would give."""

    op: Literal["match"] = "match"
    left: Domain
    right: Domain
    first: bool
    body: tuple[Stmt, ...]
    stream: int


class When(Sentence):
    """The first branch whose condition holds, else `otherwise`."""

    op: Literal["when"] = "when"
    branches: tuple[Branch, ...]
    otherwise: tuple[Stmt, ...] = ()


class Chance(Sentence):
    """One draw per instance; branch k has its condition's probability given that none before it came."""

    op: Literal["chance"] = "chance"
    branches: tuple[Branch, ...]
    otherwise: tuple[Stmt, ...] = ()
    stream: int


class Branch(Node):
    """`test` is a condition (When) or a probability (Chance)."""

    test: Expr
    body: tuple[Stmt, ...]


class Set(Sentence):
    """`target` is a FieldRead, or an At of one; a whole row is set if the target is a row and the value is not."""

    op: Literal["set"] = "set"
    target: Expr
    value: Expr


class Add(Sentence):
    """To a number, a row (row value), or an agent to a set."""

    op: Literal["add"] = "add"
    target: Expr
    value: Expr


class Give(Sentence):
    """`receiver`: an agent (Member or agent-typed), a set of agents, None for all; `but`: all but this one."""

    op: Literal["give"] = "give"
    value: Expr
    receiver: Expr | None
    but: Member | None = None


class Tally(Sentence):
    """Counts `amount` (1 unless `by`) of an event for an agent, each agent of a set, or the game (`receiver` None).

    `word`: the entry of a `by` event.
    """

    op: Literal["tally"] = "tally"
    event: str
    word: Expr | None = None
    amount: Expr | None = None
    receiver: Expr | None = None


class Send(Sentence):
    """To a free cell of `domain`, at once or after n ticks. All sends of one phase use with one `pool` share one order."""

    op: Literal["send"] = "send"
    who: Expr
    domain: Domain
    after: Expr | None = None
    facing: Literal["north", "east", "south", "west", "same"] | None = None
    stay: bool = False
    pool: int
    order_stream: int
    heading_stream: int


class Remove(Sentence):
    op: Literal["remove"] = "remove"
    who: Expr


class Move(Sentence):
    op: Literal["move"] = "move"
    domain: Domain
    stream: int


class Mark(Sentence):
    op: Literal["mark"] = "mark"
    shape: str
    anchor: Member


class End(Sentence):
    op: Literal["end"] = "end"


# ---- the game


class Size(Node):
    name: str
    type: Type
    value: int | float | tuple


class Param(Node):
    """Default `value` nested as `type.by`; words for a word parameter. `type.low` .. `type.high` are its limits."""

    name: str
    type: Type
    value: int | float | str | tuple


class VarField(Node):
    """A variable of each cell of `kind`, each agent (`agents`) or the world. `start`: number, word, or None for nobody."""

    name: str
    place: Literal["agent", "cell", "world"]
    kind: str = ""
    type: Type
    capped: bool = False
    timer: bool = False
    start: int | float | str | None = None


class Block(Node):
    """`what`: `agents` or a shape's name. The condition reads the cell (Member `kind`) and `agent` (mover or anchor)."""

    what: str
    condition: Expr | None = None


class Kind(Node):
    name: str
    glyph: str
    fields: tuple[VarField, ...] = ()
    blocks: tuple[Block, ...] = ()


class GlyphMeaning(Node):
    """A map character: its kind, and the starting values that differ from the declared ones."""

    glyph: str
    kind: str
    starts: tuple[tuple[str, int | float | str], ...] = ()


class Forbid(Node):
    """`actions` are numbers; the condition reads `agent`."""

    actions: tuple[int, ...]
    condition: Expr


class Agents(Node):
    number: int
    actions: tuple[str, ...]
    relative: bool
    fields: tuple[VarField, ...] = ()
    forbids: tuple[Forbid, ...] = ()


class Phase(TurnNode):
    """One use of a phase. `label` as in the schedule (`sprout(red)`); `name` a Python identifier, unique in the game."""

    op: Literal["phase"] = "phase"
    label: str
    name: str
    body: tuple[Stmt, ...]


class Tick(TurnNode):
    """All timers fall by one, agents whose time away is over return."""

    op: Literal["tick"] = "tick"


class Event(Node):
    """`per_agent`: every tally of it names a receiver."""

    name: str
    by: tuple[str, ...] = ()
    per_agent: bool


class Measure(Node):
    name: str
    mean: bool
    value: Expr


class Label(Node):
    """Of `show ... as`: the first whose condition holds; the last has none."""

    name: str
    condition: Expr | None


class Sight(Node):
    """Something seen. `what`: `cell` (field of `kind` at each cell), `own`, `other`, `world` (fields), `heading` (others').

    `word`: one entry of a `by` field. `labels`: replaces the field's words. `hidden_when`: condition over `agent` (the
    observer) and the kind's cell or `other`; hidden shows as the kind alone, 0 for a number, or no heading.
    """

    what: Literal["cell", "own", "other", "world", "heading"]
    kind: str = ""
    field: str = ""
    word: str | None = None
    type: Type
    labels: tuple[Label, ...] = ()
    hidden_when: Expr | None = None


class Window(Node):
    ahead: int
    behind: int
    left: int
    right: int


class Check(Node):
    """A promise. `values` are its expressions in the order written."""

    sort: Literal["require", "always", "once", "conserved", "monotone", "symmetric", "expect"]
    values: tuple[Expr, ...] = ()
    words: tuple[str, ...] = ()
    policies: tuple[Policy, ...] = ()
    episodes: int = 0


class Policy(Node):
    """`random`; `never` the action numbers; `seek` the nearest member of the domain."""

    name: Literal["random", "never", "seek"]
    actions: tuple[int, ...] = ()
    domain: Domain | None = None


class Game(Node):
    """A whole game, one variant of it: what the passes rewrite, the interpreter runs and the lowering reads."""

    name: str
    title: str
    cites: tuple[str, ...] = ()
    variants: tuple[str, ...] = ()
    sizes: tuple[Size, ...] = ()
    params: tuple[Param, ...] = ()
    episode: Expr
    kinds: tuple[Kind, ...]
    groups: tuple[tuple[str, tuple[str, ...]], ...] = ()
    rows: tuple[str, ...]
    glyphs: tuple[GlyphMeaning, ...]
    fields: tuple[VarField, ...] = ()
    agents: Agents
    shapes: tuple[Shape, ...] = ()
    start: Phase
    schedule: tuple[Turn, ...]
    window: Window
    sights: tuple[Sight, ...] = ()
    events: tuple[Event, ...] = ()
    measures: tuple[Measure, ...] = ()
    checks: tuple[Check, ...] = ()


def children(node: Node) -> Iterator[Node]:
    """Yields the nodes directly inside `node`, in field order."""
    for name in type(node).model_fields:
        yield from _nodes(getattr(node, name))


def walk(node: Node) -> Iterator[Node]:
    """Yields `node` and every node below it, outermost first."""
    yield node
    for child in children(node):
        yield from walk(child)


def _nodes(value: object) -> Iterator[Node]:
    if isinstance(value, Node):
        yield value
    elif isinstance(value, tuple):
        for item in value:
            yield from _nodes(item)
