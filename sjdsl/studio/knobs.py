"""The params of a game as the page shows them: a slider or field for each number or enum value."""

from collections.abc import Iterator, Mapping
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.entity_types import IndexSet
from sjdsl.interpreter.numbers import real

INFINITE = 1e9  # a limit beyond it is none
MAX_ENTRIES = 400  # of one param that are shown


def knobs(game: ir.Game, values: dict[str, Any]) -> list[dict[str, Any]]:
    """Returns every param as data for JSON.

    Keys: `name`; `whole`: whether it is a whole number; `unit`; `low`, `high`: its limits, null for
    none; `words`: its enum values, none for a number; `entries`: the first 400, `[[keys], value,
    written]`, one without keys if the param isn't indexed; `left_out`: how many follow. `value` is
    set now, `written` stands in the text, with the chosen variant.
    """
    params: list[dict[str, Any]] = []
    for param in game.params:
        type_ = param.type
        is_word = type_.kind == "word"
        written = real(param.value) if type_.kind == "real" else param.value
        entries = list(_entries(values[param.name], written, type_.indexed_by, is_word))
        knob = {
            "name": param.name,
            "whole": type_.kind == "int",
            "unit": type_.unit,
            "low": type_.low if abs(type_.low) < INFINITE else None,
            "high": type_.high if abs(type_.high) < INFINITE else None,
            "words": list(type_.words) if is_word else [],
            "entries": entries[:MAX_ENTRIES],
            "left_out": max(0, len(entries) - MAX_ENTRIES),
        }
        params.append(knob)
    return params


def _entries(
    value: Any, written: Any, by: tuple[IndexSet, ...], is_word: bool
) -> Iterator[list[Any]]:
    """Yields `[keys, value, written]` for each entry of a param. by: its indices."""
    if by:
        for key, entry, written_entry in zip(by[0].keys, value, written, strict=True):
            for keys, *numbers in _entries(entry, written_entry, by[1:], is_word):
                yield [[key, *keys], *numbers]
    elif is_word:
        yield [[], value, written]
    else:
        yield [[], float(value), float(written)]


def with_entries(game: ir.Game, values: Mapping[str, Any], name: str, value: Any) -> Any:
    """Returns a new value of a param, with all entries of an indexed one.

    Args:
      values: of all params now.
      value: the new value; entries that a mapping leaves out stay as they are.
    """
    param = next((param for param in game.params if param.name == name), None)
    return value if param is None else _merged(values[name], param.type.indexed_by, value)


def _merged(old: Any, by: tuple[IndexSet, ...], new: Any) -> Any:
    """Returns a new value with the old entries that it leaves out. by: the indices of both."""
    if not by or not isinstance(new, Mapping):
        return new
    entries = dict(zip(by[0].keys, old, strict=True))
    merged = {key: _as_mapping(entry, by[1:]) for key, entry in entries.items()}
    for key, value in new.items():
        merged[key] = _merged(entries[key], by[1:], value) if key in entries else value
    return merged


def _as_mapping(value: Any, by: tuple[IndexSet, ...]) -> Any:
    """Returns a value with its entries by key. by: its indices."""
    if not by:
        return value
    return {key: _as_mapping(entry, by[1:]) for key, entry in zip(by[0].keys, value, strict=True)}
