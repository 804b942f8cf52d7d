"""Differences between two games or variants: numbers as `old -> new`, and the declarations that differ, line by line."""

import re
from collections import Counter
from collections.abc import Iterable, Mapping
from difflib import unified_diff
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
WORD = re.compile(r'"[^"]*"|\w+|[^\w\s]')


def differences(old: Written, new: Written) -> dict[str, list[str]]:
    """Returns the parts of the rules in which two games differ, each with what it says; layout, comments and order don't count.

    A number that differs is a line (`apple: 1 -> 2`). A declaration is its name, and below it the lines that are gone and new, with
    their neighbours.
    """
    found = {
        "Description": _description(old.game, new.game),
        "Numbers": _numbers(old, new),
        "Map": _map(old.game, new.game),
    }
    theirs = _declarations(new.composition)
    for title, (block, declared) in _declarations(old.composition).items():
        counted = (
            by_name({"number of agents": w.game.agents.number} for w in (old, new))
            if title == "Agents"
            else []
        )
        found[title] = counted + _texts(
            block, (old.composition, declared), (new.composition, theirs[title][1])
        )
    return {title: lines for title, lines in found.items() if lines}


def by_name(sides: Iterable[Mapping[str, Any]], unit: str = "") -> list[str]:
    """Returns a line for each value that differs between an old and a new mapping, in the order of the old names, then the new ones."""
    old, new = sides
    behind = f" ({unit})" if unit else ""
    found = []
    for name in dict.fromkeys([*old, *new]):
        before, after = (
            number(value) if isinstance(value, int | float) else value
            for value in (old.get(name), new.get(name))
        )
        if before is None and after is not None:
            found.append(f"{name}: added, {after}{behind}")
        elif after is None and before is not None:
            found.append(f"{name}: removed, was {before}{behind}")
        elif old.get(name) != new.get(name):
            found.append(f"{name}: {before} -> {after}{behind}")
    return found


def _description(old: ir.Game, new: ir.Game) -> list[str]:
    about = [{"name": g.name, "title": g.title, **dict(g.about)} for g in (old, new)]
    cites = [{f"source {i}": text for i, text in enumerate(g.cites, 1)} for g in (old, new)]
    return [*by_name(about), *by_name(cites)]


def _numbers(old: Written, new: Written) -> list[str]:
    """Returns numbers with another default, entry by entry; other units, limits, and whether they are fixed when compiled."""
    mine, theirs = (_named(w.game) for w in (old, new))
    found: list[str] = []
    for name in mine | theirs:
        sides = [(side.get(name), w) for side, w in ((mine, old), (theirs, new))]
        both = [(declared, w) for declared, w in sides if declared is not None]
        if len(both) == 2:
            found += by_name(
                (dict(_entries(name, n.value, n.type.by)) for n, _ in both), unit_of(both[1][0])
            )
            found += by_name(
                {
                    f"{name}, unit": unit_of(n),
                    f"{name}, may be": limits_of(n, w),
                    f"{name}, can be changed": "before compiling"
                    if isinstance(n, ir.Size)
                    else "at any time",
                }
                for n, w in both
            )
        else:
            compared = [
                (w.composition, {name: (w.composition.constants.get(name),)}) for w in (old, new)
            ]
            found += _texts("", *compared)
    return found


def _named(game: ir.Game) -> dict[str, ir.Size | ir.Param]:
    return {size.name: size for size in game.sizes} | {param.name: param for param in game.params}


def _entries(name: str, value: Any, by: tuple[ir.Level, ...]) -> list[tuple[str, Any]]:
    """Returns a number by its name, the entries of a table each by its own: `spores[red][green]`."""
    if not by:
        return [(name, value)]
    return [
        pair
        for key, v in zip(by[0].keys, value, strict=True)
        for pair in _entries(f"{name}[{key}]", v, by[1:])
    ]


def _map(old: ir.Game, new: ir.Game) -> list[str]:
    sizes = [f"{len(g.rows)} rows of {len(g.rows[0])} cells" for g in (old, new)]
    cells = [_cells(g) for g in (old, new)]
    found = by_name({"size": size} for size in sizes)
    found += by_name({"edges": "joined" if g.wraps else "walls nobody passes"} for g in (old, new))
    counts = [Counter(kind for row in rows for kind in row) for rows in cells]
    found += by_name(
        {f"cells of {what}": number for what, number in count.items()} for count in counts
    )
    if sizes[0] == sizes[1]:
        same = sum(a == b for rows in zip(*cells, strict=True) for a, b in zip(*rows, strict=True))
        found += by_name(
            {"cells of the same kind and state": n} for n in (sum(map(len, cells[0])), same)
        )
    return found


def _cells(game: ir.Game) -> list[list[str]]:
    """Returns what stands in each cell of the map: its kind, with the state at the start."""
    meaning = {
        g.glyph: f"{g.kind} ({starts(g, game)})" if starts(g, game) else g.kind for g in game.glyphs
    }
    return [[meaning[glyph] for glyph in row] for row in game.rows]


def _declarations(c: Composition) -> dict[str, tuple[str, Declared]]:
    """Returns the parts of the rules: the block of the file that they stand in, "" for none, and its declarations by name."""
    agents = {"acts": c.acts, "moves": c.moves} | c.agent_fields | c.forbids | c.agent_blocks
    found: dict[str, tuple[str, Mapping[str, Any]]] = {
        "Agents": ("agents", agents),
        "Movers": ("", c.movers),
        "Kinds of cell": ("", c.kinds | c.groups),
        "Shapes": ("", c.shapes),
        "State of the world": ("", c.fields),
        "Names": ("", c.defines),
        "Schedule": ("", {"schedule": c.schedule}),
        "Phases": ("", c.phases),
        "Observation": ("observe", {"window": c.windows} | c.observables),
        "Episode": ("", {"episode": c.episode}),
        "Metrics": ("metrics", c.metrics),
        "Checks": ("checks", {name or "checks": found for name, found in c.checks.items()}),
        "Policies": ("", c.policies),
        "Scenarios": ("", c.scenarios),
        "Pictures": ("", c.looks),
    }
    return {
        title: (
            block,
            {name: of if isinstance(of, tuple) else (of,) for name, of in declared.items()},
        )
        for title, (block, declared) in found.items()
    }


def _texts(
    block: str, old: tuple[Composition, Declared], new: tuple[Composition, Declared]
) -> list[str]:
    """Returns the declarations whose words differ: the name, and the lines that do as `sjdsl fmt` lays them out, marked `-` and `+`."""
    found: list[str] = []
    for name in {**old[1], **new[1]}:
        before, after = (
            written_text(composition, declared.get(name, ()))
            for composition, declared in (old, new)
        )
        if WORD.findall(before) != WORD.findall(after):
            _, _, _, *lines = unified_diff(
                laid_out(before, block), laid_out(after, block), n=1, lineterm=""
            )
            found += [
                name,
                *(
                    "    …" if line.startswith("@@") else f"  {line[0]} {line[1:]}"
                    for line in lines
                ),
            ]
    return found


def name_of(w: Written) -> str:
    """Returns `yard`, `yard, variant crowd`."""
    return w.game.name + (f", variant {'+'.join(w.chosen)}" if w.chosen else "")


def report(old: Written, new: Written) -> str:
    """Returns the differences as text."""
    sections = differences(old, new)
    found = [f"{name_of(old)}  ->  {name_of(new)}"]
    for title, lines in sections.items():
        found += ["", title, *(f"  {line}" for line in lines)]
    return "\n".join([*found, *([] if sections else ["nothing differs"]), ""])
