"""One moment of an episode, as everything that shows a board reads it: the state as NumPy arrays, and the step that led to it."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import attribute_name
from sjdsl.compiler.ir.queries import all_fields, counts_of, marking_phases
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.evaluate import evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.planes import planes
from sjdsl.interpreter.state import Cell, Outcome, World
from sjdsl.interpreter.step import action_mask
from sjdsl.interpreter.stored import stored_values

if TYPE_CHECKING:  # states of the interpreter are shown without JAX
    from sjdsl.runtime.env import Environment


@dataclass(frozen=True)
class Snapshot:
    """The state at one moment of an episode.

    values: attribute of the state -> array; row, col: `[N]` int, negative for agents that are away; heading: `[N]` int;
    held: `[N]` bool, agents that may only stay; returns: `[N]` float, rewards so far. movers: sort -> rows and columns of its movers,
    `[M]` int each, negative for those that are away; marks: label of a phase -> the cells it has marked in this step, `[H, W]` bool.
    told: what the defines are that agents are shown.
    """

    step: int
    values: dict[str, np.ndarray]
    row: np.ndarray
    col: np.ndarray
    heading: np.ndarray
    held: np.ndarray
    returns: np.ndarray
    movers: Mapping[str, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)
    marks: Mapping[str, np.ndarray] = field(default_factory=dict)
    told: Mapping[str, str] = field(default_factory=dict)

    def standing(self) -> Iterator[tuple[str, int, int, int]]:
        """Yields who is on the map, as they are drawn one after the other: `agent` or the sort of the mover, number, row, column."""
        for sort, (rows, cols) in {"agent": (self.row, self.col), **self.movers}.items():
            for number, (row, col) in enumerate(zip(rows.tolist(), cols.tolist(), strict=True)):
                if row >= 0:
                    yield sort, number, row, col


@dataclass(frozen=True)
class Moment:
    """One moment.

    snapshot: the state; actions: number of each agent's action in the last step, `()` at the start of an episode;
    reward: `[N]` float of that step; events: its counts that are not zero, a number or `[N]`; done: the episode is over.
    """

    snapshot: Snapshot
    actions: tuple[int, ...]
    reward: np.ndarray
    events: Mapping[str, np.ndarray]
    done: bool


def shown_defines(game: ir.Game) -> list[ir.Observable]:
    """Returns the defines that agents are shown."""
    return [
        o
        for o in game.observables
        if o.what == "world" and o.value is not None and not isinstance(o.value, ir.Step)
    ]


def take_snapshot(env: "Environment", state: Any, returns: np.ndarray) -> Snapshot:
    """Returns what a picture shows of a compiled state. `returns`: `[N]`, rewards so far."""
    import jax

    (_, width), pad, game = env.module.FRAME, env.module.PAD, env.game
    plain = jax.device_get(state)
    values = {field.name: np.asarray(getattr(plain, field.name)) for field in fields(plain)}

    def places(cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Returns rows and columns of cells that are numbered in the padded map, where 0 stands for nowhere."""
        row, col = np.divmod(cells.astype(int), width)
        return np.where(cells > 0, row - pad, -1), np.where(cells > 0, col - pad, -1)

    row, col = places(values["position"])
    held = np.zeros(env.num_agents, bool)
    if game.agents.forbids:
        held = np.asarray(env.allowed_actions(state)).sum(axis=1) == 1
    return Snapshot(
        step=int(plain.step),
        values=values,
        row=row,
        col=col,
        heading=values["heading"],
        held=held,
        returns=np.asarray(returns),
        movers={sort.name: places(values[f"{sort.name}_position"]) for sort in game.movers},
        marks={
            phase.label: _mask(game, *places(values[f"mark_{phase.name}"]))
            for phase in marking_phases(game)
        },
        told=_told(env, state, row),
    )


def _told(env: "Environment", state: Any, row: np.ndarray) -> dict[str, str]:
    """Returns the defines as the first agent that is there sees them; nothing if nobody is there. `row`: of each agent, negative if it is away."""
    names = {o.field for o in shown_defines(env.game)}
    if not names or not (row >= 0).any():
        return {}
    module: Any = env.module
    tokens = np.asarray(_tokens_of(module)(state, env.params))[int(np.argmax(row >= 0))]
    shown = (
        (plane, int(tokens[number, 0, 0]))
        for number, plane in enumerate(planes(env.game))
        if plane.what == "world"
    )
    return {
        plane.name: plane.labels[value] if plane.labels else str(value)
        for plane, value in shown
        if plane.name in names
    }


@cache
def _tokens_of(module: Any) -> Any:
    """Returns the compiled function that observes, whatever the encoding of an environment's observations."""
    import jax

    return jax.jit(module.observe)


def snapshot_of(game: ir.Game, world: World, returns: Sequence[float] | np.ndarray) -> Snapshot:
    """Returns what a picture shows of a state of the interpreter, as `take_snapshot` does of a compiled one."""

    def places(cells: Sequence[Cell | tuple[int, int] | None]) -> tuple[np.ndarray, np.ndarray]:
        row, col = (
            np.array([(-1, -1) if cell is None else cell for cell in cells], int).reshape(-1, 2).T
        )
        return row, col

    row, col = places(world.position)
    held = np.zeros(len(world.position), bool)
    if game.agents.forbids:
        held = np.sum(action_mask(game, world), axis=1) == 1
    marked = {
        phase.label: [(row, col) for name, row, col in world.marks if name == phase.name]
        for phase in marking_phases(game)
    }
    return Snapshot(
        step=world.step,
        values={attribute_name(f): np.array(stored_values(f, world)) for f in all_fields(game)},
        row=row,
        col=col,
        heading=np.array(world.heading, int),
        held=held,
        returns=np.array(returns, float),
        movers={sort: places(herd.position) for sort, herd in world.movers.items()},
        marks={label: _mask(game, *places(cells)) for label, cells in marked.items()},
        told={
            o.field: _said(evaluate(o.value, Instance(board_of(game), world)))
            for o in shown_defines(game)
            if o.value is not None
        },
    )


def _said(value: Any) -> str:
    """Returns the value of a define: a condition is `yes` or `no`."""
    return ("no", "yes")[value] if isinstance(value, bool) else str(value)


def _mask(game: ir.Game, row: np.ndarray, col: np.ndarray) -> np.ndarray:
    """Returns the places that are on the map, `[H, W]` bool."""
    mask = np.zeros((len(game.rows), len(game.rows[0])), bool)
    inside = (row >= 0) & (row < mask.shape[0]) & (col >= 0) & (col < mask.shape[1])
    mask[row[inside], col[inside]] = True
    return mask


def moment_of(
    game: ir.Game,
    world: World,
    returns: Sequence[float] | np.ndarray,
    actions: Sequence[int] = (),
    outcome: Outcome | None = None,
) -> Moment:
    """Returns a moment of the interpreter: the start of an episode without an outcome. `returns`: with the reward of this step."""
    snapshot = snapshot_of(game, world, returns)
    if outcome is None:
        return Moment(snapshot, (), np.zeros(len(world.position)), {}, False)
    events: dict[str, np.ndarray] = {}
    for event in game.events:
        counts = np.asarray(outcome.events[event.name])
        events |= {
            name: counts if word is None else counts[..., i]
            for i, (word, name) in enumerate(counts_of(event))
        }
    return Moment(
        snapshot,
        tuple(actions),
        np.array(outcome.reward, float),
        {name: count for name, count in events.items() if np.any(count)},
        outcome.terminated or outcome.truncated,
    )
