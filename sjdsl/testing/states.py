"""Converts a state of the interpreter to the compiled game's, with agents that are away."""

from typing import Any

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_name, attribute_of
from sjdsl.compiler.ir.queries import all_fields, body_sort, contains, phases_of
from sjdsl.compiler.ir.sorts import AGENTS
from sjdsl.compiler.lower.pools import all_pools
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.bodies import herds
from sjdsl.interpreter.state import Away, Facing, Pool, World
from sjdsl.interpreter.stored import stored_values
from sjdsl.runtime.env import Environment

FACINGS: tuple[Facing | None, ...] = ("north", "east", "south", "west", None, "same")


def compiled_state(env: Environment, blank: Any, world: World) -> Any:
    """Returns the compiled state that equals a world without marks, as NumPy arrays. `blank`: any state of the game without marks.

    Raises ValueError for a timer longer than any that the game sets can be.
    """
    state, (_, cols), pad = blank, env.module.FRAME, env.module.PAD
    changed: dict[str, Any] = {"step": world.step, "heading": world.heading}
    numbers = pool_numbers(env.game)
    for sort, herd in herds(world).items():
        poses = {
            "position": [
                0 if p is None else (p.row + pad) * cols + p.col + pad for p in herd.position
            ],
            "moved": herd.moved,
            "away": [a.ticks if a else 0 for a in herd.away],
            "away_pool": [numbers[a.pool] if a and a.pool else 0 for a in herd.away],
            "away_facing": [FACINGS.index(a.facing) if a else 0 for a in herd.away],
        }
        named = {attribute_of(name, sort): values for name, values in poses.items()}
        changed |= {name: values for name, values in named.items() if hasattr(state, name)}
    for declared in all_fields(env.game):
        values, dtype = (
            np.asarray(stored_values(declared, world)),
            getattr(state, attribute_name(declared)).dtype,
        )
        if declared.timer and values.max(initial=0) > np.iinfo(dtype).max:
            raise ValueError(
                f"the timer `{declared.name}` holds up to {np.iinfo(dtype).max} steps in this game, not {values.max()}"
            )
        changed[attribute_name(declared)] = values
    like = {
        name: getattr(state, name) for name in changed
    }  # of no cells, a list does not tell the length of rows
    return state.replace(
        **{
            name: np.asarray(v, like[name].dtype).reshape(like[name].shape)
            for name, v in changed.items()
        }
    )


_numbered: list[tuple[ir.Game, dict[Pool, int]]] = []
KEPT = 8  # games whose numbers are kept: to find them takes a walk over the game


def pool_numbers(game: ir.Game) -> dict[Pool, int]:
    """Returns the numbers by which the compiled state names the destinations of those who are away; those asked for last are kept."""
    for known, numbers in _numbered:
        if known is game:
            return numbers
    numbers = {
        Pool(phase, pool.send.pool): pool.number
        for phase, pools in all_pools(game).items()
        for pool in pools
    }
    _numbered[:] = [(game, numbers), *_numbered[: KEPT - 1]]
    return numbers


def away_pools(game: ir.Game, sort: ir.Sort) -> dict[Pool, ir.Send]:
    """Returns the destinations that agents, or movers of a sort, can be away before, each with a statement that sends there."""
    sends = board_of(game).pools.items()
    return {
        pool: send for pool, send in sends if send.after is not None and body_sort(send.who) == sort
    }


def make_away(
    game: ir.Game, number: int, ticks: int, phase: str | None, sort: ir.Sort = AGENTS
) -> Away:
    """Returns how an agent, or a mover of a sort, is away: for good (0 ticks), or sent by the phase of that name, or by the only one."""
    who = f"{sort.name} {number}"
    if ticks == 0:
        if not contains(game, ir.Remove):
            raise ValueError(
                f"{who}: nobody is removed for good in this game, so give the ticks until it returns"
            )
        return Away(0, None, None)
    pools, labels = away_pools(game, sort), {phase.name: phase.label for phase in phases_of(game)}
    phases = sorted({labels[pool.phase] for pool in pools})
    if ticks < 0:
        raise ValueError(f"{who}: the ticks until it returns are 0 (never) or more, not {ticks}")
    if not phases:
        raise ValueError(f"{who}: nobody is sent away `after` some steps in this game")
    if phase is None and len(phases) > 1:
        raise ValueError(
            f"{who}: say which phase sent it away ({', '.join(phases)}), as ({ticks}, {phases[0]!r})"
        )
    if phase not in (None, *phases):
        raise ValueError(
            f"{who}: no phase `{phase}` sends it away `after` some steps; {', '.join(phases)} can"
        )
    fitting = [(pool, send) for pool, send in pools.items() if phase in (None, labels[pool.phase])]
    if len(fitting) > 1:
        raise ValueError(
            f"{who}: the phase {phase or phases[0]} sends away to several destinations, and a scene can't say to which"
        )
    ((pool, send),) = fitting
    return Away(ticks, pool, send.facing)
