"""A state, what a step gave, and what is seen, under a symmetry; and where two of them differ."""

from dataclasses import replace
from typing import Any

import numpy as np

from sjdsl.compiler import ir
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.planes import Plane, planes
from sjdsl.interpreter.state import Herd, Outcome, Value, World
from tests.laws.symmetry import Symmetry

CLOSE = {"rtol": 1e-5, "atol": 1e-5}  # sums of reals are added in another order
MIRRORED = np.array(
    [0, 1, 2, 5, 4, 3, 6], np.uint8
)  # of the plane of agents: who is turned right is turned left; the last shows no heading
MIRRORED_MOVER = np.array(
    [0, 1, 4, 3, 2, 5], np.uint8
)  # of a plane of the headings of movers; the last is hidden


def other_world(game: ir.Game, changed: ir.Game, world: World, s: Symmetry) -> World:
    """Returns a state of a game as a state of the game under the symmetry."""
    before, after = board_of(game), board_of(changed)
    cells = {}
    for (kind, name), values in world.cells.items():
        type_ = before.fields[kind, name].type
        moved = {
            after.number[s.cell(cell)]: _value(v, type_, s)
            for cell, v in zip(before.cells[kind], values, strict=True)
        }
        cells[kind, name] = [moved[number] for number in range(len(values))]
    return replace(
        world,
        cells=cells,
        agents={
            n: _agents([_value(v, before.fields["agent", n].type, s) for v in values], s)
            for n, values in world.agents.items()
        },
        fields={n: _value(v, before.fields["world", n].type, s) for n, v in world.fields.items()},
        position=_agents([None if p is None else s.cell(p) for p in world.position], s),
        heading=_agents([s.heading(h) for h in world.heading], s),
        moved=_agents(world.moved, s),
        away=_agents(
            [None if a is None else a._replace(facing=s.facing(a.facing)) for a in world.away], s
        ),
        movers={sort: _herd(sort, herd, game, s) for sort, herd in world.movers.items()},
        marks=[(phase, *s.cell((row, col))) for phase, row, col in world.marks],
    )


def _herd(sort: str, herd: Herd, game: ir.Game, s: Symmetry) -> Herd:
    """Returns movers, which keep their numbers."""
    fields = {
        n: [_value(v, board_of(game).fields[sort, n].type, s) for v in values]
        for n, values in herd.fields.items()
    }
    return Herd(
        position=[None if p is None else s.cell(p) for p in herd.position],
        moved=herd.moved,
        away=[None if a is None else a._replace(facing=s.facing(a.facing)) for a in herd.away],
        fields=fields | {"heading": [s.facing(heading) for heading in herd.fields["heading"]]},
    )


def other_outcome(game: ir.Game, outcome: Outcome, s: Symmetry) -> Outcome:
    """Returns what a step gave, to the agents by their new numbers."""
    per_agent = {e.name for e in game.events if e.per_agent}
    entries = {e.name for e in game.events if e.by and e.by.kind == "agent"}
    events = outcome.events | {
        n: [_agents(row, s) for row in outcome.events[n]] for n in entries & per_agent
    }
    events |= {n: _agents(events[n], s) for n in entries - per_agent}
    events |= {n: _agents(events[n], s) for n in per_agent}
    return replace(outcome, reward=_agents(outcome.reward, s), events=events)


def other_view(game: ir.Game, picture: np.ndarray, s: Symmetry) -> np.ndarray:
    """Returns what is seen: in a mirror the window's columns are swapped, and who is turned right is turned left."""
    seen = np.asarray(_agents(list(picture), s))
    shown = planes(game)
    names = [p.name for p in shown]
    for number, plane in enumerate(
        shown
    ):  # of every agent, or an entry for every agent, in the order of their numbers
        if (renamed := _renamed(plane, s)) != plane.name:
            seen[:, names.index(renamed)] = np.asarray(_agents(list(picture[:, number]), s))
    if not s.mirror:
        return seen
    for number, plane in enumerate(shown):
        if (
            plane.what == "mover"
            and (of := plane.observable) is not None
            and of.field == "heading"
            and not of.labels
        ):
            seen[:, number] = MIRRORED_MOVER[seen[:, number]]
    seen = seen[..., ::-1].copy()
    number = names.index("agent")
    seen[:, number] = MIRRORED[seen[:, number]]
    return seen


def _renamed(plane: Plane, s: Symmetry) -> str:
    """Returns the name of the plane that shows the same of the agents under their new numbers."""
    name, entry = plane.name, None if plane.observable is None else plane.observable.word
    if plane.agent is not None:
        name = name.replace(f"[{plane.agent}]", f"[{s.order[plane.agent]}]", 1)
    if entry is not None and entry.index_set.kind == "agent":
        name = f"{name.removesuffix(f'[{entry.key}]')}[{s.order[entry.place]}]"
    return name


def world_differences(mine: World, theirs: World) -> list[str]:
    """Returns the parts of two states that differ, marks taken as a set."""
    found = []
    for name in (
        "step",
        "cells",
        "agents",
        "fields",
        "position",
        "heading",
        "moved",
        "away",
        "movers",
    ):
        a, b = getattr(mine, name), getattr(theirs, name)
        if not _same(a, b):
            found.append(f"{name}: {a} / {b}")
    if set(mine.marks) != set(theirs.marks):
        found.append(f"marks: {mine.marks} / {theirs.marks}")
    return found


def outcome_differences(mine: Outcome, theirs: Outcome) -> list[str]:
    return [
        f"{name}: {getattr(mine, name)} / {getattr(theirs, name)}"
        for name in ("reward", "events", "measures", "truncated", "terminated")
        if not _same(getattr(mine, name), getattr(theirs, name))
    ]


def _agents(values: list[Any], s: Symmetry) -> list[Any]:
    return [values[s.order.index(number)] for number in range(len(values))]


def _value(value: Value, type_: ir.Type, s: Symmetry) -> Value:
    """Returns a value of a field, which may name agents and cells."""
    if type_.kind == "cell" and not type_.indexed_by:
        return None if value is None else s.cell(value)
    if isinstance(value, tuple):
        inner = type_.model_copy(update={"indexed_by": type_.indexed_by[1:]})
        entries = [_value(v, inner, s) for v in value]
        return tuple(_agents(entries, s) if type_.indexed_by[0].kind == "agent" else entries)
    match type_.kind:
        case "agents":
            return frozenset(s.order[agent] for agent in value)
        case "agent":
            return None if value is None else s.order[value]
        case _:
            return value


def _same(a: Any, b: Any) -> bool:
    match a:
        case Herd():
            return _same(vars(a), vars(b))
        case dict():
            return a.keys() == b.keys() and all(_same(v, b[k]) for k, v in a.items())
        case list() | tuple():
            return len(a) == len(b) and all(_same(x, y) for x, y in zip(a, b, strict=True))
        case float() | np.floating():
            return bool(np.isclose(a, b, **CLOSE))
        case _:
            return a == b
