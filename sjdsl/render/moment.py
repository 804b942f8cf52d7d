"""One moment of an episode: the state as NumPy arrays, and the step that led to it.

Everything that shows a board reads it.
"""

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

if TYPE_CHECKING:  # so that states of the interpreter can be shown without JAX
    from sjdsl.runtime.env import Environment


@dataclass(frozen=True)
class Snapshot:
    """The state at one moment of an episode.

    values: attribute of the state -> array.
    row, col: `[N]` int, negative for agents that are away; heading: `[N]` int.
    held: `[N]` bool, whether an agent may only stay; returns: `[N]` float, rewards so far.
    movers: type of mover -> rows and columns, `[M]` int each, negative for those that are away.
    marks: label of a phase -> the cells that it has marked in this step, `[H, W]` bool.
    defines: name -> text, for the defines that agents observe.
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
    defines: Mapping[str, str] = field(default_factory=dict)

    def standing(self) -> Iterator[tuple[str, int, int, int]]:
        """Yields the agents and movers on the map in the order of drawing.

        Each is `agent` or the type of the mover, its number, row and column.
        """
        bodies = {"agent": (self.row, self.col), **self.movers}
        for name, (rows, cols) in bodies.items():
            for number, row in enumerate(rows.tolist()):
                if row >= 0:
                    yield name, number, row, int(cols[number])


@dataclass(frozen=True)
class Moment:
    """A state and the step that led to it.

    actions: number of each agent's action in that step, `()` at the start of an episode.
    reward: `[N]` float; events: the counts that aren't zero, a number or `[N]`.
    done: whether the episode is over.
    why: what each agent gave as its reason; empty if none was asked.
    """

    snapshot: Snapshot
    actions: tuple[int, ...]
    reward: np.ndarray
    events: Mapping[str, np.ndarray]
    done: bool
    why: tuple[str, ...] = ()


def shown_defines(game: ir.Game) -> list[ir.Observable]:
    """Returns the defines that agents observe."""
    defines = []
    for observable in game.observables:
        is_computed = observable.value is not None and not isinstance(observable.value, ir.Step)
        if observable.what == "world" and is_computed:
            defines.append(observable)
    return defines


def take_snapshot(env: "Environment", state: Any, returns: np.ndarray) -> Snapshot:
    """Returns the snapshot of a compiled state. `returns`: `[N]`, rewards so far."""
    import jax

    game = env.game
    _, width = env.module.FRAME
    pad = env.module.PAD
    on_host = jax.device_get(state)
    values = {field.name: np.asarray(getattr(on_host, field.name)) for field in fields(on_host)}

    def rows_and_columns(cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Splits numbers of cells in the padded map, where 0 stands for nowhere."""
        row, col = np.divmod(cells.astype(int), width)
        return np.where(cells > 0, row - pad, -1), np.where(cells > 0, col - pad, -1)

    row, col = rows_and_columns(values["position"])
    held = np.zeros(env.num_agents, bool)
    if game.agents.forbids:
        held = np.asarray(env.allowed_actions(state)).sum(axis=1) == 1
    movers = {}
    for mover in game.movers:
        movers[mover.name] = rows_and_columns(values[f"{mover.name}_position"])
    marks = {}
    for phase in marking_phases(game):
        marks[phase.label] = _mask(game, *rows_and_columns(values[f"mark_{phase.name}"]))
    return Snapshot(
        step=int(on_host.step),
        values=values,
        row=row,
        col=col,
        heading=values["heading"],
        held=held,
        returns=np.asarray(returns),
        movers=movers,
        marks=marks,
        defines=_observed_defines(env, state, row),
    )


def _observed_defines(env: "Environment", state: Any, row: np.ndarray) -> dict[str, str]:
    """Returns the defines as the first agent on the map observes them; none if nobody is there.

    Args:
      row: `[N]` int, negative for agents that are away.
    """
    names = {o.field for o in shown_defines(env.game)}
    is_there = row >= 0
    if not names or not is_there.any():
        return {}
    module: Any = env.module
    observe = _compiled_observe(module)
    observation = np.asarray(observe(state, env.params))[int(np.argmax(is_there))]
    defines = {}
    for number, plane in enumerate(planes(env.game)):
        if plane.what == "world" and plane.name in names:
            value = int(observation[number, 0, 0])
            defines[plane.name] = plane.labels[value] if plane.labels else str(value)
    return defines


@cache
def _compiled_observe(module: Any) -> Any:
    """Returns the function that observes planes of integers, whatever encoding `env` uses."""
    import jax

    return jax.jit(module.observe)


def snapshot_of(game: ir.Game, world: World, returns: Sequence[float] | np.ndarray) -> Snapshot:
    """Returns the snapshot of a state of the interpreter. `returns`: `[N]`, rewards so far."""
    row, col = _rows_and_columns(world.position)
    held = np.zeros(len(world.position), bool)
    if game.agents.forbids:
        held = np.array([sum(allowed) == 1 for allowed in action_mask(game, world)])
    marks = {}
    for phase in marking_phases(game):
        cells = [(row, col) for name, row, col in world.marks if name == phase.name]
        marks[phase.label] = _mask(game, *_rows_and_columns(cells))
    instance = Instance(board_of(game), world)
    defines = {}
    for define in shown_defines(game):
        assert define.value is not None
        defines[define.field] = _define_text(evaluate(define.value, instance))
    values = {}
    for declared in all_fields(game):
        values[attribute_name(declared)] = np.array(stored_values(declared, world))
    return Snapshot(
        step=world.step,
        values=values,
        row=row,
        col=col,
        heading=np.array(world.heading, int),
        held=held,
        returns=np.array(returns, float),
        movers={name: _rows_and_columns(herd.position) for name, herd in world.movers.items()},
        marks=marks,
        defines=defines,
    )


def _rows_and_columns(
    cells: Sequence[Cell | tuple[int, int] | None],
) -> tuple[np.ndarray, np.ndarray]:
    """Returns rows and columns of cells, -1 for None."""
    places = [(-1, -1) if cell is None else cell for cell in cells]
    rows, cols = np.array(places, int).reshape(-1, 2).T
    return rows, cols


def _define_text(value: Any) -> str:
    """Returns the value of a define in words."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return str(value)


def _mask(game: ir.Game, row: np.ndarray, col: np.ndarray) -> np.ndarray:
    """Returns a mask of the cells that lie on the map, `[H, W]` bool."""
    height = len(game.rows)
    width = len(game.rows[0])
    on_map = (row >= 0) & (row < height) & (col >= 0) & (col < width)
    mask = np.zeros((height, width), bool)
    mask[row[on_map], col[on_map]] = True
    return mask


def moment_of(
    game: ir.Game,
    world: World,
    returns: Sequence[float] | np.ndarray,
    actions: Sequence[int] = (),
    outcome: Outcome | None = None,
) -> Moment:
    """Returns a moment of the interpreter.

    Args:
      returns: `[N]`, with the reward of the last step.
      outcome: of the last step; None at the start of an episode.
    """
    snapshot = snapshot_of(game, world, returns)
    if outcome is None:
        return Moment(snapshot, (), np.zeros(len(world.position)), {}, False)
    events: dict[str, np.ndarray] = {}
    for event in game.events:
        counts = np.asarray(outcome.events[event.name])
        for index, (word, name) in enumerate(counts_of(event)):
            events[name] = counts if word is None else counts[..., index]
    return Moment(
        snapshot,
        tuple(actions),
        np.array(outcome.reward, float),
        {name: count for name, count in events.items() if np.any(count)},
        outcome.terminated or outcome.truncated,
    )
