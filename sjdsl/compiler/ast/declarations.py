"""The abstract syntax tree: declarations, and the file they make up."""

from typing import Literal

from sjdsl.compiler.ast.expressions import (
    By,
    Call,
    Chosen,
    Domain,
    Expr,
    Name,
    Named,
    On,
    Path,
    ShapeRef,
    String,
    Table,
    Type,
)
from sjdsl.compiler.ast.node import Node
from sjdsl.compiler.ast.statements import Block


class Guard(Node):
    """`when C`, or `when on KIND as x where C`"""

    on: On | None
    condition: Expr | None


class Act(Node):
    """`GUARD choose ACTION`"""

    guard: Guard
    action: Chosen


class Go(Node):
    """`GUARD seek D avoiding E`"""

    guard: Guard | None
    domain: Domain
    avoided: Domain | None


class Aim(Node):
    """`GUARD aim SHAPE at D avoiding E choose ACTION`"""

    guard: Guard | None
    shape: ShapeRef
    domain: Domain
    avoided: Domain | None
    action: Chosen


class ScriptedPolicy(Named):
    """`policy cooperator "…" { … }`: the first rule that applies acts"""

    title: String | None
    rules: tuple[Act | Go | Aim, ...]


class Slots(Node):
    """`slots 2 focal`, or `slots 5 policy defector`"""

    number: Expr
    policy: Name | None


class Scenario(Named):
    title: String | None
    slots: tuple[Slots, ...]


class Constant(Node):
    """`size` or `param`.

    `param apple : reward = 1 in 0 .. 5`, `param taste by agent : reward = 1`.
    """

    name: Name
    by: By | None
    unit: Name
    value: Expr | Table
    low: Expr | None
    high: Expr | None
    is_size: bool = False


class Cite(Node):
    text: String


class About(Named):
    """A line of metadata; its texts are read one after the other."""

    texts: tuple[String, ...]


class Trials(Node):
    """The steps of each trial, and the fields that are kept from one to the next."""

    steps: Expr
    kept: tuple[Path, ...]


class Episode(Node):
    """length: steps, or the number of trials."""

    length: Expr
    trials: Trials | None


class TaskField(Named):
    """different: no two entries of the row are equal."""

    by: By | None
    different: bool
    type: Type


class Task(Named):
    fields: tuple[TaskField, ...]


class TrainOn(Node):
    """How many tasks there are to learn from, and the number that they are drawn from."""

    number: Expr
    task: Name
    seed: Expr


class HoldOut(Named):
    """A condition that holds in no task to learn from."""

    task: Name
    condition: Expr


class Field(Named):
    """start None: the type's default (0, nobody) or, for words, an error."""

    by: By | None
    type: Type
    start: Expr | None


class Timer(Named):
    """`timer digesting`"""

    by: By | None


class Blocks(Node):
    what: tuple[Name, ...]
    condition: Expr | None


class Glyph(Node):
    """`glyph "F" with state = dirty`"""

    glyph: String
    starts: tuple[tuple[Name, Expr], ...]


class Kind(Named):
    glyph: String
    attributes: tuple[Field | Timer | Blocks | Glyph, ...]


class Group(Named):
    kinds: tuple[Name, ...]


class Map(Node):
    """rows for an inline map, file for `map "maps/x.txt"`; edges: `joined` for `map wraps …`."""

    file: String | None
    rows: tuple[String, ...]
    edges: Literal["joined"] | None = None


class Argument(Node):
    """Of an action: `agent`, `{ red, green }`, `apples : 0 .. 2`"""

    name: Name | None
    type: Type


class Action(Named):
    """`zap`, `vote(agent)`"""

    arguments: tuple[Argument, ...]


class Acts(Node):
    actions: tuple[Action, ...]


class Moves(Node):
    frame: Name


class Forbid(Node):
    """actions empty: all"""

    actions: tuple[Chosen, ...]
    condition: Expr


class Agents(Node):
    number: Expr | None
    attributes: tuple[Acts | Moves | Field | Timer | Forbid | Blocks, ...]


class Movers(Named):
    """`movers deer 4 "d" { timer resting }`"""

    number: Expr
    glyph: String
    attributes: tuple[Field | Timer, ...]


class Shape(Named):
    """A picture (rows) or a call."""

    rows: tuple[String, ...]
    call: Call | None


class Define(Named):
    parameters: tuple[Name, ...]
    value: Expr


class Turn(Named):
    """One place of the schedule: `sprout(red)`"""

    arguments: tuple[Expr, ...]


class Schedule(Node):
    turns: tuple[Turn, ...]


class Phase(Named):
    """at: `start`, of a phase that is played when an episode begins."""

    parameters: tuple[Name, ...]
    at: Name | None
    block: Block


class Window(Node):
    """`window ahead 9, behind 1, left 5, right 5`.

    With a condition, the window of those for whom it holds.
    """

    sides: tuple[tuple[Name, Expr], ...]
    condition: Expr | None


class Relabel(Node):
    label: Name
    where: Expr | None


class Show(Node):
    """`observer`: of `show define(agent)`."""

    what: Path
    observer: Name | None
    labels: tuple[Relabel, ...]
    condition: Expr | None


class ShowEvent(Node):
    name: Name


class Hide(Node):
    """`on`: a kind, a group or `agents`: only there."""

    what: Path
    on: Name | None
    condition: Expr | None


class Observe(Node):
    observables: tuple[Window | Show | ShowEvent | Hide, ...]


class Paint(Node):
    """A colour, a sprite, or both, in any order: `red apple`, `"#2e7d32"`"""

    words: tuple[Name | String, ...]


class Look(Node):
    """`look tree where tree.fruit is ripe as green tree with red apple`"""

    what: Name
    where: Expr | None
    body: Paint | None
    badge: Paint | None


class Event(Named):
    by: By | None


class Measure(Node):
    """`mean` or `final`"""

    is_mean: bool
    name: Name
    value: Expr


class Metrics(Node):
    metrics: tuple[Event | Measure, ...]


class Require(Node):
    condition: Expr


class Always(Node):
    condition: Expr


class Once(Node):
    trigger: Expr
    condition: Expr


class Conserved(Node):
    value: Expr


class Monotone(Node):
    """`monotone growth falling in dirt`"""

    value: Name
    direction: Name
    argument: Name


class Symmetric(Node):
    what: Name


class Policy(Named):
    """Of `expect`: `random`, `never(clean)`, `seek D`, or the name of a scripted policy"""

    actions: tuple[Name, ...]
    domain: Domain | None


class Expect(Node):
    condition: Expr
    policies: tuple[Policy, ...]
    episodes: int


Check = Require | Always | Once | Conserved | Monotone | Symmetric | Expect


class Checks(Node):
    """`checks { … }`, or `checks dilemma { … }`: a block with a name can be replaced and dropped"""

    name: Name | None
    checks: tuple[Check, ...]


class Override(Node):
    """`set regrow_1 = 0.0025` in a variant"""

    path: Path
    value: Expr | Table


class Drop(Named):
    """`drop beans`"""


class Variant(Named):
    title: String | None
    changes: "tuple[Section | Override | Drop, ...]"


Section = (
    Cite | About | Constant | Episode | Task | TrainOn | HoldOut | Kind | Group | Field | Timer | Map | Agents | Movers | Shape | Define | Schedule | Phase | Observe
    | Look | Metrics | Checks | ScriptedPolicy | Scenario | Variant
)  # fmt: skip


class Game(Named):
    title: String | None
    extends: String | None
    sections: tuple[Section, ...]


class File(Node):
    version: int
    game: Game
