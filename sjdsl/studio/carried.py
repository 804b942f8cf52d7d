"""Carries the state of an episode over to the rules as they are after an edit, as far as it still fits."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import chain
from typing import Any

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import all_fields
from sjdsl.interpreter.board import board_of, declared_world
from sjdsl.interpreter.state import Cell, Value, World
from sjdsl.interpreter.stored import held_values


def carried(old: ir.Game, world: World, new: ir.Game, params: Mapping[str, Value]) -> World | None:
    """Returns a state of the old rules as one of the new; None if nothing of it fits: another map, other agents or movers.

    A field that is new, or whose type no longer has one of the values, starts as it is declared.
    """
    bodies, other = ((game.agents.number, [(m.name, m.number) for m in game.movers]) for game in (old, new))
    if bodies != other or board_of(old).kind_of != board_of(new).kind_of:
        return None
    waiting = chain(world.away, *(herd.away for herd in world.movers.values()))
    if old.schedule != new.schedule and any(away is not None and away.pool is not None for away in waiting):
        return None  # where they come back to is known by its place in the rules
    fresh = declared_world(board_of(new), dict(params))
    levels = {(field.held_by, field.name): field.type.by for field in all_fields(old)}
    for field in all_fields(new):
        if levels.get((field.held_by, field.name)) == field.type.by:
            values = held_values(field, world)
            if all(_fits(value, field.type) for value in _flat(values)):
                _put(field, values, fresh)
    herds = {sort: replace(fresh.movers[sort], position=h.position, moved=h.moved, away=h.away) for sort, h in world.movers.items()}
    return replace(fresh, step=world.step, position=world.position, heading=world.heading, moved=world.moved, away=world.away, movers=herds)


def _put(field: ir.VarField, values: Any, world: World) -> None:
    match field.held_by.what:
        case "cell":
            world.cells[field.held_by.name, field.name] = list(values)
        case "agent":
            world.agents[field.name] = list(values)
        case "mover":
            world.movers[field.held_by.name].fields[field.name] = list(values)
        case _:
            world.fields[field.name] = values


def _flat(values: Any) -> Iterator[Value]:
    """Yields the single values of a field: of all who have it, and of all entries of a row."""
    if isinstance(values, list) or (isinstance(values, tuple) and not isinstance(values, Cell)):
        for value in values:
            yield from _flat(value)
    else:
        yield values


def _fits(value: Value, type_: ir.Type) -> bool:
    match type_.kind:
        case "word":
            return value in type_.words
        case "int":
            return isinstance(value, int) and type_.low <= value <= type_.high
        case "real":
            return isinstance(value, np.floating | float) and type_.low <= float(value) <= type_.high
        case "agents":
            return isinstance(value, frozenset)
        case "cell":
            return value is None or isinstance(value, Cell)
        case _:
            return value is None or (isinstance(value, int) and not isinstance(value, bool))
