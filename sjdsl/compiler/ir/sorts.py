"""Sorts: what a thing is, and what the entries of a row are told apart by: the words of a set, the whole numbers of a range, the agents.

A level of a row is the names of its entries. No word has a blank or begins with a digit or a sign, so that the names tell the sort:

    by { raw, cut }  ->  ("raw", "cut")        by 0 .. 2  ->  ("0", "1", "2")        by agent  ->  ("agent 0", "agent 1")
"""

from collections.abc import Sequence
from typing import Literal, TypeAlias

from sjdsl.compiler.diagnostics.frozen import Record

Level: TypeAlias = tuple[str, ...]


class Sort(Record):
    """What a thing is: an agent, a mover, a cell, or the world, of which there is one.

    names: the name of the movers, or the kinds that the cell may be of; none of agents and the world.
    """

    what: Literal["agent", "mover", "cell", "world"]
    names: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """The word for one of the sort: `agent`, `world`, the name of the movers or of the one kind of cell."""
        return " | ".join(self.names) or self.what

    @property
    def plural(self) -> str:
        """The word for all of the sort: `agents`; movers are spoken of by their name."""
        return "agents" if self.what == "agent" else self.name

    def overlaps(self, other: "Sort") -> bool:
        """Returns whether a thing can be of both sorts."""
        return self.what == other.what and (self.names == other.names or not set(self.names).isdisjoint(other.names))


AGENTS = Sort("agent")

_AGENT = "agent "


def of_agents(number: int) -> Level:
    """Returns the level of a row with one entry for each agent."""
    return tuple(f"{_AGENT}{agent}" for agent in range(number))


def of_numbers(low: int, high: int) -> Level:
    """Returns the level of a row with one entry for each whole number from `low` to `high`."""
    return tuple(map(str, range(low, high + 1)))


def sort_of(level: Sequence[str]) -> Literal["word", "number", "agent"]:
    """Returns what the entries of a row are told apart by."""
    if level[0].startswith(_AGENT):
        return "agent"
    return "number" if level[0].lstrip("-").isdigit() else "word"


def lowest_number(level: Sequence[str]) -> int:
    """Returns what the first entry of a row stands for: its number, or 0 for words and agents."""
    return int(level[0]) if sort_of(level) == "number" else 0


def place_of(level: Sequence[str], key: str | int) -> int:
    """Returns the place of an entry, from 0. `key`: the name of the entry (a word), a number of the range, or the number of an agent."""
    return level.index(key) if isinstance(key, str) else int(key) - lowest_number(level)


def entry_name(name: str) -> str:
    """Returns an entry as it stands in square brackets: of an agent its number."""
    return name.removeprefix(_AGENT)


def level_text(level: Sequence[str]) -> str:
    """Returns a level as it stands after `by`."""
    match sort_of(level):
        case "agent":
            return "agent"
        case "number":
            return f"{level[0]} .. {level[-1]}"
        case _:
            return f"{{ {', '.join(level)} }}"


def entry_named(level: Sequence[str], text: str) -> int | None:
    """Returns the place of the entry that is written so in square brackets, None if the row has none of that name."""
    return next((place for place, name in enumerate(level) if text in (name, entry_name(name))), None)
