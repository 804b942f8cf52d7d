"""The writer: collects the names, constants and statements of a module while it is lowered."""

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import ceil

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.compiler.diagnostics.tree import walk
from sjdsl.compiler.ir.entity_types import AGENTS
from sjdsl.compiler.ir.names import RESERVED, Names, attribute_name, identifier
from sjdsl.compiler.ir.queries import (
    all_fields,
    body_type,
    body_types,
    can_be_away,
    declared_field,
    movers_named,
    shape_named,
    shows_attribute,
)
from sjdsl.compiler.lower.axes import Axis, Value, literal
from sjdsl.compiler.lower.deciding import Deciding, deciding
from sjdsl.compiler.lower.map_tables import Layout
from sjdsl.compiler.lower.scope import IterationScope, Variable
from sjdsl.compiler.program import Constant, Group, Number
from sjdsl.compiler.program.expressions import (
    Assign,
    Attribute,
    DType,
    Expression,
    Literal,
    Name,
    Return,
    Statement,
    as_array,
    call,
    path,
)
from sjdsl.runtime.actions import HEADINGS

FACTS = {
    "NAME", "TITLE", "HASH", "ACTIONS", "STAY", "NUM_AGENTS", "PAD", "FRAME", "WINDOW",
    "FORBIDS_ACTIONS", "ROLE", "EVENTS", "FIELDS", "NUM_TRIALS",
}  # fmt: skip
MODULE_NAMES = {*FACTS, "MAP", "TOKEN_PLANES"}
NOBODY = -1
BITS_PER_NUMBER = 32  # of a set of agents


class WordSet(Record):
    """What a set of words belongs to, and what declares it.

    owner: of the field that has it, or the name of the row, parameter, event or action.
    """

    owner: str
    declared: str


@dataclass
class Module:
    """What all functions of a module share.

    expression: `expressions.lower`, which `Writer.value` calls: `expressions` imports this module.
    sources: see `lower`. writer: the last one, whose statement is at fault where no other is known.
    """

    game: ir.Game
    layout: Layout
    expression: Callable[[ir.Expr, IterationScope, "Writer"], Value]
    sources: Mapping[str, Source] = field(default_factory=dict)
    constants: dict[str, Constant] = field(default_factory=dict)
    numbers: dict[str, Number] = field(default_factory=dict)
    names: Names = field(default_factory=lambda: Names(set(MODULE_NAMES)))
    writer: "Writer | None" = None
    _by_value: dict[Expression, str] = field(default_factory=dict)
    _by_meaning: dict[tuple[str, int], str] = field(default_factory=dict)

    def constant(self, name: str, table: object, comment: str, dtype: DType | None = None) -> Name:
        """Returns the name of a module-level array; equal ones are kept once.

        dtype: of a table of written numbers.
        """
        value = as_array(table, dtype)
        if value not in self._by_value:
            fresh = self.names.fresh(name.upper())
            self.constants[fresh] = Constant(fresh, value, comment)
            self._by_value[value] = fresh
        return Name(self._by_value[value])

    def number(self, name: str, value: int, comment: str = "", group: Group = "other") -> Literal:
        """Returns a number that generated code writes as a named constant: `NUM_WATER` for 124.

        The constant is declared at the top of the module if something reads it. comment: beside it.
        """
        key = (name.upper(), value)
        if key not in self._by_meaning:
            fresh = self.names.fresh(name.upper())
            self.numbers[fresh] = Number(fresh, value, comment, group)
            self._by_meaning[key] = fresh
        return Literal(value, self._by_meaning[key])

    def num_cells(self, kinds: tuple[str, ...]) -> Literal:
        """Returns how many cells of the kinds the map has."""
        name = f"num_{'_'.join(kinds)}"
        comment = f"cells of {', '.join(kinds)}"
        return self.number(name, self.layout.num_cells(kinds), comment, "size")

    def action(self, number: int) -> Literal:
        """Returns the number of an action."""
        action = self.game.agents.actions[number]
        name = "_".join(["action", *re.findall(r"\w+", action)])
        comment = f"is {action}" if "(" in action else ""
        return self.number(name, number, comment, "action")

    def first_action(self, action: ir.ActionWithArguments) -> Literal:
        """Returns the first number of an action with arguments."""
        comment = f"{self.game.agents.actions[action.first]}, the first of them"
        return self.number(f"action_{action.name}", action.first, comment, "action")

    def word(self, word: str, words: tuple[str, ...], declared: ir.VarField | None = None) -> Value:
        """Returns the number of a word in a set.

        declared: the field of which it is a value, after whose owner it is named.
        """
        number = words.index(word)
        owner = None
        if declared is not None and declared.type.words == words:
            owner = declared.held_by.name
        elif words in self._word_sets:
            owner = self._word_sets[words].owner
        if owner is None:
            return literal(number, "u8")
        return Value(self.number(f"{owner}_{word}".strip("_"), number, group="word"), "u8")

    def entry(self, entry: ir.Entry) -> Value:
        """Returns the place of an entry in its row."""
        if entry.index_set.kind == "word":
            return self.word(entry.name, entry.index_set.names)
        return literal(entry.place, "u8")

    def num_entries(self, index_set: ir.IndexSet) -> Literal:
        """Returns how many entries a row has."""
        if index_set.kind == "agent":
            return self.agents
        if index_set.names not in self._word_sets:  # of a draw alone
            return Literal(len(index_set))
        declared = self._word_sets[index_set.names].declared
        return self.number(f"num_{declared}", len(index_set), ", ".join(index_set.names), "size")

    @cached_property
    def _word_sets(self) -> dict[tuple[str, ...], WordSet]:
        """The sets of words and other keys, each with what declares it first."""
        game = self.game
        fields = all_fields(game)
        sets: dict[tuple[str, ...], WordSet] = {HEADINGS: WordSet("", "headings")}
        for declared in fields:
            words = WordSet(declared.held_by.name, attribute_name(declared))
            sets.setdefault(declared.type.words, words)

        def add(keys: tuple[str, ...], name: str) -> None:
            sets.setdefault(keys, WordSet(name, name))

        for declared in fields:
            for index_set in declared.type.indexed_by:
                add(index_set.names, attribute_name(declared))
        for param in game.params:
            add(param.type.words, param.name)
            for index_set in param.type.indexed_by:
                add(index_set.names, param.name)
        for event in game.events:
            if event.by is not None:
                add(event.by.names, event.name)
        for action in game.agents.with_arguments:
            for argument in action.arguments:
                add(argument.type.words, action.name)
        return sets

    @property
    def num_agents(self) -> int:
        return self.game.agents.number

    @property
    def agents(self) -> Literal:
        """How many agents there are."""
        return Literal(self.num_agents, "NUM_AGENTS")

    def extent(self, entity_type: ir.EntityType) -> Literal:
        """Returns how many agents, movers of a name or cells of some kinds there are."""
        match entity_type.what:
            case "agent":
                return self.agents
            case "mover":
                name = entity_type.name
                number = movers_named(self.game, name).number
                return self.number(f"num_{name}", number, f"movers {name}", "size")
            case "cell":
                return self.num_cells(entity_type.names)
            case "world":
                raise AssertionError(entity_type)

    @property
    def frame_cols(self) -> Literal:
        """How many columns the padded map has."""
        return self.number("frame_cols", self.layout.cols)

    @property
    def pad(self) -> Literal:
        return Literal(self.layout.pad, "PAD")

    @property
    def set_dtype(self) -> DType:
        """The dtype of a set of agents, which is kept as a bit for each agent."""
        return "u8" if self.num_agents <= 8 else "u32"

    @property
    def numbers_per_set(self) -> int:
        """How many numbers of 32 bits a set of agents takes; 0 if one number holds it."""
        return 0 if self.num_agents <= BITS_PER_NUMBER else ceil(self.num_agents / BITS_PER_NUMBER)

    def row_dims(self, type_: ir.Type) -> int:
        """Returns how many dimensions one value of a type has: see `Value.row_dims`."""
        return len(type_.indexed_by) + len(self.set_extents(type_))

    def set_extents(self, type_: ir.Type) -> tuple[Literal, ...]:
        """Returns how many numbers a large set of agents takes, for a type of such sets."""
        if type_.kind == "agents" and self.numbers_per_set:
            return (Literal(self.numbers_per_set),)
        return ()

    def can_be_away(self, entity_type: ir.EntityType = AGENTS) -> bool:
        """Returns whether agents, or movers of a name, can be off the map during a step."""
        return entity_type in self._leaving

    @cached_property
    def _leaving(self) -> frozenset[ir.EntityType]:
        return frozenset(
            entity_type
            for entity_type in body_types(self.game)
            if can_be_away(self.game, entity_type)
        )

    def stores_away(self, entity_type: ir.EntityType = AGENTS) -> bool:
        """Returns whether an agent, or a mover of a name, can be sent away for some ticks."""
        return any(s.after is not None and body_type(s.who) == entity_type for s in self.sends)

    @cached_property
    def sends(self) -> tuple[ir.Send, ...]:
        """All statements that send agents somewhere, in the order of the game."""
        return tuple(n for n in self.nodes if isinstance(n, ir.Send))

    def stores_moved(self, entity_type: ir.EntityType) -> bool:
        """Returns whether a rule or an observation reads `moved` of agents, or of movers."""
        if entity_type.what == "agent":
            for observable in self.game.observables:
                if shows_attribute(observable) and observable.field == "moved":
                    return True
        reads = [n for n in self.nodes if isinstance(n, ir.Attribute) and n.name == "moved"]
        return any(body_type(read.owner) == entity_type for read in reads)

    @cached_property
    def nodes(self) -> tuple[ir.Node, ...]:
        """All nodes of the game."""
        return tuple(ir.walk(self.game))

    @cached_property
    def deciding(self) -> Deciding:
        """The reals of the game that decide something."""
        return deciding(self.game)

    def field(self, read: ir.FieldRead, kind: str | None = None) -> ir.VarField:
        """Returns the declaration of a field."""
        return declared_field(self.game, read, kind)

    def shape(self, name: str) -> ir.Shape:
        return shape_named(self.game, name)


@dataclass
class Writer:
    """Writes the statements of one function of the generated module.

    purpose: what its random streams are named after, such as the phase.
    body, names: the statements so far, and the names that they have used.
    starting: whether it is the phase `start`. origin: of the statement that is lowered.
    state: the name of the state that is read. exact: whether what is lowered decides something, so
      that reals are computed as written.
    known: an expression and its dtype -> the variable that has its value. parts: a call of a kernel
      -> the variables of what it returns. shape_axes: a shape and its anchor -> the axis of its
      cells. axes_made: how many axes there are.
    changed, outcome: attributes of State and of Outcome -> their new values.
    added, joined: attributes -> the sums to be added to them at the end of the phase, and the sets
      to be joined with them. terms: how many terms a sum of reals that decide something has.
    marked: cells to be shown -> how many there are.
    several_lots: the fields that several statements set by lot. best_ranks: what these drew.
    parameters: of the function that `over_neighbours` calls: what it reads -> its parameter.
    """

    module: Module
    purpose: str = ""
    body: list[Statement] = field(default_factory=list)
    names: Names = field(default_factory=lambda: Names(set(RESERVED)))
    starting: bool = False
    origin: Span | None = None
    state: str = "state"
    exact: bool = False
    known: dict[tuple[Expression, str], Name] = field(default_factory=dict)
    parts: dict[Expression, tuple[Name, ...]] = field(default_factory=dict)
    shape_axes: dict[tuple[str, Variable], Axis] = field(default_factory=dict)
    axes_made: int = 0
    changed: dict[str, Expression] = field(default_factory=dict)
    outcome: dict[str, Expression] = field(default_factory=dict)
    added: dict[str, list[Expression]] = field(default_factory=dict)
    terms: dict[str, int] = field(default_factory=dict)
    marked: dict[Name, int] = field(default_factory=dict)
    joined: dict[str, list[Expression]] = field(default_factory=dict)
    several_lots: frozenset[tuple[str, str]] = frozenset()
    best_ranks: dict[str, Name] = field(default_factory=dict)
    parameters: dict[Expression, Name] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.module.writer = self

    @property
    def game(self) -> ir.Game:
        return self.module.game

    @property
    def layout(self) -> Layout:
        """The map and its tables."""
        return self.module.layout

    def value(self, e: ir.Expr, scope: IterationScope) -> Value:
        """Returns the array that an expression is for all instances of a scope at once."""
        return self.module.expression(e, scope, self)

    @contextmanager
    def deciding(self, decides: bool = True) -> Iterator[None]:
        """Lowers what decides something: inside, the arithmetic of reals is exact."""
        outer = self.exact
        self.exact = outer or decides
        yield
        self.exact = outer

    @contextmanager
    def reading(self, state: str) -> Iterator[None]:
        """Lowers reads of another state than the current one."""
        outer = self.state
        self.state = state
        yield
        self.state = outer

    def axis(self, name: str, size: int | Literal) -> Axis:
        """Returns a new axis, to the right of all made before."""
        self.axes_made += 1
        extent = size if isinstance(size, Literal) else Literal(size)
        assert isinstance(extent.value, int)
        return Axis(f"{name}{self.axes_made}", extent.value, self.axes_made, extent.name)

    def stream(self, number: int) -> Literal:
        """Returns the number of a random stream, with the line of its statement as a comment."""
        comment = ""
        if self.origin is not None:
            comment = f"{self.origin.file.rpartition('/')[2]}:{self.origin.line}"
        return self.module.number(f"stream_{self.purpose}", number, comment, "stream")

    def fresh(self, name: str) -> Name:
        """Returns a name that is free, close to the wanted one."""
        return Name(self.names.fresh(name))

    def bind(self, name: str, node: Expression) -> Name:
        """Writes `name = node` under a name that is free."""
        fresh = self.fresh(identifier(name.lower()))
        self.set(fresh, node)
        return fresh

    def set(self, name: Name, node: Expression) -> None:
        """Writes `name = node`."""
        self.body.append(Assign((name.identifier,), node, self.origin))

    def unpack(self, names: tuple[Name, ...], node: Expression) -> None:
        """Writes `a, b = node`."""
        self.body.append(Assign(tuple(name.identifier for name in names), node, self.origin))

    def give_back(self, *values: Expression) -> None:
        """Writes the end of the function."""
        self.body.append(Return(values, self.origin))

    def keep(self, name: str, value: Value) -> Value:
        """Gives a value a name in the function; what computes the same is named once."""
        node = value.node
        is_attribute = isinstance(node, Attribute) and isinstance(node.value, Name)
        if is_attribute or isinstance(node, Literal | Name):
            return value
        if self.parameters and any(part in self.parameters.values() for part in walk(node)):
            return value  # a function's body is one expression
        key = (node, value.dtype)
        if key not in self.known:
            self.known[key] = self.bind(name, node)
        return replace(value, node=self.known[key])

    def keep_node(self, name: str, node: Expression, dtype: DType) -> Expression:
        """Gives an expression a name in the function, as `keep` does."""
        return self.keep(name, Value(node, dtype)).node

    def keep_parts(self, names: tuple[str, ...], node: Expression) -> tuple[Name, ...]:
        """Names the parts of what a kernel returns; what computes the same is called once."""
        if node not in self.parts:
            self.parts[node] = tuple(self.fresh(identifier(name.lower())) for name in names)
            self.unpack(self.parts[node], node)
        return self.parts[node]

    def rename(self, name: str, value: Value, since: int) -> Value:
        """Gives a value the name that the rules have for it.

        Only if it has just been kept under another name, which nothing has read.
        since: how many statements there were before it was lowered.
        """
        last = self.body[-1] if len(self.body) > since else None
        if not isinstance(last, Assign) or len(last.names) > 1:
            return value
        if value.node != Name(last.names[0]):
            return value
        self.names.taken.discard(last.names[0])
        fresh = self.fresh(identifier(name.lower()))
        self.body[-1] = replace(last, names=(fresh.identifier,))
        for key, kept in self.known.items():
            if kept == value.node:
                self.known[key] = fresh
        return replace(value, node=fresh)

    def stored(self, attribute: str) -> Expression:
        """Returns an attribute of the state that is read."""
        return path(f"{self.state}.{attribute}")

    def beside(self, stored: Expression) -> Name:
        """Returns the parameter that stands for a field of the cells around each cell."""
        assert isinstance(stored, Attribute)
        if stored not in self.parameters:
            self.parameters[stored] = self.fresh(stored.name)
        return self.parameters[stored]

    def forget(self) -> None:
        """Forgets what has been computed so far: the state it was read from has changed."""
        self.known.clear()
        self.parts.clear()
        self.shape_axes.clear()

    def current(self, attribute: str) -> Expression:
        """Returns the new value of a state attribute so far."""
        return self.changed.get(attribute) or path(f"state.{attribute}")

    def assign(self, attribute: str, node: Expression) -> None:
        """Gives a state attribute a new value."""
        self._renew(self.changed, attribute, node)

    def total(self, attribute: str) -> Expression:
        """Returns the value of an attribute of the outcome so far."""
        return self.outcome.get(attribute) or path(f"out.{attribute}")

    def accumulate(self, attribute: str, node: Expression) -> None:
        """Gives an attribute of the outcome a new value."""
        self._renew(self.outcome, attribute, node)

    def _renew(self, values: dict[str, Expression], attribute: str, node: Expression) -> None:
        """Assigns to the variable that holds an attribute's new value, which is made if there is
        none.
        """
        if attribute not in values:
            values[attribute] = self.fresh(attribute)
        name = values[attribute]
        assert isinstance(name, Name)
        self.set(name, node)


def replaced(name: str, changes: dict[str, Expression]) -> Expression:
    """Returns a state or outcome with new values of some attributes."""
    return call(f"{name}.replace", **changes) if changes else Name(name)
