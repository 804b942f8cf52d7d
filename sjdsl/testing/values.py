"""Converts field values between three forms: as authors write them, as interpreted, as stored in arrays.

Written: a word is a text, a number a number, an agent its number, nobody None, several agents a set of numbers; an entry of a
`by` field stands under its word, its number, or the number of its agent: `{"raw": 2}`, `{0: 2}`.
"""

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np

from sjdsl.compiler import ir
from sjdsl.interpreter.state import Cell
from sjdsl.near_names import meant

LARGEST = 2**31 - 1


def held(name: str, written: Any, type_: ir.Type, agents: int, before: Any = None) -> Any:
    """Returns a written value as the interpreter holds it.

    Args:
      name: what is set, for messages.
      before: the value so far: entries of a `by` field that are not written keep it.
    Raises ValueError: not a value of this type.
    """
    if not type_.by:
        return _held(name, written, type_, agents)
    keys, inner = _keys(type_.by[0]), type_.model_copy(update={"by": type_.by[1:]})
    if not isinstance(written, Mapping):
        raise ValueError(
            f"`{name}` has an entry for each of {', '.join(map(str, keys))}: write `{name}[{keys[0]}]`, or a mapping by entry"
        )
    for key in written:
        if key not in keys:
            raise ValueError(
                f"`{name}` has no entry `{key}`{meant(str(key), list(map(str, keys)))}"
            )
    entries = zip(keys, before, strict=True)
    return tuple(
        held(f"{name}[{k}]", written[k], inner, agents, b) if k in written else b
        for k, b in entries
    )


def _keys(level: ir.Level) -> tuple[str, ...] | tuple[int, ...]:
    """Returns what entries stand under where they are written: their words, their numbers, or the numbers of their agents."""
    return level.names if level.sort == "word" else tuple(map(int, level.keys))


def _held(name: str, written: Any, type_: ir.Type, agents: int) -> Any:
    match type_.kind:
        case "word":
            if written not in type_.words:
                raise ValueError(
                    f"`{name}` is one of {', '.join(type_.words)}, not {written!r}{meant(str(written), type_.words, '')}"
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
    if (
        isinstance(number, bool)
        or not isinstance(number, int | np.integer)
        or not 0 <= number < agents
    ):
        raise ValueError(f"`{name}`: the agents are 0 .. {agents - 1}, not {number!r}")
    return int(number)


def written(value: Any, type_: ir.Type) -> Any:
    """Returns a value of the interpreter as an author writes it."""
    if type_.by:
        inner = type_.model_copy(update={"by": type_.by[1:]})
        return {
            key: written(entry, inner) for key, entry in zip(_keys(type_.by[0]), value, strict=True)
        }
    if type_.kind == "agents":
        return set(value)
    return float(value) if type_.kind == "real" else value


def loaded(array: np.ndarray, type_: ir.Type) -> Any:
    """Returns a stored parameter as the interpreter holds it, float32 for float32."""
    if array.ndim:
        return tuple(loaded(entry, type_) for entry in array)
    if type_.kind == "word":
        return type_.words[int(array)]
    return np.float32(array) if type_.kind == "real" else int(array)


def same(found: Any, wanted: Any) -> bool:
    """Returns whether a found value is the wanted one: reals to 1e-6, of rows only the entries that `wanted` has."""
    if isinstance(wanted, Mapping):
        return isinstance(found, Mapping) and all(
            key in found and same(found[key], value) for key, value in wanted.items()
        )
    if isinstance(found, list):
        return (
            isinstance(wanted, list | tuple)
            and len(found) == len(wanted)
            and all(map(same, found, wanted))
        )
    if isinstance(found, set):
        return isinstance(wanted, Collection) and found == set(wanted)
    if isinstance(found, float) and isinstance(wanted, int | float | np.number):
        return bool(np.isclose(found, float(wanted), rtol=1e-6, atol=1e-6))
    return bool(found == wanted)


def merged(before: Mapping[str, Any], new: Mapping[str, Any]) -> dict[str, Any]:
    """Returns values with new ones over them; tables entry by entry."""
    both = {
        name: merged(before[name], new[name])
        for name in new
        if isinstance(new[name], Mapping) and isinstance(before.get(name), Mapping)
    }
    return {**before, **new, **both}
