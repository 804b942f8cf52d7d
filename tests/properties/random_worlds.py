"""Random states and parameters of a game, many at once: every number at an end of its range, or anywhere between."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from random import Random
from typing import Any

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_name, attribute_of, param_attribute
from sjdsl.compiler.ir.queries import all_fields, kinds_by_glyph
from sjdsl.compiler.ir.values import holds
from sjdsl.compiler.lower import new_module
from sjdsl.interpreter.numbers import real
from tests.fuzz.together import OnNumPy

ALIKE = 32  # worlds with the same parameters
COUNTS, WORTHS = (
    (0, 1, 2, 7, 1000, 2**31 - 1),
    (0.0, 0.1, -0.1, 1.0, 0.3, -2.5, 1000.0, 2.0**30),
)  # of what has no limit
HELD = (
    0,
    1,
    -1,
    0.1,
    0.3,
    -7.7,
    1000,
    3e38,
    np.inf,
    -np.inf,
    np.nan,
)  # by a field of reals, which may have left float32
TIMES = (0, 0, 1, 2, 9, 250)


@dataclass(frozen=True)
class Worlds:
    """Arrays of states and of parameters by name, each with an axis of worlds in front; `ALIKE` after each other have the same parameters."""

    state: dict[str, np.ndarray]
    params: dict[str, np.ndarray]


def random_params(
    game: ir.Game, random: Random, counts: Sequence[int] = COUNTS[:-1]
) -> dict[str, Any]:
    """Returns a value for each parameter, within their limits and as every `require` wants it; as the file has them if none is found.

    counts: some values of whole numbers without a limit; by default none with which play leaves int32.
    """
    own = {p.name: p.value for p in game.params}
    requires = [c.values[0] for c in game.checks if c.kind == "require"]
    for _ in range(40):
        changed = own | {
            p.name: _value(p.value, p.type, random, counts)
            for p in game.params
            if random.random() < 0.8
        }
        if all(holds(test, changed) for test in requires):
            return changed
    return own


def _value(own: Any, type_: ir.Type, random: Random, counts: Sequence[int]) -> Any:
    if type_.indexed_by:
        inner = type_.model_copy(update={"indexed_by": type_.indexed_by[1:]})
        return tuple(_value(entry, inner, random, counts) for entry in own)
    if type_.kind == "word":
        return random.choice(type_.words)
    low, high = type_.low, type_.high
    some = (
        [x for x in (counts if type_.kind == "int" else WORTHS) if low <= x <= high]
        if random.random() < 0.3
        else []
    )
    ends = [x for x in (low, high) if abs(x) < 2**31]
    if len(ends) == 2:
        ends.append(
            random.uniform(low, high)
            if type_.kind == "real"
            else random.randint(int(low), int(high))
        )
    value = random.choice([own, *ends, *some])
    return int(value) if type_.kind == "int" else float(value)


def encoded(game: ir.Game, values: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """Returns parameters as a module has them."""
    dtypes = {"int": np.int32, "real": np.float32, "word": np.uint8}

    def inside(value: Any, type_: ir.Type) -> Any:
        if isinstance(value, tuple):
            return [inside(entry, type_) for entry in value]
        return type_.words.index(value) if type_.kind == "word" else value

    return {
        param_attribute(p.name): np.asarray(inside(values[p.name], p.type), dtypes[p.type.kind])
        for p in game.params
    }


def as_interpreted(game: ir.Game, values: Mapping[str, Any]) -> dict[str, Any]:
    """Returns parameters as the interpreter has them: reals as float32."""
    return {
        p.name: real(values[p.name]) if p.type.kind == "real" else values[p.name]
        for p in game.params
    }


def random_worlds(env: OnNumPy, game: ir.Game, random: Random, number: int) -> Worlds:
    """Returns so many worlds in which every field has a value of its type, and agents and movers stand anywhere or are away."""
    rng = np.random.default_rng(random.getrandbits(32))
    first = vars(env.module.initial_state())
    state = {
        name: np.repeat(np.asarray(value)[None], number, 0)
        for name, value in first.items()
        if not name.startswith("mark_")
    }
    for declared in all_fields(game):
        name = attribute_name(declared)
        if name in state:
            state[name] = _held(declared, game, state[name], rng)
    state["step"] = rng.choice([0, 1, 5, 199], number).astype(state["step"].dtype)
    _place(state, game, rng)
    sets = [encoded(game, random_params(game, random, COUNTS)) for _ in range(-(-number // ALIKE))]
    return Worlds(
        state,
        {
            name: np.repeat(np.stack([one[name] for one in sets]), ALIKE, 0)[:number]
            for name in sets[0]
        },
    )


def _held(
    declared: ir.VarField, game: ir.Game, like: np.ndarray, rng: np.random.Generator
) -> np.ndarray:
    """Returns values of a field, in each world all least, all greatest, or any."""
    type_, shape = declared.type, like.shape
    match type_.kind:
        case "real":
            return rng.choice(np.array(HELD, np.float32), shape)
        case "agents":
            return rng.integers(0, 2 ** min(game.agents.number, 32), shape).astype(like.dtype)
        case "cell":
            glyphs = kinds_by_glyph(game)
            cells = [
                256 * r + c
                for r, row in enumerate(game.rows)
                for c, glyph in enumerate(row)
                if glyphs[glyph] in type_.kinds
            ]
            return rng.choice(np.array([-1, *cells]), shape).astype(like.dtype)
        case "word":
            low, high = 0, len(type_.words) - 1
        case "agent":
            low, high = -1, game.agents.number - 1
        case _ if declared.timer:
            return rng.choice(np.array(TIMES), shape).astype(like.dtype)
        case _:
            low, high = int(type_.low), int(type_.high)
    anything = rng.integers(low, high + 1, shape)
    which = rng.integers(0, 4, (shape[0],) + (1,) * (len(shape) - 1))
    return np.where(which == 0, low, np.where(which == 1, high, anything)).astype(like.dtype)


def _place(state: dict[str, np.ndarray], game: ir.Game, rng: np.random.Generator) -> None:
    """Gives agents and movers cells of their own, and other headings; some are away."""
    layout, number = new_module(game).layout, len(state["step"])
    cells = np.array(
        [
            (r + layout.pad) * layout.cols + c + layout.pad
            for r, row in enumerate(game.rows)
            for c in range(len(row))
        ]
    )
    order = np.argsort(rng.random((number, len(cells))), axis=1)
    taken = 0
    for sort, many in (
        (ir.EntityType("agent"), game.agents.number),
        *((movers.entity_type, movers.number) for movers in game.movers),
    ):
        position, away, heading = (
            attribute_of(name, sort) for name in ("position", "away", "heading")
        )
        there = cells[order[:, taken : taken + many]]
        taken += many
        if away in state:
            gone = (rng.random((number, 1)) < 0.3) & (rng.random((number, many)) < 0.6)
            state[away] = np.where(gone, rng.integers(0, 4, gone.shape), 0).astype(
                state[away].dtype
            )
            there = np.where(gone, 0, there)
        state[position] = there.astype(state[position].dtype)
        if heading in state:
            state[heading] = rng.integers(0, 4, state[heading].shape).astype(state[heading].dtype)
        if attribute_of("moved", sort) in state:
            state[attribute_of("moved", sort)] = rng.random((number, many)) < 0.5
