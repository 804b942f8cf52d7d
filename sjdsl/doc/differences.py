"""Differences between two games or variants: numbers as `old -> new`, declarations by line."""

import re
from collections import Counter
from collections.abc import Mapping
from difflib import unified_diff
from itertools import chain
from operator import eq
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ast.node import Node
from sjdsl.compiler.compose import Composition
from sjdsl.doc.numbers import limits_of, unit_of
from sjdsl.doc.quoted import laid_out, written_text
from sjdsl.doc.sheet import starts
from sjdsl.doc.wording import number
from sjdsl.doc.written import Written

Declared = Mapping[str, tuple[Node | None, ...]]
TOKEN = re.compile(r'"[^"]*"|\w+|[^\w\s]')


def differences(old: Written, new: Written) -> dict[str, list[str]]:
    """Returns, for each part of the rules that differs, lines that tell how.

    A value that differs is a line (`apple: 1 -> 2`). A declaration is its name, and below it the
    lines that are gone and new, with their neighbours. Layout, comments and order don't count.
    """
    parts = {
        "Description": _values(_description(old.game), _description(new.game)),
        "Numbers": _numbers(old, new),
        "Map": _map(old.game, new.game),
    }
    new_declarations = _declarations(new.composition)
    for title, (block, declared) in _declarations(old.composition).items():
        _, new_declared = new_declarations[title]
        parts[title] = _texts(block, (old.composition, declared), (new.composition, new_declared))
    label = "number of agents"
    number_of_agents = _values({label: old.game.agents.number}, {label: new.game.agents.number})
    parts["Agents"] = number_of_agents + parts["Agents"]
    return {title: lines for title, lines in parts.items() if lines}


def _values(old: Mapping[str, Any], new: Mapping[str, Any], unit: str = "") -> list[str]:
    """Returns a line for each value that differs; those with old names come first."""
    unit_text = f" ({unit})" if unit else ""
    lines = []
    for name in {**old, **new}:
        before = _value_text(old.get(name))
        after = _value_text(new.get(name))
        if before is None and after is not None:
            lines.append(f"{name}: added, {after}{unit_text}")
        elif after is None and before is not None:
            lines.append(f"{name}: removed, was {before}{unit_text}")
        elif old.get(name) != new.get(name):
            lines.append(f"{name}: {before} -> {after}{unit_text}")
    return lines


def _value_text(value: Any) -> str | None:
    return number(value) if isinstance(value, int | float) else value


def _description(game: ir.Game) -> dict[str, str]:
    sources = {f"source {number}": text for number, text in enumerate(game.cites, 1)}
    return {"name": game.name, "title": game.title, **dict(game.about), **sources}


def _numbers(old: Written, new: Written) -> list[str]:
    """Returns sizes and params with other values, units or limits, and those in one game only."""
    old_numbers = _sizes_and_params(old.game)
    new_numbers = _sizes_and_params(new.game)
    lines: list[str] = []
    for name in old_numbers | new_numbers:
        if name in old_numbers and name in new_numbers:
            before = old_numbers[name]
            after = new_numbers[name]
            old_entries = _entries(name, before.value, before.type.indexed_by)
            new_entries = _entries(name, after.value, after.type.indexed_by)
            lines += _values(old_entries, new_entries, unit_of(after))
            lines += _values(_properties(before, old), _properties(after, new))
        else:
            lines += _texts("", _constant(name, old), _constant(name, new))
    return lines


def _constant(name: str, written: Written) -> tuple[Composition, Declared]:
    c = written.composition
    return c, {name: (c.constants.get(name),)}


def _sizes_and_params(game: ir.Game) -> dict[str, ir.Size | ir.Param]:
    return {size.name: size for size in game.sizes} | {param.name: param for param in game.params}


def _properties(constant: ir.Size | ir.Param, written: Written) -> dict[str, str]:
    """Returns what is said of a size or param beside its value, by name."""
    is_size = isinstance(constant, ir.Size)
    return {
        f"{constant.name}, unit": unit_of(constant),
        f"{constant.name}, may be": limits_of(constant, written),
        f"{constant.name}, can be changed": "before compiling" if is_size else "at any time",
    }


def _entries(name: str, value: Any, by: tuple[ir.IndexSet, ...]) -> dict[str, Any]:
    """Returns the entries of a number by their names, such as `spores[red][green]`."""
    if not by:
        return {name: value}
    entries: dict[str, Any] = {}
    for key, entry in zip(by[0].keys, value, strict=True):
        entries |= _entries(f"{name}[{key}]", entry, by[1:])
    return entries


def _map(old: ir.Game, new: ir.Game) -> list[str]:
    """Returns the lines about maps that differ: size, cells of each kind, and how many are alike."""
    old_cells = _cells(old)
    new_cells = _cells(new)
    old_size = _map_size(old)
    new_size = _map_size(new)
    lines = _values(old_size, new_size)
    lines += _values(_cell_counts(old_cells), _cell_counts(new_cells))
    if old_size["size"] == new_size["size"]:
        old_in_order = list(chain.from_iterable(old_cells))
        new_in_order = chain.from_iterable(new_cells)
        num_same = sum(map(eq, old_in_order, new_in_order))
        label = "cells of the same kind and state"
        lines += _values({label: len(old_in_order)}, {label: num_same})
    return lines


def _map_size(game: ir.Game) -> dict[str, str]:
    return {
        "size": f"{len(game.rows)} rows of {len(game.rows[0])} cells",
        "edges": "joined" if game.wraps else "walls nobody passes",
    }


def _cell_counts(cells: list[list[str]]) -> dict[str, int]:
    counts = Counter(cell for row in cells for cell in row)
    return {f"cells of {cell}": count for cell, count in counts.items()}


def _cells(game: ir.Game) -> list[list[str]]:
    """Returns the kind of each cell of the map, with its state at the start."""
    meanings = {}
    for glyph in game.glyphs:
        state = starts(glyph, game)
        meanings[glyph.glyph] = f"{glyph.kind} ({state})" if state else glyph.kind
    return [[meanings[glyph] for glyph in row] for row in game.rows]


def _declarations(c: Composition) -> dict[str, tuple[str, Declared]]:
    """Returns the declarations of each part of the rules by name.

    Before them stands the block of the file that they belong to, "" for none.
    """
    agents = {"acts": c.acts, "moves": c.moves} | c.agent_fields | c.forbids | c.agent_blocks
    splits = dict(c.held_out) if c.train_on is None else {"train on": c.train_on} | c.held_out
    parts: dict[str, tuple[str, Mapping[str, Any]]] = {
        "Agents": ("agents", agents),
        "Movers": ("", c.movers),
        "Kinds of cell": ("", c.kinds | c.groups),
        "Shapes": ("", c.shapes),
        "State of the world": ("", c.fields),
        "Names": ("", c.defines),
        "Schedule": ("", {"schedule": c.schedule}),
        "Phases": ("", c.phases),
        "Observation": ("observe", {"window": c.windows} | c.observables),
        "Episode": ("", {"episode": c.episode} | c.tasks | splits),
        "Metrics": ("metrics", c.metrics),
        "Checks": ("checks", {name or "checks": checks for name, checks in c.checks.items()}),
        "Policies": ("", c.policies),
        "Scenarios": ("", c.scenarios),
        "Pictures": ("", c.looks),
    }
    declarations: dict[str, tuple[str, Declared]] = {}
    for title, (block, declared) in parts.items():
        nodes = {}
        for name, node in declared.items():
            nodes[name] = node if isinstance(node, tuple) else (node,)
        declarations[title] = (block, nodes)
    return declarations


def _texts(
    block: str, old: tuple[Composition, Declared], new: tuple[Composition, Declared]
) -> list[str]:
    """Returns the declarations whose tokens differ.

    Each is its name, and the lines that differ as `sjdsl fmt` formats them, marked `-` and `+`.
    """
    old_composition, old_declared = old
    new_composition, new_declared = new
    differing: list[str] = []
    for name in {**old_declared, **new_declared}:
        before = written_text(old_composition, old_declared.get(name, ()))
        after = written_text(new_composition, new_declared.get(name, ()))
        if TOKEN.findall(before) != TOKEN.findall(after):
            differing.append(name)
            old_lines = laid_out(before, block)
            new_lines = laid_out(after, block)
            _, _, _, *lines = unified_diff(old_lines, new_lines, n=1, lineterm="")
            for line in lines:
                differing.append("    …" if line.startswith("@@") else f"  {line[0]} {line[1:]}")
    return differing


def name_of(written: Written) -> str:
    """Returns `yard`, or with variants `yard, variant crowd`."""
    name = written.game.name
    return f"{name}, variant {'+'.join(written.chosen)}" if written.chosen else name


def report(old: Written, new: Written) -> str:
    """Returns the differences as text."""
    parts = differences(old, new)
    lines = [f"{name_of(old)}  ->  {name_of(new)}"]
    for title, lines_of_part in parts.items():
        lines += ["", title, *(f"  {line}" for line in lines_of_part)]
    if not parts:
        lines.append("nothing differs")
    return "\n".join(lines) + "\n"
