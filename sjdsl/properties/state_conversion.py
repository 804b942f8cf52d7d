"""Converts a state of the compiled game to the interpreter's, so that the interpreter can go on from it."""

from typing import Any

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_name, attribute_of
from sjdsl.compiler.ir.sorts import AGENTS
from sjdsl.interpreter.state import Away, Cell, Herd, Value, World, default_params
from sjdsl.runtime.env import Environment
from sjdsl.testing.states import FACINGS, pool_numbers


def world_of(env: Environment, state: Any, params: dict[str, Value] | None = None) -> World:
    """Returns a compiled state, without its marks, as a world of the interpreter; `params`: other ones than those of the file."""
    game = env.game
    agents = _herd(AGENTS, (), env, state)
    return World(
        step=int(state.step),
        cells={(k.name, f.name): _many(state, f) for k in game.kinds for f in k.fields},
        agents={f.name: _many(state, f) for f in game.agents.fields},
        fields={
            f.name: _held(np.asarray(getattr(state, attribute_name(f))), f.type)
            for f in game.fields
        },
        position=agents.position,
        heading=np.asarray(state.heading).tolist(),
        moved=agents.moved,
        away=agents.away,
        marks=[],
        params=default_params(game) if params is None else params,
        movers={sort.name: _herd(sort.sort, sort.fields, env, state) for sort in game.movers},
    )


def _herd(sort: ir.Sort, fields: tuple[ir.VarField, ...], env: Environment, state: Any) -> Herd:
    """Returns where the agents, or the movers of a sort, are."""
    (_, cols), pad = env.module.FRAME, env.module.PAD
    at = np.asarray(getattr(state, attribute_of("position", sort))).tolist()
    moved = getattr(state, attribute_of("moved", sort), None)
    return Herd(
        position=[Cell(p // cols - pad, p % cols - pad) if p else None for p in at],
        moved=[False] * len(at) if moved is None else np.asarray(moved).tolist(),
        away=[
            None if p else away
            for p, away in zip(at, _away(env, state, sort, len(at)), strict=True)
        ],
        fields={field.name: _many(state, field) for field in fields},
    )


def _many(state: Any, declared: ir.VarField) -> list[Value]:
    return [
        _held(entry, declared.type)
        for entry in np.asarray(getattr(state, attribute_name(declared)))
    ]


def _held(stored: np.ndarray, type_: ir.Type) -> Value:
    """Returns a stored value as the interpreter holds it."""
    if type_.by:
        inner = type_.model_copy(update={"by": type_.by[1:]})
        return tuple(_held(entry, inner) for entry in stored)
    match type_.kind:
        case "word":
            return type_.words[int(stored)]
        case "agent":
            return None if stored < 0 else int(stored)
        case "cell":
            return None if stored < 0 else Cell(*divmod(int(stored), 256))
        case "agents":
            words = enumerate(np.atleast_1d(stored).tolist())  # large sets are kept in several
            return frozenset(
                32 * number + bit for number, word in words for bit in range(32) if word >> bit & 1
            )
        case "real":
            return np.float32(stored)
        case _:
            return int(stored)


def _away(env: Environment, state: Any, sort: ir.Sort, many: int) -> list[Away]:
    names = [attribute_of(name, sort) for name in ("away", "away_pool", "away_facing")]
    if not hasattr(state, names[0]):
        return [Away(0, None, None)] * many
    pools = {number: pool for pool, number in pool_numbers(env.game).items()}
    told = zip(*(np.asarray(getattr(state, name)).tolist() for name in names), strict=True)
    return [
        Away(ticks, pools[pool], FACINGS[facing]) if ticks else Away(0, None, None)
        for ticks, pool, facing in told
    ]
