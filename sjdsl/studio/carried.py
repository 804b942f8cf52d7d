"""Carries the state of an episode over to edited rules, as far as it fits them."""

from collections.abc import Mapping
from dataclasses import replace
from itertools import chain
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import all_fields
from sjdsl.interpreter.board import board_of, declared_world
from sjdsl.interpreter.state import Value, World
from sjdsl.interpreter.stored import held_values


def carry_over(
    old: ir.Game, world: World, new: ir.Game, params: Mapping[str, Value]
) -> World | None:
    """Returns a state of the old rules as one of the new; None if it doesn't fit at all.

    The map and the numbers of agents and movers have to be the same. A field that is new, or whose
    type has lost one of its values, starts as it is declared.
    """
    if _bodies(old) != _bodies(new) or board_of(old).kind_of != board_of(new).kind_of:
        return None
    if old.schedule != new.schedule:
        for away in chain(world.away, *(herd.away for herd in world.movers.values())):
            if away is not None and away.pool is not None:
                return None  # it comes back to a place known by its position in the old rules
    carried_world = declared_world(board_of(new), dict(params))
    old_types = {(field.held_by, field.name): field.type for field in all_fields(old)}
    for field in all_fields(new):
        old_type = old_types.get((field.held_by, field.name))
        if old_type is None or (old_type.kind, old_type.indexed_by) != (
            field.type.kind,
            field.type.indexed_by,
        ):
            continue
        values = held_values(field, world)
        if not _fits(values, field.type):
            continue
        if field.held_by.what == "world":
            carried_world.fields[field.name] = values
        else:
            held_values(field, carried_world)[:] = values
    herds = {
        name: replace(
            carried_world.movers[name], position=herd.position, moved=herd.moved, away=herd.away
        )
        for name, herd in world.movers.items()
    }
    return replace(
        carried_world,
        step=world.step,
        position=world.position,
        heading=world.heading,
        moved=world.moved,
        away=world.away,
        movers=herds,
    )


def _bodies(game: ir.Game) -> tuple[int, list[tuple[str, int]]]:
    """Returns the number of agents, and the number of movers of each type."""
    return game.agents.number, [(mover.name, mover.number) for mover in game.movers]


def _fits(value: Any, type_: ir.Type) -> bool:
    """Returns whether a value, or each one in a list, belongs to a type."""
    if isinstance(value, list | tuple):
        return all(_fits(entry, type_) for entry in value)
    if type_.kind == "word":
        return value in type_.words
    return type_.kind not in ("int", "real") or type_.low <= value <= type_.high
