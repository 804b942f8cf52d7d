"""The tree of one file as written: a frozen dataclass for each grammar rule, `span` first, no meaning yet."""

from dataclasses import dataclass

from sjdsl.compiler.source import Span

# ---- names and types


@dataclass(frozen=True)
class Name:
    span: Span
    text: str


@dataclass(frozen=True)
class String:
    span: Span
    text: str


@dataclass(frozen=True)
class Words:
    """`{ none, ripe }`"""

    span: Span
    names: tuple[Name, ...]


@dataclass(frozen=True)
class Range:
    """`0 .. cap capped`"""

    span: Span
    low: "Expr"
    high: "Expr"
    capped: bool


@dataclass(frozen=True)
class NamedType:
    """`agent`, `set of agent`, `reward`"""

    span: Span
    set_of: bool
    name: Name


Type = Words | Range | NamedType


# ---- expressions


@dataclass(frozen=True)
class Int:
    span: Span
    value: int


@dataclass(frozen=True)
class Decimal:
    span: Span
    value: float


@dataclass(frozen=True)
class Nobody:
    span: Span


@dataclass(frozen=True)
class Path:
    """`a.bag[raw]`: a name, then members and indices in order."""

    span: Span
    name: Name
    steps: "tuple[Member | Index, ...]"


@dataclass(frozen=True)
class Member:
    span: Span
    name: Name


@dataclass(frozen=True)
class Index:
    span: Span
    key: "Expr"


@dataclass(frozen=True)
class Call:
    """`ramp(x, zero_at, one_at)`, `ready(row)`, `disc(2)`"""

    span: Span
    name: Name
    arguments: "tuple[Expr, ...]"


@dataclass(frozen=True)
class Count:
    span: Span
    domain: "Domain"


@dataclass(frozen=True)
class Total:
    """`sum(row)` or `sum(e over D)`"""

    span: Span
    value: "Expr"
    domain: "Domain | None"


@dataclass(frozen=True)
class Case:
    span: Span
    subject: "Expr"
    arms: "tuple[Arm, ...]"


@dataclass(frozen=True)
class Arm:
    """`3..: e` has low 3, high None, open True; `otherwise: e` has word None and low None."""

    span: Span
    low: int | None
    high: int | None
    open: bool
    word: Name | None
    value: "Expr"


@dataclass(frozen=True)
class Unary:
    """op: `+`, `-`, `not`"""

    span: Span
    op: str
    operand: "Expr"


@dataclass(frozen=True)
class Binary:
    """op: `+ - * / %`, `<= >= == != < >`, `and`, `or`, `is`, `is not`"""

    span: Span
    op: str
    left: "Expr"
    right: "Expr"


@dataclass(frozen=True)
class Chose:
    """`zapper chose zap`"""

    span: Span
    agent: "Expr"
    action: Name


@dataclass(frozen=True)
class Standing:
    """`nobody on soil`, `agent on grass`"""

    span: Span
    who: "Expr"
    kind: Name


@dataclass(frozen=True)
class Within:
    """`x in set`; `x in { a, b }` has words; `x in low .. high` has high."""

    span: Span
    value: "Expr"
    container: "Expr | Words"
    high: "Expr | None"


Expr = Int | Decimal | Nobody | Path | Call | Count | Total | Case | Unary | Binary | Chose | Standing | Within


@dataclass(frozen=True)
class Table:
    """`{ red: 0.25, green: 0.4 }`; values may be tables."""

    span: Span
    entries: "tuple[Entry, ...]"


@dataclass(frozen=True)
class Entry:
    span: Span
    key: Name
    value: "Expr | Table"


# ---- who


@dataclass(frozen=True)
class ShapeRef:
    """`beam` or `disc(2)`; arguments None for a named shape."""

    span: Span
    name: Name
    arguments: tuple[Expr, ...] | None


@dataclass(frozen=True)
class Near:
    """`in beam of cleaner`"""

    span: Span
    shape: ShapeRef
    anchor: Name


@dataclass(frozen=True)
class Members:
    """`in { row, column }`"""

    span: Span
    names: tuple[Name, ...]


@dataclass(frozen=True)
class On:
    span: Span
    kind: Name
    bind: Name | None


@dataclass(frozen=True)
class Domain:
    """`KIND as x on KIND as y in PLACE where c`"""

    span: Span
    kind: Name
    bind: Name | None
    on: On | None
    place: "Near | Path | Members | None"
    where: Expr | None


# ---- sentences


@dataclass(frozen=True)
class Block:
    span: Span
    statements: "tuple[Stmt, ...]"


@dataclass(frozen=True)
class Let:
    span: Span
    name: Name
    value: Expr


@dataclass(frozen=True)
class Draw:
    """`from a .. b` has high; `from { w, w }` has Words; `from { w: p }` has Table."""

    span: Span
    name: Name
    source: "Expr | Words | Table"
    high: Expr | None


@dataclass(frozen=True)
class Each:
    span: Span
    domain: Domain
    block: Block


@dataclass(frozen=True)
class Pick:
    span: Span
    number: Expr
    domain: Domain
    block: Block
    otherwise: "Otherwise | None"


@dataclass(frozen=True)
class First:
    span: Span
    domain: Domain
    block: Block
    otherwise: "Otherwise | None"


@dataclass(frozen=True)
class Match:
    span: Span
    left: Domain
    first: bool
    right: Domain
    block: Block


@dataclass(frozen=True)
class When:
    span: Span
    condition: Expr
    block: Block
    otherwise: "Otherwise | None"


@dataclass(frozen=True)
class Chance:
    span: Span
    probability: Expr
    block: Block
    otherwise: "Otherwise | None"


Otherwise = Block | When | Chance


@dataclass(frozen=True)
class Set:
    span: Span
    target: Path
    value: Expr


@dataclass(frozen=True)
class Add:
    span: Span
    value: Expr
    target: Path


@dataclass(frozen=True)
class All:
    """`all`, or `all but x`"""

    span: Span
    but: Name | None


@dataclass(frozen=True)
class Give:
    span: Span
    value: Expr
    receiver: Path | All


@dataclass(frozen=True)
class Tally:
    span: Span
    event: Path
    by: Expr | None
    receiver: Path | None


@dataclass(frozen=True)
class Send:
    """stay: the name after `otherwise` (must be `stay`)."""

    span: Span
    who: Path
    domain: Domain
    after: Expr | None
    facing: Name | None
    stay: Name | None


@dataclass(frozen=True)
class Remove:
    span: Span
    who: Path


@dataclass(frozen=True)
class Move:
    span: Span
    domain: Domain


@dataclass(frozen=True)
class Mark:
    span: Span
    shape: ShapeRef
    anchor: Name


@dataclass(frozen=True)
class End:
    span: Span


Stmt = (
    Let
    | Draw
    | Each
    | Pick
    | First
    | Match
    | When
    | Chance
    | Set
    | Add
    | Give
    | Tally
    | Send
    | Remove
    | Move
    | Mark
    | End
)


# ---- declarations


@dataclass(frozen=True)
class Constant:
    """`size` or `param`: `param apple : reward = 1 in 0 .. 5`"""

    span: Span
    is_size: bool
    name: Name
    unit: Name
    value: Expr | Table
    low: Expr | None
    high: Expr | None


@dataclass(frozen=True)
class Cite:
    span: Span
    text: String


@dataclass(frozen=True)
class Episode:
    span: Span
    steps: Expr


@dataclass(frozen=True)
class Field:
    """start None: the type's default (0, nobody) or, for words, an error."""

    span: Span
    name: Name
    by: Words | None
    type: Type
    start: Expr | None


@dataclass(frozen=True)
class Timer:
    span: Span
    name: Name


@dataclass(frozen=True)
class Blocks:
    span: Span
    what: tuple[Name, ...]
    condition: Expr | None


@dataclass(frozen=True)
class Glyph:
    """`glyph "F" with state = dirty`"""

    span: Span
    glyph: String
    starts: tuple[tuple[Name, Expr], ...]


@dataclass(frozen=True)
class Kind:
    span: Span
    name: Name
    glyph: String
    attributes: tuple[Field | Timer | Blocks | Glyph, ...]


@dataclass(frozen=True)
class Group:
    span: Span
    name: Name
    kinds: tuple[Name, ...]


@dataclass(frozen=True)
class Map:
    """rows for an inline map, file for `map "maps/x.txt"`."""

    span: Span
    file: String | None
    rows: tuple[String, ...]


@dataclass(frozen=True)
class Acts:
    span: Span
    actions: tuple[Name, ...]


@dataclass(frozen=True)
class Moves:
    span: Span
    frame: Name


@dataclass(frozen=True)
class Forbid:
    """actions empty: all"""

    span: Span
    actions: tuple[Name, ...]
    condition: Expr


@dataclass(frozen=True)
class Agents:
    span: Span
    number: Expr | None
    attributes: tuple[Acts | Moves | Field | Timer | Forbid, ...]


@dataclass(frozen=True)
class Shape:
    """A picture (rows) or a call."""

    span: Span
    name: Name
    rows: tuple[String, ...]
    call: Call | None


@dataclass(frozen=True)
class Define:
    span: Span
    name: Name
    parameters: tuple[Name, ...]
    value: Expr


@dataclass(frozen=True)
class Turn:
    """One place of the schedule: `sprout(red)`"""

    span: Span
    name: Name
    arguments: tuple[Expr, ...]


@dataclass(frozen=True)
class Schedule:
    span: Span
    turns: tuple[Turn, ...]


@dataclass(frozen=True)
class Phase:
    span: Span
    name: Name
    parameters: tuple[Name, ...]
    block: Block


@dataclass(frozen=True)
class Window:
    """`window ahead 9, behind 1, left 5, right 5`"""

    span: Span
    sides: tuple[tuple[Name, Expr], ...]


@dataclass(frozen=True)
class Relabel:
    span: Span
    label: Name
    where: Expr | None


@dataclass(frozen=True)
class Show:
    span: Span
    what: Path
    labels: tuple[Relabel, ...]


@dataclass(frozen=True)
class Hide:
    span: Span
    what: Path
    condition: Expr | None


@dataclass(frozen=True)
class Observe:
    span: Span
    sights: tuple[Window | Show | Hide, ...]


@dataclass(frozen=True)
class Event:
    span: Span
    name: Name
    by: Words | None


@dataclass(frozen=True)
class Measure:
    """`mean` or `final`"""

    span: Span
    is_mean: bool
    name: Name
    value: Expr


@dataclass(frozen=True)
class Metrics:
    span: Span
    metrics: tuple[Event | Measure, ...]


@dataclass(frozen=True)
class Require:
    span: Span
    condition: Expr


@dataclass(frozen=True)
class Always:
    span: Span
    condition: Expr


@dataclass(frozen=True)
class Once:
    span: Span
    trigger: Expr
    condition: Expr


@dataclass(frozen=True)
class Conserved:
    span: Span
    value: Expr


@dataclass(frozen=True)
class Monotone:
    """`monotone growth falling in dirt`"""

    span: Span
    value: Name
    direction: Name
    argument: Name


@dataclass(frozen=True)
class Symmetric:
    span: Span
    what: Name


@dataclass(frozen=True)
class Policy:
    """`random`, `never(clean)`, `seek D`"""

    span: Span
    name: Name
    actions: tuple[Name, ...]
    domain: Domain | None


@dataclass(frozen=True)
class Expect:
    span: Span
    condition: Expr
    policies: tuple[Policy, ...]
    episodes: int


Check = Require | Always | Once | Conserved | Monotone | Symmetric | Expect


@dataclass(frozen=True)
class Checks:
    span: Span
    checks: tuple[Check, ...]


@dataclass(frozen=True)
class Override:
    """`set regrow_1 = 0.0025` in a variant"""

    span: Span
    path: Path
    value: Expr | Table


@dataclass(frozen=True)
class Drop:
    span: Span
    name: Name


@dataclass(frozen=True)
class Variant:
    span: Span
    name: Name
    title: String | None
    changes: "tuple[Section | Override | Drop, ...]"


Section = (
    Cite
    | Constant
    | Episode
    | Kind
    | Group
    | Field
    | Timer
    | Map
    | Agents
    | Shape
    | Define
    | Schedule
    | Phase
    | Observe
    | Metrics
    | Checks
    | Variant
)


@dataclass(frozen=True)
class Game:
    span: Span
    name: Name
    title: String | None
    extends: String | None
    sections: tuple[Section, ...]


@dataclass(frozen=True)
class File:
    span: Span
    version: int
    game: Game
