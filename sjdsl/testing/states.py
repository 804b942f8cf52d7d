"""Converts a state of the interpreter, with agents that are away, to one of the compiled game."""

from typing import Any

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.entity_types import AGENTS
from sjdsl.compiler.ir.names import attribute_name, attribute_of
from sjdsl.compiler.ir.queries import all_fields, body_type, contains, phases_of
from sjdsl.compiler.lower.pools import all_pools
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.bodies import herds
from sjdsl.interpreter.state import Away, Facing, Pool, World
from sjdsl.interpreter.stored import stored_values
from sjdsl.runtime.env import Environment

FACINGS: tuple[Facing | None, ...] = ("north", "east", "south", "west", None, "same")


def compiled_state(env: Environment, blank: Any, world: World) -> Any:
    """Returns the compiled state that equals a world without marks, as NumPy arrays.

    `blank` is any state of the game without marks. Raises ValueError for a timer that doesn't fit
    its dtype, which is wide enough for every value that the game sets.
    """
    _, cols = env.module.FRAME
    pad = env.module.PAD
    values: dict[str, Any] = {"step": world.step, "heading": world.heading}  # by attribute
    numbers = pool_numbers(env.game)
    for entity_type, herd in herds(world).items():
        bodies = {
            "position": [
                0 if place is None else (place.row + pad) * cols + place.col + pad
                for place in herd.position
            ],
            "moved": herd.moved,
            "away": [away.ticks if away else 0 for away in herd.away],
            "away_pool": [numbers[away.pool] if away and away.pool else 0 for away in herd.away],
            "away_facing": [FACINGS.index(away.facing) if away else 0 for away in herd.away],
        }
        for name, column in bodies.items():
            if hasattr(blank, attribute_of(name, entity_type)):
                values[attribute_of(name, entity_type)] = column
    for declared in all_fields(env.game):
        stored = np.asarray(stored_values(declared, world))
        dtype = getattr(blank, attribute_name(declared)).dtype
        if declared.timer and stored.max(initial=0) > np.iinfo(dtype).max:
            raise ValueError(
                f"the timer `{declared.name}` holds up to {np.iinfo(dtype).max} steps in this "
                f"game, not {stored.max()}"
            )
        values[attribute_name(declared)] = stored
    arrays = {}
    for name, value in values.items():
        blank_value = getattr(blank, name)
        # An empty list of rows doesn't have the length of the rows.
        arrays[name] = np.asarray(value, blank_value.dtype).reshape(blank_value.shape)
    return blank.replace(**arrays)


_pool_numbers: list[tuple[ir.Game, dict[Pool, int]]] = []  # of the games asked for last
CACHE_SIZE = 8  # games: computing the numbers takes a walk over the game


def pool_numbers(game: ir.Game) -> dict[Pool, int]:
    """Returns the numbers of the destinations of those who are away, in the compiled state.

    They are cached for the games asked for last.
    """
    for cached, numbers in _pool_numbers:
        if cached is game:
            return numbers
    numbers = {
        Pool(phase, pool.send.pool): pool.number
        for phase, pools in all_pools(game).items()
        for pool in pools
    }
    _pool_numbers[:] = [(game, numbers), *_pool_numbers[: CACHE_SIZE - 1]]
    return numbers


def away_pools(game: ir.Game, entity_type: ir.EntityType) -> dict[Pool, ir.Send]:
    """Returns the destinations for which agents, or movers of an entity type, can be away.

    Each with a statement that sends to it.
    """
    sends = board_of(game).pools.items()
    return {
        pool: send
        for pool, send in sends
        if send.after is not None and body_type(send.who) == entity_type
    }


def make_away(
    game: ir.Game, number: int, ticks: int, phase: str | None, entity_type: ir.EntityType = AGENTS
) -> Away:
    """Returns how an agent, or a mover of an entity type, is away.

    Args:
      ticks: until it returns; 0: for good.
      phase: the label of the phase that sent it away; None if only one can.
    Raises:
      ValueError: the game never sends it away so.
    """
    who = f"{entity_type.name} {number}"
    if ticks == 0:
        if not contains(game, ir.Remove):
            raise ValueError(
                f"{who}: nobody is removed for good in this game, "
                "so give the ticks until it returns"
            )
        return Away(0, None, None)
    pools = away_pools(game, entity_type)
    labels = {phase.name: phase.label for phase in phases_of(game)}
    phases = sorted({labels[pool.phase] for pool in pools})
    if ticks < 0:
        raise ValueError(f"{who}: the ticks until it returns are 0 (never) or more, not {ticks}")
    if not phases:
        raise ValueError(f"{who}: nobody is sent away `after` some steps in this game")
    if phase is None and len(phases) > 1:
        raise ValueError(
            f"{who}: say which phase sent it away ({', '.join(phases)}), "
            f"as ({ticks}, {phases[0]!r})"
        )
    if phase not in (None, *phases):
        raise ValueError(
            f"{who}: no phase `{phase}` sends it away `after` some steps; {', '.join(phases)} can"
        )
    fitting = [(pool, send) for pool, send in pools.items() if phase in (None, labels[pool.phase])]
    if len(fitting) > 1:
        raise ValueError(
            f"{who}: the phase {phase or phases[0]} sends away to several destinations, "
            "and a scene can't say to which"
        )
    ((pool, send),) = fitting
    return Away(ticks, pool, send.facing if send.way is None else "same")
