"""The numbers of a game as the page has them: one slider or field for each param, and for each entry of a table."""

from collections.abc import Iterator, Mapping
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.sorts import Level
from sjdsl.interpreter.numbers import real

INFINITE = 1e9  # a limit beyond it is none
MOST = 400  # entries of one table that are shown


def knobs(game: ir.Game, values: dict[str, Any]) -> list[dict[str, Any]]:
    """Returns every param with its unit and limits (null for none), and its entries: `[[names], value, written]`, without names if it is no table.

    value: as it is set; written: as the text has it in the chosen variant.
    words: what the param can be, if it is one of several words; else empty. A table of more than 400 entries has its first.
    """
    found = []
    for param in game.params:
        type_ = param.type
        low, high = (limit if abs(limit) < INFINITE else None for limit in (type_.low, type_.high))
        written = real(param.value) if type_.kind == "real" else param.value
        entries = list(_entries(values[param.name], written, type_.by, type_.kind == "word"))
        found.append(
            {
                "name": param.name,
                "whole": type_.kind == "int",
                "unit": type_.unit,
                "low": low,
                "high": high,
                "words": list(type_.words) if type_.kind == "word" else [],
                "entries": entries[:MOST],
                "left_out": max(0, len(entries) - MOST),
            }
        )
    return found


def _entries(value: Any, written: Any, by: tuple[Level, ...], is_word: bool) -> Iterator[list[Any]]:
    if not by:
        yield [[], value, written] if is_word else [[], float(value), float(written)]
        return
    for key, inner, other in zip(by[0].keys, value, written, strict=True):
        yield from (
            [[key, *names], *found] for names, *found in _entries(inner, other, by[1:], is_word)
        )


def with_entries(game: ir.Game, values: Mapping[str, Any], name: str, given: Any) -> Any:
    """Returns what is given for a param; of a table, where a mapping is given, with the entries that it leaves out as they are now."""
    param = next((param for param in game.params if param.name == name), None)
    return given if param is None else _filled(values[name], param.type.by, given)


def _filled(now: Any, by: tuple[Level, ...], given: Any) -> Any:
    if not by or not isinstance(given, Mapping):
        return given
    before = dict(zip(by[0].keys, now, strict=True))
    inner = {
        key: _filled(before[key], by[1:], value) if key in before else value
        for key, value in given.items()
    }
    return {key: _plain(value, by[1:]) for key, value in before.items()} | inner


def _plain(value: Any, by: tuple[Level, ...]) -> Any:
    return (
        {key: _plain(inner, by[1:]) for key, inner in zip(by[0].keys, value, strict=True)}
        if by
        else value
    )
