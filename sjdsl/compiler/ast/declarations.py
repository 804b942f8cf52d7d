"""The abstract syntax tree: declarations, and the file they make up."""

from typing import Literal

from sjdsl.compiler.ast.expressions import By, Call, Chosen, Domain, Expr, Name, Path, ShapeRef, String, Table, Type
from sjdsl.compiler.ast.node import Node
from sjdsl.compiler.ast.statements import Block
from sjdsl.compiler.diagnostics.source import Span


class Act(Node):
    """`when C choose ACTION`"""

    span: Span
    condition: Expr
    action: Chosen


class Go(Node):
    """`seek D avoiding E`"""

    span: Span
    domain: Domain
    avoided: Domain | None


class Aim(Node):
    """`aim SHAPE at D avoiding E choose ACTION`"""

    span: Span
    shape: ShapeRef
    domain: Domain
    avoided: Domain | None
    action: Chosen


class ScriptedPolicy(Node):
    """`policy cooperator "…" { … }`: the first rule that applies acts"""

    span: Span
    name: Name
    title: String | None
    rules: tuple[Act | Go | Aim, ...]


class Slots(Node):
    """`slots 2 focal`, or `slots 5 policy defector`"""

    span: Span
    number: Expr
    policy: Name | None


class Scenario(Node):
    span: Span
    name: Name
    title: String | None
    slots: tuple[Slots, ...]


class Constant(Node):
    """`size` or `param`: `param apple : reward = 1 in 0 .. 5`, `param taste by agent : reward = 1`"""

    span: Span
    is_size: bool
    name: Name
    by: By | None
    unit: Name
    value: Expr | Table
    low: Expr | None
    high: Expr | None


class Cite(Node):
    span: Span
    text: String


class About(Node):
    """A line of metadata; its texts are read one after the other."""

    span: Span
    name: Name
    texts: tuple[String, ...]


class Episode(Node):
    span: Span
    steps: Expr


class Field(Node):
    """start None: the type's default (0, nobody) or, for words, an error."""

    span: Span
    name: Name
    by: By | None
    type: Type
    start: Expr | None


class Timer(Node):
    span: Span
    name: Name


class Blocks(Node):
    span: Span
    what: tuple[Name, ...]
    condition: Expr | None


class Glyph(Node):
    """`glyph "F" with state = dirty`"""

    span: Span
    glyph: String
    starts: tuple[tuple[Name, Expr], ...]


class Kind(Node):
    span: Span
    name: Name
    glyph: String
    attributes: tuple[Field | Timer | Blocks | Glyph, ...]


class Group(Node):
    span: Span
    name: Name
    kinds: tuple[Name, ...]


class Map(Node):
    """rows for an inline map, file for `map "maps/x.txt"`; edges: `joined` for `map wraps …`."""

    span: Span
    file: String | None
    rows: tuple[String, ...]
    edges: Literal["joined"] | None = None


class Argument(Node):
    """Of an action: `agent`, `{ red, green }`, `apples : 0 .. 2`"""

    span: Span
    name: Name | None
    type: Type


class Action(Node):
    """`zap`, `vote(agent)`"""

    span: Span
    name: Name
    arguments: tuple[Argument, ...]


class Acts(Node):
    span: Span
    actions: tuple[Action, ...]


class Moves(Node):
    span: Span
    frame: Name


class Forbid(Node):
    """actions empty: all"""

    span: Span
    actions: tuple[Chosen, ...]
    condition: Expr


class Agents(Node):
    span: Span
    number: Expr | None
    attributes: tuple[Acts | Moves | Field | Timer | Forbid | Blocks, ...]


class Movers(Node):
    """`movers deer 4 "d" { timer resting }`"""

    span: Span
    name: Name
    number: Expr
    glyph: String
    attributes: tuple[Field | Timer, ...]


class Shape(Node):
    """A picture (rows) or a call."""

    span: Span
    name: Name
    rows: tuple[String, ...]
    call: Call | None


class Define(Node):
    span: Span
    name: Name
    parameters: tuple[Name, ...]
    value: Expr


class Turn(Node):
    """One place of the schedule: `sprout(red)`"""

    span: Span
    name: Name
    arguments: tuple[Expr, ...]


class Schedule(Node):
    span: Span
    turns: tuple[Turn, ...]


class Phase(Node):
    span: Span
    name: Name
    parameters: tuple[Name, ...]
    block: Block


class Window(Node):
    """`window ahead 9, behind 1, left 5, right 5`; with a condition, the window of those for whom it holds"""

    span: Span
    sides: tuple[tuple[Name, Expr], ...]
    condition: Expr | None


class Relabel(Node):
    span: Span
    label: Name
    where: Expr | None


class Show(Node):
    span: Span
    what: Path
    labels: tuple[Relabel, ...]
    condition: Expr | None


class Hide(Node):
    """`on`: a kind, a group or `agents`: only there."""

    span: Span
    what: Path
    on: Name | None
    condition: Expr | None


class Observe(Node):
    span: Span
    observables: tuple[Window | Show | Hide, ...]


class Paint(Node):
    """A colour, a sprite, or both, in any order: `red apple`, `"#2e7d32"`"""

    span: Span
    words: tuple[Name | String, ...]


class Look(Node):
    """`look tree where tree.fruit is ripe as green tree with red apple`"""

    span: Span
    what: Name
    where: Expr | None
    body: Paint | None
    badge: Paint | None


class Event(Node):
    span: Span
    name: Name
    by: By | None


class Measure(Node):
    """`mean` or `final`"""

    span: Span
    is_mean: bool
    name: Name
    value: Expr


class Metrics(Node):
    span: Span
    metrics: tuple[Event | Measure, ...]


class Require(Node):
    span: Span
    condition: Expr


class Always(Node):
    span: Span
    condition: Expr


class Once(Node):
    span: Span
    trigger: Expr
    condition: Expr


class Conserved(Node):
    span: Span
    value: Expr


class Monotone(Node):
    """`monotone growth falling in dirt`"""

    span: Span
    value: Name
    direction: Name
    argument: Name


class Symmetric(Node):
    span: Span
    what: Name


class Policy(Node):
    """Of `expect`: `random`, `never(clean)`, `seek D`, or the name of a scripted policy"""

    span: Span
    name: Name
    actions: tuple[Name, ...]
    domain: Domain | None


class Expect(Node):
    span: Span
    condition: Expr
    policies: tuple[Policy, ...]
    episodes: int


Check = Require | Always | Once | Conserved | Monotone | Symmetric | Expect


class Checks(Node):
    """`checks { … }`, or `checks dilemma { … }`: a block with a name can be replaced and dropped"""

    span: Span
    name: Name | None
    checks: tuple[Check, ...]


class Override(Node):
    """`set regrow_1 = 0.0025` in a variant"""

    span: Span
    path: Path
    value: Expr | Table


class Drop(Node):
    span: Span
    name: Name


class Variant(Node):
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
    | Movers
    | Shape
    | Define
    | Schedule
    | Phase
    | Observe
    | Look
    | Metrics
    | Checks
    | ScriptedPolicy
    | Scenario
    | Variant
)


class Game(Node):
    span: Span
    name: Name
    title: String | None
    extends: String | None
    sections: tuple[Section, ...]


class File(Node):
    span: Span
    version: int
    game: Game
