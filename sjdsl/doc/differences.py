"""Differences between two games or variants: numbers as `old -> new`, and the declarations that differ, line by line."""

import re
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
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

Marked = tuple[str, str]  # `-`, `+` or a blank, and a line
Declared = Mapping[str, tuple[Node | None, ...]]
WORD = re.compile(r'"[^"]*"|\w+|[^\w\s]')


@dataclass(frozen=True)
class Change:
    """One thing that differs.

    old, new: its values, None where there is none; of a declaration its lines, and `lines` has those that are gone and those that are
    new, with their neighbours.
    """

    what: str
    old: Any = None
    new: Any = None
    unit: str = ""
    lines: tuple[Marked, ...] = ()


@dataclass(frozen=True)
class Section:
    """The changes in one part of the rules."""

    title: str
    changes: tuple[Change, ...]


def differences(old: Written, new: Written) -> tuple[Section, ...]:
    """Returns the parts of the rules in which two games differ. Layout, comments and the order of declarations don't count."""
    sections = [("Description", _description(old.game, new.game)), ("Numbers", _numbers(old, new)), ("Map", _map(old.game, new.game))]
    theirs = _declarations(new.composition)
    for title, (block, declared) in _declarations(old.composition).items():
        counted = by_name({"number of agents": w.game.agents.number} for w in (old, new)) if title == "Agents" else []
        sections.append((title, counted + _texts(block, (old.composition, declared), (new.composition, theirs[title][1]))))
    return tuple(Section(title, tuple(changes)) for title, changes in sections if changes)


def by_name(sides: Iterable[Mapping[str, Any]], unit: str = "") -> list[Change]:
    """Returns what is added, removed and different of an old and a new mapping, in the order of the old names, then the new ones."""
    old, new = sides
    names = dict.fromkeys([*old, *new])
    return [Change(name, old.get(name), new.get(name), unit) for name in names if old.get(name) != new.get(name)]


def _description(old: ir.Game, new: ir.Game) -> list[Change]:
    about = [{"name": g.name, "title": g.title, **dict(g.about)} for g in (old, new)]
    cites = [{f"source {i}": text for i, text in enumerate(g.cites, 1)} for g in (old, new)]
    return [*by_name(about), *by_name(cites)]


def _numbers(old: Written, new: Written) -> list[Change]:
    """Returns numbers with another default, entry by entry; other units, limits, and whether they are fixed when compiled."""
    mine, theirs = (_named(w.game) for w in (old, new))
    found: list[Change] = []
    for name in mine | theirs:
        sides = [(side.get(name), w) for side, w in ((mine, old), (theirs, new))]
        both = [(declared, w) for declared, w in sides if declared is not None]
        if len(both) == 2:
            found += by_name((dict(_entries(name, n.value, n.type.by)) for n, _ in both), unit_of(both[1][0]))
            found += by_name(
                {
                    f"{name}, unit": unit_of(n),
                    f"{name}, may be": limits_of(n, w),
                    f"{name}, can be changed": "before compiling" if isinstance(n, ir.Size) else "at any time",
                }
                for n, w in both
            )
        else:
            compared = [(w.composition, {name: (w.composition.constants.get(name),)}) for w in (old, new)]
            found += _texts("", *compared)
    return found


def _named(game: ir.Game) -> dict[str, ir.Size | ir.Param]:
    return {size.name: size for size in game.sizes} | {param.name: param for param in game.params}


def _entries(name: str, value: Any, by: tuple[ir.Level, ...]) -> list[tuple[str, Any]]:
    """Returns a number by its name, the entries of a table each by its own: `spores[red][green]`."""
    if not by:
        return [(name, value)]
    return [pair for key, v in zip(by[0].keys, value, strict=True) for pair in _entries(f"{name}[{key}]", v, by[1:])]


def _map(old: ir.Game, new: ir.Game) -> list[Change]:
    sizes = [f"{len(g.rows)} rows of {len(g.rows[0])} cells" for g in (old, new)]
    cells = [_cells(g) for g in (old, new)]
    found = by_name({"size": size} for size in sizes)
    found += by_name({"edges": "joined" if g.wraps else "walls nobody passes"} for g in (old, new))
    counts = [Counter(kind for row in rows for kind in row) for rows in cells]
    found += by_name({f"cells of {what}": number for what, number in count.items()} for count in counts)
    if sizes[0] == sizes[1]:
        same = sum(a == b for rows in zip(*cells, strict=True) for a, b in zip(*rows, strict=True))
        found += by_name({"cells of the same kind and state": n} for n in (sum(map(len, cells[0])), same))
    return found


def _cells(game: ir.Game) -> list[list[str]]:
    """Returns what stands in each cell of the map: its kind, with the state at the start."""
    meaning = {g.glyph: f"{g.kind} ({starts(g, game)})" if starts(g, game) else g.kind for g in game.glyphs}
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
        title: (block, {name: of if isinstance(of, tuple) else (of,) for name, of in declared.items()})
        for title, (block, declared) in found.items()
    }


def _texts(block: str, old: tuple[Composition, Declared], new: tuple[Composition, Declared]) -> list[Change]:
    """Returns the declarations whose words differ, with their lines as `sjdsl fmt` lays them out."""
    found = []
    for name in {**old[1], **new[1]}:
        before, after = (written_text(composition, declared.get(name, ())) for composition, declared in (old, new))
        if WORD.findall(before) != WORD.findall(after):
            gone, new_lines = laid_out(before, block), laid_out(after, block)
            _, _, *lines = unified_diff(gone, new_lines, n=1, lineterm="")
            marked = [(" ", "…") if line.startswith("@@") else (line[0], line[1:]) for line in lines]
            found.append(Change(name, gone, new_lines, lines=tuple(marked[1:])))
    return found


def name_of(w: Written) -> str:
    """Returns `yard`, `yard, variant crowd`."""
    return w.game.name + (f", variant {'+'.join(w.chosen)}" if w.chosen else "")


def report(old: Written, new: Written) -> str:
    """Returns the differences as text."""
    found = [f"{name_of(old)}  ->  {name_of(new)}"]
    sections = differences(old, new)
    for section in sections:
        found += ["", section.title]
        for change in section.changes:
            found.append(f"  {change.what if change.lines else _sentence(change)}")
            found += [f"    {sign} {line}" for sign, line in change.lines]
    return "\n".join([*found, *([] if sections else ["nothing differs"]), ""])


def _sentence(change: Change) -> str:
    old, new = (number(value) if isinstance(value, int | float) else str(value) for value in (change.old, change.new))
    unit = f" ({change.unit})" if change.unit else ""
    if change.old is None:
        return f"{change.what}: added, {new}{unit}"
    if change.new is None:
        return f"{change.what}: removed, was {old}{unit}"
    return f"{change.what}: {old} -> {new}{unit}"


def as_json(old: Written, new: Written) -> dict[str, Any]:
    """Returns the differences as plain values: of declarations the lines that are gone and new, else the old and new value."""
    games = {
        side: {"game": w.game.name, "file": w.file, "variants": list(w.chosen), "title": w.game.title}
        for side, w in (("old", old), ("new", new))
    }
    found = [{"section": s.title, "changes": [_change(c) for c in s.changes]} for s in differences(old, new)]
    return {**games, "differs": bool(found), "sections": found}


def _change(change: Change) -> dict[str, Any]:
    if change.lines:
        marked = {name: [line.strip() for sign, line in change.lines if sign == mark] for name, mark in (("removed", "-"), ("added", "+"))}
        return {"what": change.what, **marked}
    unit = {"unit": change.unit} if change.unit else {}
    return {"what": change.what, "old": change.old, "new": change.new, **unit}
