"""Converts a state of the compiled game to the interpreter's, which can go on from it."""

from typing import Any

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.entity_types import AGENTS
from sjdsl.compiler.ir.names import attribute_name, attribute_of
from sjdsl.interpreter.state import Away, Cell, Herd, Value, World, default_params
from sjdsl.interpreter.stored import loaded
from sjdsl.runtime.env import Environment
from sjdsl.testing.states import FACINGS, pool_numbers


def world_of(env: Environment, state: Any, params: dict[str, Value] | None = None) -> World:
    """Returns a compiled state, without its marks, as a world of the interpreter.

    Args:
      params: by default those of the file.
    """
    game = env.game
    agents = _herd(AGENTS, (), env, state)
    return World(
        step=int(state.step),
        cells={(k.name, f.name): _entries(state, f) for k in game.kinds for f in k.fields},
        agents={f.name: _entries(state, f) for f in game.agents.fields},
        fields={f.name: loaded(np.asarray(_stored(state, f)), f.type) for f in game.fields},
        position=agents.position,
        heading=np.asarray(state.heading).tolist(),
        moved=agents.moved,
        away=agents.away,
        marks=[],
        params=default_params(game) if params is None else params,
        movers={
            movers.name: _herd(movers.entity_type, movers.fields, env, state)
            for movers in game.movers
        },
    )


def _herd(
    entity_type: ir.EntityType, fields: tuple[ir.VarField, ...], env: Environment, state: Any
) -> Herd:
    """Returns where the agents, or the movers of a type, are."""
    _, cols = env.module.FRAME
    pad = env.module.PAD
    cells = np.asarray(getattr(state, attribute_of("position", entity_type))).tolist()
    moved = getattr(state, attribute_of("moved", entity_type), None)
    away = _away(env, state, entity_type, len(cells))
    return Herd(
        position=[Cell(cell // cols - pad, cell % cols - pad) if cell else None for cell in cells],
        moved=[False] * len(cells) if moved is None else np.asarray(moved).tolist(),
        away=[None if cell else one for cell, one in zip(cells, away, strict=True)],
        fields={field.name: _entries(state, field) for field in fields},
    )


def _stored(state: Any, field: ir.VarField) -> Any:
    return getattr(state, attribute_name(field))


def _entries(state: Any, field: ir.VarField) -> list[Value]:
    """Returns the values of a field, one for each of its owners."""
    return [loaded(entry, field.type) for entry in np.asarray(_stored(state, field))]


def _away(env: Environment, state: Any, entity_type: ir.EntityType, number: int) -> list[Away]:
    """Returns when and where each agent, or mover of a type, comes back if it is away."""
    for_good = Away(0, None, None)
    names = [attribute_of(name, entity_type) for name in ("away", "away_pool", "away_facing")]
    if not hasattr(state, names[0]):
        return [for_good] * number
    pools = {number: pool for pool, number in pool_numbers(env.game).items()}
    columns = [np.asarray(getattr(state, name)).tolist() for name in names]
    return [
        Away(ticks, pools[pool], FACINGS[facing]) if ticks else for_good
        for ticks, pool, facing in zip(*columns, strict=True)
    ]
