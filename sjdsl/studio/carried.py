"""Carries the state of an episode over to the rules as they are after an edit, as far as it still fits."""

from collections.abc import Mapping
from dataclasses import replace
from itertools import chain
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import all_fields
from sjdsl.interpreter.board import board_of, declared_world
from sjdsl.interpreter.state import Value, World
from sjdsl.interpreter.stored import held_values


def carried(old: ir.Game, world: World, new: ir.Game, params: Mapping[str, Value]) -> World | None:
    """Returns a state of the old rules as one of the new; None if nothing of it fits: another map, other agents or movers.

    A field that is new, or whose type no longer has one of the values, starts as it is declared.
    """
    bodies, other = (
        (game.agents.number, [(m.name, m.number) for m in game.movers]) for game in (old, new)
    )
    if bodies != other or board_of(old).kind_of != board_of(new).kind_of:
        return None
    waiting = chain(world.away, *(herd.away for herd in world.movers.values()))
    if old.schedule != new.schedule and any(
        away is not None and away.pool is not None for away in waiting
    ):
        return None  # where they come back to is known by its place in the rules
    fresh = declared_world(board_of(new), dict(params))
    before = {(field.held_by, field.name): field.type for field in all_fields(old)}
    for field in all_fields(new):
        type_ = before.get((field.held_by, field.name))
        if (
            type_ is None
            or (type_.kind, type_.by) != (field.type.kind, field.type.by)
            or not _fits(held_values(field, world), field.type)
        ):
            continue
        if field.held_by.what == "world":
            fresh.fields[field.name] = world.fields[field.name]
        else:
            held_values(field, fresh)[:] = held_values(field, world)
    herds = {
        sort: replace(fresh.movers[sort], position=h.position, moved=h.moved, away=h.away)
        for sort, h in world.movers.items()
    }
    return replace(
        fresh,
        step=world.step,
        position=world.position,
        heading=world.heading,
        moved=world.moved,
        away=world.away,
        movers=herds,
    )


def _fits(value: Any, type_: ir.Type) -> bool:
    """Returns whether a type has a value, or every value in a list or a row of them."""
    if isinstance(value, list | tuple):
        return all(_fits(entry, type_) for entry in value)
    if type_.kind == "word":
        return value in type_.words
    return type_.kind not in ("int", "real") or type_.low <= value <= type_.high
