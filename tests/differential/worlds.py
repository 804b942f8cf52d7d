"""A state of the compiled step as the interpreter has it: so either can go on from wherever the other has come to."""

from typing import Any

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_name
from sjdsl.interpreter.state import Away, Cell, Herd, Pool, World
from sjdsl.runtime.env import Environment
from sjdsl.testing.states import FACINGS, pool_numbers


def world_of(env: Environment, state: Any, params: dict[str, Any]) -> World:
    """Returns the state without its marks, which no rule reads. `params`: as the interpreter has them."""
    game, (_, cols), pad = env.game, env.module.FRAME, env.module.PAD
    position = [
        Cell(int(p) // cols - pad, int(p) % cols - pad) if p else None for p in state.position
    ]
    return World(
        step=int(state.step),
        cells={
            (k.name, f.name): [held(v, f.type) for v in stored(state, f)]
            for k in game.kinds
            for f in k.fields
        },
        agents={f.name: [held(v, f.type) for v in stored(state, f)] for f in game.agents.fields},
        fields={f.name: held(stored(state, f), f.type) for f in game.fields},
        position=position,
        heading=[int(h) for h in state.heading],
        moved=[bool(m) for m in state.moved]
        if hasattr(state, "moved")
        else [False] * env.num_agents,
        away=[None if place else away(env, state, agent) for agent, place in enumerate(position)],
        marks=[],
        params=params,
        movers={sort.name: herd(env, state, sort) for sort in game.movers},
    )


def herd(env: Environment, state: Any, sort: ir.Movers) -> Herd:
    """Returns all movers of a sort."""
    (_, cols), pad, many = env.module.FRAME, env.module.PAD, range(sort.number)
    position = [
        Cell(int(p) // cols - pad, int(p) % cols - pad) if p else None
        for p in getattr(state, f"{sort.name}_position")
    ]
    return Herd(
        position=position,
        moved=[bool(m) for m in getattr(state, f"{sort.name}_moved", [False for _ in many])],
        away=[
            None if place else away(env, state, number, f"{sort.name}_away")
            for number, place in enumerate(position)
        ],
        fields={f.name: [held(v, f.type) for v in stored(state, f)] for f in sort.fields},
    )


def away(env: Environment, state: Any, agent: int, name: str = "away") -> Away:
    """Returns how an agent (or a mover, whose attributes begin with `name`) without a place waits."""
    ticks = int(getattr(state, name)[agent]) if hasattr(state, name) else 0
    if ticks == 0:
        return Away(0, None, None)
    pools: dict[int, Pool] = {number: pool for pool, number in pool_numbers(env.game).items()}
    return Away(
        ticks,
        pools[int(getattr(state, f"{name}_pool")[agent])],
        FACINGS[int(getattr(state, f"{name}_facing")[agent])],
    )


def stored(state: Any, declared: ir.VarField) -> np.ndarray:
    return np.asarray(getattr(state, attribute_name(declared)))


def held(value: np.ndarray, type_: ir.Type) -> Any:
    """Returns one value as the interpreter holds it."""
    if type_.indexed_by:
        inner = type_.model_copy(update={"indexed_by": type_.indexed_by[1:]})
        return tuple(held(entry, inner) for entry in value)
    match type_.kind:
        case "word":
            return type_.words[int(value)]
        case "agent":
            return None if value < 0 else int(value)
        case "cell":
            return None if value < 0 else Cell(*divmod(int(value), 256))
        case "agents":
            together = sum(
                int(word) << 32 * number for number, word in enumerate(np.atleast_1d(value))
            )
            return frozenset(agent for agent in range(64) if together >> agent & 1)
        case "real":
            return np.float32(value)
        case _:
            return int(value)
