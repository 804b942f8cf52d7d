"""The typed IR: one game with every name resolved, every size a number, every phase use written out, every draw named.

Words and agents are values; numbers carry their unit and the interval they provably stay in. Variables are named as in
the text; an inner one never has the name of an outer one. All nodes are frozen and compare by content; `origin` is the
only part that two equal programs may differ in.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Annotated, Literal, get_args, get_origin

from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.ir.expressions import *
from sjdsl.compiler.ir.node import *
from sjdsl.compiler.ir.node import Expr, Node, Stmt, Turn, TurnNode, Type
from sjdsl.compiler.ir.statements import *
from sjdsl.compiler.ir.statements import Domain, Shape


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
    """One use of a phase. `label` as in the schedule (`sprout(red)`); `name` a Python identifier, unique in the game.

    `marks`: the shapes it marks as written. What an observation has in it follows from these: no map and no pass changes it.
    """

    op: Literal["phase"] = "phase"
    label: str
    name: str
    body: tuple[Stmt, ...]
    marks: tuple[str, ...] = ()


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
    """Something seen. `what`: `cell` (field of `kind` at each cell), `own`, `other`, `everyone`, `world` (fields), `heading` (others').

    A `cell` without a field is the whole look of the kind: its labels are looks, those of other kinds by their names.
    `everyone`: the field of each agent, one plane an agent in the order of their numbers, the same in the whole window.
    `word`: one entry of a `by` field. `labels`: replaces the field's words. `hidden_when`: condition over `agent` (the
    observer) and the kind's cell or `other`; hidden shows as the kind alone, 0 for a number, or no heading.
    """

    what: Literal["cell", "own", "other", "everyone", "world", "heading"]
    kind: str = ""
    field: str = ""
    word: str | None = None
    type: Type
    labels: tuple[Label, ...] = ()
    hidden_when: Expr | None = None


class Paint(Node):
    """`colour`: a name of `looks.COLOURS` or `#rrggbb`; `sprite`: one of `looks.SPRITES`; empty for one that is not said."""

    colour: str = ""
    sprite: str = ""


class Look(Node):
    """How cells of some kinds, or the agents, are drawn where the condition over Member `name` holds; no rule reads it.

    `body`: the cell or the agent itself; `badge`: a small sprite in its corner.
    """

    what: Literal["cell", "agent"]
    name: str
    kinds: tuple[str, ...] = ()
    condition: Expr | None = None
    body: Paint | None = None
    badge: Paint | None = None


class Hidden(Node):
    """What is not seen of some cells: their marks, or what they are (then they look `covered`).

    `on`: on the whole map, on cells of `kinds` (while `when` holds of agent, the observer, and the cell `name`), or where an agent stands.
    """

    what: Literal["marks", "content"]
    on: Literal["map", "cells", "agents"]
    name: str = ""
    kinds: tuple[str, ...] = ()
    when: Expr | None = None


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
    about: tuple[tuple[str, str], ...] = ()
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
    hidden: tuple[Hidden, ...] = ()
    events: tuple[Event, ...] = ()
    measures: tuple[Measure, ...] = ()
    checks: tuple[Check, ...] = ()
    looks: tuple[Look, ...] = ()


def children(node: Node) -> list[Node]:
    """Returns the nodes directly inside `node`, in field order."""
    found: list[Node] = []
    for name in inner_fields(type(node)):
        _gather(getattr(node, name), found)
    return found


def walk(node: Node) -> Iterator[Node]:
    """Yields `node` and every node below it, outermost first."""
    waiting = [node]
    while waiting:
        following = waiting.pop()
        yield following
        waiting += reversed(children(following))


def _gather(value: object, found: list[Node]) -> None:
    if isinstance(value, tuple):
        for item in value:
            _gather(item, found)
    elif isinstance(value, Node):
        found.append(value)


@cache
def inner_fields(kind: type[Node]) -> tuple[str, ...]:
    """Returns the fields that can hold nodes: most hold names and numbers, and a game is walked often."""
    return tuple(name for name, field in kind.model_fields.items() if _can_hold_nodes(field.annotation))


def _can_hold_nodes(annotation: object) -> bool:
    if get_origin(annotation) is Literal:
        return False
    if get_origin(annotation) is Annotated:
        return _can_hold_nodes(get_args(annotation)[0])
    inside = [a for a in get_args(annotation) if a is not Ellipsis]
    return any(_can_hold_nodes(a) for a in inside) if inside else annotation not in (str, int, float, bool, type(None), Span)
