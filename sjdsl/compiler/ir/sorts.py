"""Finite sorts, the indices of rows and tables: the words of a set, the whole numbers of a range, the agents.

A level of a row is the names of its entries. No word has a blank or begins with a digit or a sign, so that the names tell the sort:

    by { raw, cut }  ->  ("raw", "cut")        by 0 .. 2  ->  ("0", "1", "2")        by agent  ->  ("agent 0", "agent 1")
"""

from collections.abc import Sequence
from typing import Literal, TypeAlias

Level: TypeAlias = tuple[str, ...]
Sort: TypeAlias = Literal["word", "number", "agent"]

_AGENT = "agent "


def of_agents(number: int) -> Level:
    """Returns the level of a row with one entry for each agent."""
    return tuple(f"{_AGENT}{agent}" for agent in range(number))


def of_numbers(low: int, high: int) -> Level:
    """Returns the level of a row with one entry for each whole number from `low` to `high`."""
    return tuple(map(str, range(low, high + 1)))


def sort_of(level: Sequence[str]) -> Sort:
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
