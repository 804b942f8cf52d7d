"""Converts values of fields between the form that authors write and that of the interpreter.

Authors write an enum value as a text, an agent as its number, nobody as None, several agents as a
set of numbers, and a `by` field as a mapping from enum values, numbers, or numbers of agents:
`{"raw": 2}`, `{0: 2}`.
"""

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.types import element
from sjdsl.interpreter.state import Cell
from sjdsl.near_names import meant

LARGEST = 2**31 - 1


def from_author(name: str, written: Any, type_: ir.Type, agents: int, current: Any = None) -> Any:
    """Returns a written value in the interpreter's form.

    Args:
      name: the field or entry, for messages.
      current: its current value: entries of a `by` field that are not written keep it.
    Raises:
      ValueError: not a value of this type.
    """
    if not type_.indexed_by:
        return _single_from_author(name, written, type_, agents)
    keys = _keys(type_.indexed_by[0])
    if not isinstance(written, Mapping):
        raise ValueError(
            f"`{name}` has an entry for each of {', '.join(map(str, keys))}: "
            f"write `{name}[{keys[0]}]`, or a mapping by entry"
        )
    for key in written:
        if key not in keys:
            raise ValueError(
                f"`{name}` has no entry `{key}`{meant(str(key), list(map(str, keys)))}"
            )
    entries = []
    for key, entry in zip(keys, current, strict=True):
        if key in written:
            entry = from_author(f"{name}[{key}]", written[key], element(type_), agents, entry)
        entries.append(entry)
    return tuple(entries)


def _keys(index_set: ir.IndexSet) -> tuple[str, ...] | tuple[int, ...]:
    """Returns the keys of written entries: enum values, numbers, or numbers of agents."""
    return index_set.names if index_set.kind == "word" else tuple(map(int, index_set.keys))


def _single_from_author(name: str, written: Any, type_: ir.Type, agents: int) -> Any:
    """Returns a written value of a type without entries in the interpreter's form."""
    match type_.kind:
        case "word":
            if written not in type_.words:
                raise ValueError(
                    f"`{name}` is one of {', '.join(type_.words)}, not {written!r}"
                    f"{meant(str(written), type_.words, '')}"
                )
            return written
        case "agent":
            return None if written is None else _agent(name, written, agents)
        case "cell":
            if written is None:
                return None
            if isinstance(written, str) or not isinstance(written, Sequence) or len(written) != 2:
                raise ValueError(
                    f"`{name}` is a cell, (row, column), or None for nowhere, not {written!r}"
                )
            return Cell(*map(int, written))
        case "agents":
            if isinstance(written, str) or not isinstance(written, Collection):
                raise ValueError(f"`{name}` is a set of numbers of agents, not {written!r}")
            return frozenset(_agent(name, agent, agents) for agent in written)
    number = written.item() if isinstance(written, np.generic) else written
    if isinstance(number, bool) or not isinstance(number, int | float) or not np.isfinite(number):
        raise ValueError(f"`{name}` is a number, not {written!r}")
    if type_.kind == "real":
        return np.float32(number)
    high = min(type_.high, LARGEST)
    if number != int(number) or not type_.low <= number <= high:
        raise ValueError(
            f"`{name}` is a whole number from {type_.low:g} to {high:g}, not {written!r}"
        )
    return int(number)


def _agent(name: str, number: Any, agents: int) -> int:
    """Returns the number of an agent. Raises ValueError for anything else."""
    is_number = isinstance(number, int | np.integer) and not isinstance(number, bool)
    if not is_number or not 0 <= number < agents:
        raise ValueError(f"`{name}`: the agents are 0 .. {agents - 1}, not {number!r}")
    return int(number)


def to_author(value: Any, type_: ir.Type) -> Any:
    """Returns a value of the interpreter as an author writes it."""
    if type_.indexed_by:
        entries = zip(_keys(type_.indexed_by[0]), value, strict=True)
        return {key: to_author(entry, element(type_)) for key, entry in entries}
    if type_.kind == "agents":
        return set(value)
    return float(value) if type_.kind == "real" else value


def is_expected(actual: Any, expected: Any) -> bool:
    """Returns whether an actual value is the expected one.

    Reals are compared to 1e-6, of a mapping only the entries that `expected` has.
    """
    if isinstance(expected, Mapping):
        return isinstance(actual, Mapping) and all(
            key in actual and is_expected(actual[key], value) for key, value in expected.items()
        )
    if isinstance(actual, list):
        is_list = isinstance(expected, list | tuple) and len(actual) == len(expected)
        return is_list and all(map(is_expected, actual, expected))
    if isinstance(actual, set):
        return isinstance(expected, Collection) and actual == set(expected)
    if isinstance(actual, float) and isinstance(expected, int | float | np.number):
        return bool(np.isclose(actual, float(expected), rtol=1e-6, atol=1e-6))
    return bool(actual == expected)


def merged(values: Mapping[str, Any], new: Mapping[str, Any]) -> dict[str, Any]:
    """Returns values with new ones over them; mappings are merged entry by entry."""
    result = {**values, **new}
    for name, value in new.items():
        if isinstance(value, Mapping) and isinstance(values.get(name), Mapping):
            result[name] = merged(values[name], value)
    return result
