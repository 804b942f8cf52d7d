"""Converts a state of the compiled game to the interpreter's, so that the interpreter can go on from it."""

from typing import Any

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_name
from sjdsl.interpreter.state import Away, Cell, Value, World, default_params
from sjdsl.runtime.env import Environment
from sjdsl.testing.states import FACINGS, pool_numbers


def world_of(env: Environment, state: Any) -> World:
    """Returns a compiled state, without its marks, as a world of the interpreter with the parameters of the file."""
    game = env.game
    rows, cols = (np.asarray(x).tolist() for x in env.cells(state))
    here = (np.asarray(state.position) > 0).tolist()
    return World(
        step=int(state.step),
        cells={(k.name, f.name): _many(state, f) for k in game.kinds for f in k.fields},
        agents={f.name: _many(state, f) for f in game.agents.fields},
        fields={f.name: _held(np.asarray(getattr(state, attribute_name(f))), f.type) for f in game.fields},
        position=[Cell(r, c) if at else None for r, c, at in zip(rows, cols, here, strict=True)],
        heading=np.asarray(state.heading).tolist(),
        moved=np.asarray(state.moved).tolist() if hasattr(state, "moved") else [False] * env.num_agents,
        away=[None if at else away for at, away in zip(here, _away(env, state), strict=True)],
        marks=[],
        params=default_params(game),
    )


def _many(state: Any, declared: ir.VarField) -> list[Value]:
    return [_held(entry, declared.type) for entry in np.asarray(getattr(state, attribute_name(declared)))]


def _held(stored: np.ndarray, type_: ir.Type) -> Value:
    """Returns a stored value as the interpreter holds it."""
    if stored.ndim:
        return tuple(_held(entry, type_) for entry in stored)
    match type_.kind:
        case "word":
            return type_.words[int(stored)]
        case "agent":
            return None if stored < 0 else int(stored)
        case "cell":
            return None if stored < 0 else Cell(*divmod(int(stored), 256))
        case "agents":
            return frozenset(agent for agent in range(32) if int(stored) >> agent & 1)
        case "real":
            return np.float32(stored)
        case _:
            return int(stored)


def _away(env: Environment, state: Any) -> list[Away]:
    if not hasattr(state, "away"):
        return [Away(0, None, None)] * env.num_agents
    pools = {number: pool for pool, number in pool_numbers(env.game).items()}
    told = zip(*(np.asarray(x).tolist() for x in (state.away, state.away_pool, state.away_facing)), strict=True)
    return [Away(ticks, pools[pool], FACINGS[facing]) if ticks else Away(0, None, None) for ticks, pool, facing in told]
