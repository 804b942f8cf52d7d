"""Entity types: what a thing is, and what the entries of a row are told apart by."""

from typing import Literal

from sjdsl.compiler.diagnostics.frozen import Record


class EntityType(Record):
    """What a thing is: an agent, a mover, a cell, or the world, of which there is one.

    names: the name of the movers, or the kinds that the cell may be of; none of agents and the
    world.
    """

    what: Literal["agent", "mover", "cell", "world"]
    names: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """The word for one of the type.

        `agent`, `world`, the name of the movers or of the one kind of cell.
        """
        return " | ".join(self.names) or self.what

    @property
    def plural(self) -> str:
        """The word for all of the type: `agents`; movers are spoken of by their name."""
        return "agents" if self.what == "agent" else self.name

    def overlaps(self, other: "EntityType") -> bool:
        """Returns whether a thing can be of both types."""
        return self.what == other.what and (
            self.names == other.names or not set(self.names).isdisjoint(other.names)
        )


AGENTS = EntityType("agent")


class IndexSet(Record):
    """What the entries of a row are told apart by.

    kind: the words of a set, the whole numbers of a range, or the agents.
    names: of the entries, in order: `raw`, `cut`; `-1`, `0`, `1`; `agent 0`, `agent 1`.
    """

    kind: Literal["word", "number", "agent"]
    names: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.names)

    @property
    def keys(self) -> tuple[str, ...]:
        """The entries as they stand in square brackets: of an agent its number."""
        return tuple(map(str, range(len(self)))) if self.kind == "agent" else self.names

    @property
    def entries(self) -> tuple["Entry", ...]:
        return tuple(Entry(self, place) for place in range(len(self)))

    @property
    def first(self) -> int:
        """What the first entry stands for: its number, or 0 for words and agents."""
        return int(self.names[0]) if self.kind == "number" else 0

    @property
    def last(self) -> int:
        """What the last entry stands for."""
        return self.first + len(self) - 1

    def place_of(self, key: str | int) -> int:
        """Returns the place of an entry, from 0.

        `key`: the name of the entry, a number of the range, or the number of an agent.
        """
        return self.names.index(key) if isinstance(key, str) else int(key) - self.first

    def __str__(self) -> str:
        """Returns the index set as it stands after `by`."""
        match self.kind:
            case "agent":
                return "agent"
            case "number":
                return f"{self.names[0]} .. {self.names[-1]}"
            case "word":
                return f"{{ {', '.join(self.names)} }}"


class Entry(Record):
    """One entry of a row: its index set, and its place there, from 0."""

    index_set: IndexSet
    place: int

    @property
    def name(self) -> str:
        return self.index_set.names[self.place]

    @property
    def key(self) -> str:
        """The entry as it stands in square brackets."""
        return self.index_set.keys[self.place]


def agent_indices(number: int) -> IndexSet:
    """Returns the index set of a row with one entry for each agent."""
    return IndexSet("agent", tuple(f"agent {agent}" for agent in range(number)))


def number_indices(low: int, high: int) -> IndexSet:
    """Returns the index set of a row with one entry for each whole number from `low` to `high`."""
    return IndexSet("number", tuple(map(str, range(low, high + 1))))
