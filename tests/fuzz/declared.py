"""What a generated game has declared: its numbers, kinds, fields, shapes and events, as the generator of its rules knows them."""

from dataclasses import dataclass, field
from random import Random
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.entity_types import IndexSet, agent_indices, number_indices
from sjdsl.runtime.actions import HEADINGS

Lines = list[str]


@dataclass(frozen=True)
class Field:
    """A field or timer of a kind, of the agents or of the world. `text`: its declaration."""

    name: str
    type: ir.Type
    text: str
    capped: bool = False
    timer: bool = False


@dataclass
class Kind:
    """A kind of cell. `extra`: its `glyph` and `blocks` lines."""

    name: str
    glyph: str
    fields: list[Field]
    extra: Lines = field(default_factory=list)
    glyphs: list[str] = field(default_factory=list)
    cells: int = 0


@dataclass(frozen=True)
class Number:
    """A size or param. `value`: of a size."""

    name: str
    type: ir.Type
    text: str
    value: int = 0


@dataclass(frozen=True)
class Shape:
    """`text`: how it is used; `size`: its cells; `blockable`: a shape with a name and lanes."""

    text: str
    directed: bool
    size: int
    blockable: bool = False


@dataclass(frozen=True)
class Event:
    name: str
    by: IndexSet | None
    per_agent: bool


@dataclass(frozen=True)
class Define:
    """`parameters`: what each may stand for: an ir.Type, `agent`, or a tuple of kinds."""

    name: str
    parameters: tuple[object, ...]
    type: ir.Type
    text: str


@dataclass
class World:
    """One game in the making."""

    random: Random
    taken: set[str] = field(default_factory=set)
    word_sets: list[tuple[str, ...]] = field(default_factory=list)
    sizes: list[Number] = field(default_factory=list)
    params: list[Number] = field(default_factory=list)
    kinds: dict[str, Kind] = field(default_factory=dict)
    groups: dict[str, tuple[str, ...]] = field(default_factory=dict)
    agent_fields: list[Field] = field(default_factory=list)
    movers: dict[str, Kind] = field(default_factory=dict)  # `cells`: how many there are
    fields: list[Field] = field(default_factory=list)
    actions: tuple[str, ...] = ()  # those without arguments
    with_arguments: list[Any] = field(default_factory=list)  # acting.Action
    shapes: list[Shape] = field(default_factory=list)
    shape_texts: Lines = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    defines: list[Define] = field(default_factory=list)
    requires: Lines = field(default_factory=list)
    dilemmas: Lines = field(default_factory=list)
    policies: Lines = field(default_factory=list)
    agents: int = 1
    rows: Lines = field(default_factory=list)
    bound: int = 0

    def fresh(self, names: tuple[str, ...]) -> str:
        """Returns a name nothing else has."""
        free = [n for n in names if n not in self.taken]
        name = (
            self.random.choice(free) if free else f"{self.random.choice(names)}_{len(self.taken)}"
        )
        self.taken.add(name)
        return name

    def variable(self) -> str:
        """Returns a name for one more variable, never used before."""
        self.bound += 1
        letters = "abcdefghijkmnopqrstuvwxyz"
        return letters[self.bound % 25] + (str(self.bound // 25) if self.bound >= 25 else "") + "_"

    def is_now(self, probability: float) -> bool:
        return self.random.random() < probability

    def kinds_of(self, name: str) -> tuple[str, ...]:
        return (name,) if name in self.kinds else self.groups[name]

    def cell_fields(self, kinds: tuple[str, ...]) -> list[Field]:
        """Returns the fields all the kinds have, with one type, capped in all of them or in none."""
        first, *others = (self.kinds[k].fields for k in kinds)
        alike = {f.name: f for f in first}
        for fields in others:
            given = {f.name: f for f in fields}
            alike = {
                n: f
                for n, f in alike.items()
                if n in given
                and (given[n].type, given[n].timer, given[n].capped) == (f.type, f.timer, f.capped)
            }
        return list(alike.values())

    def fields_of(self, sort: str) -> list[Field]:
        """Returns the fields of the agents, or of movers of a sort, beside their headings."""
        return self.movers[sort].fields if sort else self.agent_fields

    def number_of(self, sort: str) -> int:
        return self.movers[sort].cells if sort else self.agents

    @property
    def bodies(self) -> int:
        """How many agents and movers there are."""
        return self.agents + sum(sort.cells for sort in self.movers.values())

    def num_cells(self, kinds: tuple[str, ...]) -> int:
        return sum(self.kinds[k].cells for k in kinds)

    def level(self) -> IndexSet:
        """Returns what a row can be by: words, mostly, or the agents, or the numbers of a range."""
        sort = self.random.choice(("word", "word", "agent", "agent", "number"))
        if sort == "word":
            return IndexSet("word", self.random.choice(self.word_sets))
        low = self.random.choice((0, 0, 1, -1))
        return (
            agent_indices(self.agents)
            if sort == "agent"
            else number_indices(low, low + self.random.randint(0, 3))
        )

    def words(self) -> list[tuple[str, ...]]:
        """Returns the sets of words, the headings among them."""
        return [*self.word_sets, HEADINGS]
