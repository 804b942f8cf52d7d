"""The tree of one file as written: a frozen dataclass for each grammar rule, `span` first, no meaning yet.

Expressions and sentences have files of their own; `ast.X` finds all of them.
"""

from dataclasses import dataclass

from sjdsl.compiler.ast_expressions import *
from sjdsl.compiler.ast_expressions import Call, Expr, Name, Path, String, Table, Type, Words
from sjdsl.compiler.ast_sentences import *
from sjdsl.compiler.ast_sentences import Block, Domain
from sjdsl.compiler.source import Span


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
class About:
    """A line of metadata; its texts are read one after the other."""

    span: Span
    name: Name
    texts: tuple[String, ...]


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
    """`checks { … }`, or `checks dilemma { … }`: a block with a name can be replaced and dropped"""

    span: Span
    name: Name | None
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
    | About
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
