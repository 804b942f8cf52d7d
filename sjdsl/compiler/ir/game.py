"""The typed IR: declarations, the schedule, and the game they make up."""

from math import prod
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias

from sjdsl.compiler.ir.entity_types import AGENTS, EntityType, Entry, IndexSet
from sjdsl.compiler.ir.expressions import Domain, Expr, Given, Member, Shape
from sjdsl.compiler.ir.node import INSTANCE, Node, PolicyRuleNode, TurnNode, Type
from sjdsl.compiler.ir.statements import Stmt

if TYPE_CHECKING:  # as `Expr` in expressions.py
    Turn: TypeAlias = "Phase | Tick"
    PolicyRule: TypeAlias = "Act | Go | Aim"
else:
    Turn = Annotated[TurnNode, INSTANCE]
    PolicyRule = Annotated[PolicyRuleNode, INSTANCE]


class Size(Node):
    name: str
    type: Type
    value: int | float | tuple[Any, ...]


class Param(Node):
    """Default `value` nested as `type.by`; words for a word parameter.

    `type.low` .. `type.high` are its limits.
    """

    name: str
    type: Type
    value: int | float | str | tuple[Any, ...]


class VarField(Node):
    """A variable of each cell of a kind, each agent, each mover of a sort, or the world.

    `start`: number, word, or None for nobody.
    """

    name: str
    held_by: Annotated[EntityType, INSTANCE]
    type: Type
    capped: bool = False
    timer: bool = False
    start: int | float | str | None = None


class Block(Node):
    """`what`: `agents`, a sort of movers or a shape's name.

    The condition reads the cell (Member `kind`) and `agent` (who moves, or the anchor).

    For a sort of movers it reads the mover, by the name of the sort, instead. Of agents that end
    the lanes of a shape it reads Member `agent`, who stands in the way.
    """

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
    starts: tuple[tuple[str, int | float | str | None], ...] = ()


class ActionArgument(Node):
    """One argument of an action. `name` may be empty.

    count: of values, in the order of the agents, the words or the numbers of its type.
    """

    name: str = ""
    type: Type
    count: int


class ActionWithArguments(Node):
    """An action with arguments.

    One action of its own for each choice of values, from number `first`, the last argument varying
    fastest.
    """

    name: str
    first: int
    arguments: tuple[ActionArgument, ...]

    @property
    def numbers(self) -> range:
        """The numbers of its actions."""
        return range(self.first, self.first + prod(argument.count for argument in self.arguments))


class Forbid(Node):
    """`actions` are numbers; the condition reads `agent`.

    `names`: if the actions are those of one action with arguments, `action`, the names (or empty
    ones) by which the condition reads these.
    """

    actions: tuple[int, ...]
    condition: Expr
    action: str = ""
    names: tuple[str, ...] = ()


class Agents(Node):
    """The agents: their number, actions and fields, and what they may not do.

    actions: their names by their numbers, `vote(0)` one of them; with_arguments: those that have
    arguments, `vote` one of them.
    """

    number: int
    actions: tuple[str, ...]
    relative: bool
    fields: tuple[VarField, ...] = ()
    forbids: tuple[Forbid, ...] = ()
    blocks: tuple[Block, ...] = ()
    with_arguments: tuple[ActionWithArguments, ...] = ()


class Movers(Node):
    """A sort of movers: things that occupy cells and move by rules.

    `glyph`: in pictures. The first of its fields is `heading`.
    """

    name: str
    number: int
    glyph: str
    fields: tuple[VarField, ...] = ()

    @property
    def entity_type(self) -> EntityType:
        return EntityType("mover", (self.name,))


class Phase(TurnNode):
    """One use of a phase.

    `label` as in the schedule (`sprout(red)`); `name` a Python identifier, unique in the game.

    `marks`: the shapes it marks as written. What an observation has in it follows from these: no
    map and no pass changes it.
    """

    label: str
    name: str
    body: tuple[Stmt, ...]
    marks: tuple[str, ...] = ()


class Tick(TurnNode):
    """All timers fall by one, agents whose time away is over return."""


class Event(Node):
    """`per_agent`: every tally of it names a receiver. `shown`: a field of its name, of agents or the world, holds the count of the last step, 255 at most."""

    name: str
    by: Annotated[IndexSet, INSTANCE] | None = None
    per_agent: bool
    shown: bool = False


class Measure(Node):
    name: str
    mean: bool
    value: Expr


class Label(Node):
    """Of `show ... as`: the first whose condition holds; the last has none."""

    name: str
    condition: Expr | None


class Observable(Node):
    """Something seen.

    what: `cell` (field of `kind` at each cell), `own`, `other`, `everyone`, `world` (fields),
      `heading` (others'), or `mover`: the movers of the sort `kind` at each cell, whether there is
      one (no field) or a field of it; `heading` relative to the observer's.
    field: of agents, it may be an attribute (`row`, `heading`). A `cell` without a field is the
      whole look of the kind: its labels are looks, those of other kinds by their names. Of
      `everyone`, there is one plane an agent in the order of their numbers, the same in the whole
      window.
    word: one entry of a `by` field. labels: replaces the field's words.
    hidden_when: condition over `agent` (the observer) and the kind's cell or `other`; hidden shows
      as the kind alone, or 0 for a number. shown_when: where it does not hold, a word is `hidden`,
      a number 0.
    value: what is shown in place of a field of the world or of the observer, `step` or a define, by
      the name `field`.
    """

    what: Literal["cell", "own", "other", "mover", "everyone", "world", "heading"]
    kind: str = ""
    field: str = ""
    word: Annotated[Entry, INSTANCE] | None = None
    type: Type
    value: Expr | None = None
    labels: tuple[Label, ...] = ()
    hidden_when: Expr | None = None
    shown_when: Expr | None = None

    @property
    def entity_type(self) -> EntityType:
        """The sort of what is seen."""
        match self.what:
            case "cell" | "mover":
                return EntityType(self.what, (self.kind,))
            case "world":
                return EntityType("world")
            case _:
                return AGENTS

    @property
    def owner(self) -> Member | None:
        """What is seen, by the name that its conditions give it; None for the world."""
        name = "agent" if self.what == "own" else self.kind or self.what
        return None if self.what == "world" else Member(name=name, entity_type=self.entity_type)


class Paint(Node):
    """How something is drawn; a part that is not said is empty.

    colour: a name of `looks.COLOURS` or `#rrggbb`; sprite: one of `looks.SPRITES`.
    """

    colour: str = ""
    sprite: str = ""


class Look(Node):
    """How cells of some kinds, the agents, or movers are drawn; no rule reads it.

    It applies where the condition over Member `name` holds.

    `kinds`: of cells, or the one sort of movers. `body`: the cell, agent or mover itself; `badge`:
    a small sprite in its corner.
    """

    what: Literal["cell", "agent", "mover"]
    name: str
    kinds: tuple[str, ...] = ()
    condition: Expr | None = None
    body: Paint | None = None
    badge: Paint | None = None


class Hidden(Node):
    """What is not seen of some cells: their marks, what they are (then they look `covered`).

    `on`: on the whole map, on cells of `kinds` (while `when` holds of agent, the observer, and the
    cell `name`), or where an agent stands.
    """

    what: Literal["marks", "content"]
    on: Literal["map", "cells", "agents"]
    name: str = ""
    kinds: tuple[str, ...] = ()
    when: Expr | None = None


class View(Node):
    """The window of the agents for whom the condition over Member `agent` holds.

    The last of a game has none.
    """

    ahead: int
    behind: int
    left: int
    right: int
    condition: Expr | None = None


class Window(Node):
    """What an observation covers.

    `views`: if not all see so far, their windows; the first whose condition holds is an agent's
    own.
    """

    ahead: int
    behind: int
    left: int
    right: int
    views: tuple[View, ...] = ()


class Check(Node):
    """A check. `values` are its expressions in the order written."""

    kind: Literal["require", "always", "once", "conserved", "monotone", "symmetric", "expect"]
    values: tuple[Expr, ...] = ()
    words: tuple[str, ...] = ()
    policies: tuple["Policy", ...] = ()
    episodes: int = 0


class Policy(Node):
    """A policy of an `expect`.

    It is `random`, `never` the action numbers, `seek` the nearest member of the domain, or
    `scripted`, the one of that name.
    """

    name: Literal["random", "never", "seek", "scripted"]
    actions: tuple[int, ...] = ()
    domain: Domain | None = None
    scripted: str = ""


class Act(PolicyRuleNode):
    """Take an action, by its number, where the condition over Member `agent`, who acts, holds.

    `on`: only on a cell of these kinds, which the rest of the rule knows by this name. `given`: of
    the action with arguments `chosen`, whose first number `action` is; its values are surely those
    of the argument.
    """

    on: Member | None = None
    condition: Expr
    action: int
    chosen: str = ""
    given: tuple[Given, ...] = ()


class Go(PolicyRuleNode):
    """Walk to the nearest member of the domain, through none of those avoided.

    Both may speak of `agent`. `on`, `condition`: as of Act.
    """

    on: Member | None = None
    condition: Expr | None = None
    domain: Domain
    avoided: Domain | None = None


class Aim(PolicyRuleNode):
    """Walk and turn until a member of the domain is in the shape, then take an action as `Act` does.

    shape: names one of the game's or its policies'.
    """

    on: Member | None = None
    condition: Expr | None = None
    shape: str
    domain: Domain
    avoided: Domain | None = None
    action: int
    chosen: str = ""
    given: tuple[Given, ...] = ()


class ScriptedPolicy(Node):
    """How an agent plays: the first rule that applies acts; it stays if none does."""

    name: str
    title: str = ""
    rules: tuple[PolicyRule, ...]


class Slots(Node):
    """So many agents of a scenario, and their policy.

    `random`, `stay` or one of the game's; empty for those that are evaluated.
    """

    number: int
    policy: str = ""


class Scenario(Node):
    """A line-up of agents that are evaluated (focal) and others that play fixed policies."""

    name: str
    title: str = ""
    slots: tuple[Slots, ...]


class Kept(Node):
    """A field of each cell of a kind, each agent, each mover of a name, or of the world."""

    held_by: Annotated[EntityType, INSTANCE]
    name: str


class Trials(Node):
    """An episode of several trials. Each begins as an episode does, but for what is kept.

    Kept are the field `trial` of the world, which counts them from 0, and `kept`.
    """

    number: int
    kept: tuple[Kept, ...] = ()


class TrainOn(Node):
    """Tasks to learn from: task i, from 0 to `number` - 1, is drawn from the key (`seed`, i).

    `candidates`: how many tasks are drawn, of which the first that is none of these is held out.
    """

    number: int
    seed: int
    candidates: int


class HoldOut(Node):
    """The tasks for which a condition holds: no task to learn from is one of them."""

    name: str
    condition: Expr


class TaskPart(Node):
    """One word or number of a task: a field of it, or the entry of a row at a place."""

    field: str
    place: int | None = None


class GivenPart(Node):
    """A part of a task that isn't drawn.

    `name`: as it is written, `pay[red]`. `value`: a word, or a number.
    """

    name: str
    part: TaskPart
    value: int | str


Side = Literal["all", "training", "held_out"]


class Task(Node):
    """Fields of the world that are drawn when an episode begins, before `start`, and written by no
    rule.

    `draw`: the phase that draws them. `train_on`, `hold_outs`: the splits of the file.
    `number_stream`, `row_stream`: of what a split draws: the number of a task, or the keys of
    candidates; a row of the table of the parts that conditions read.
    `side`, `split`: the tasks that are played. The split is the name of a `hold out`, or that of
    the task for `train on`. `given`: the parts that are fixed, whichever side is played.
    """

    name: str
    fields: tuple[str, ...]
    draw: Phase
    train_on: TrainOn | None = None
    hold_outs: tuple[HoldOut, ...] = ()
    number_stream: int = 0
    row_stream: int = 0
    side: Side = "all"
    split: str = ""
    given: tuple[GivenPart, ...] = ()

    @property
    def played(self) -> Side | dict[str, int | str]:
        """Which tasks are played, as the argument `tasks` of `sjdsl.make`."""
        if not self.given:
            return self.side
        return {given.name: given.value for given in self.given}


class Game(Node):
    """A whole game, one variant of it: what the interpreter runs and the lowering reads.

    `episode`: the steps of a trial, or of the episode in a game without trials. `chosen`: the
    variants applied, of all its `variants`. `starting`: the phases that follow `start` when a trial
    or an episode begins. `policy_shapes`: those that its policies speak of and no rule does.
    `edges`: of the map; those that are joined make it a torus.
    """

    name: str
    title: str
    cites: tuple[str, ...] = ()
    about: tuple[tuple[str, str], ...] = ()
    variants: tuple[str, ...] = ()
    chosen: tuple[str, ...] = ()
    sizes: tuple[Size, ...] = ()
    params: tuple[Param, ...] = ()
    episode: Expr
    trials: Trials | None = None
    task: Task | None = None
    kinds: tuple[Kind, ...]
    rows: tuple[str, ...]
    edges: Literal["", "joined"] = ""
    glyphs: tuple[GlyphMeaning, ...]
    fields: tuple[VarField, ...] = ()
    agents: Agents
    movers: tuple[Movers, ...] = ()
    shapes: tuple[Shape, ...] = ()
    start: Phase
    starting: tuple[Phase, ...] = ()
    schedule: tuple[Turn, ...]
    window: Window
    observables: tuple[Observable, ...] = ()
    hidden: tuple[Hidden, ...] = ()
    events: tuple[Event, ...] = ()
    measures: tuple[Measure, ...] = ()
    checks: tuple[Check, ...] = ()
    looks: tuple[Look, ...] = ()
    policies: tuple[ScriptedPolicy, ...] = ()
    policy_shapes: tuple[Shape, ...] = ()
    scenarios: tuple[Scenario, ...] = ()

    @property
    def wraps(self) -> bool:
        """Whether the map goes on at its other side."""
        return self.edges == "joined"

    @property
    def rules(self) -> "Game":
        """The game without the parts that no rule reads."""
        beside = ("cites", "about", "chosen", "looks", "policies", "policy_shapes", "scenarios")
        return self.changed(**dict.fromkeys(beside, ()))
