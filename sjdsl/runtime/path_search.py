"""Shortest paths over a map whose cells may close from step to step: breadth-first search from the goals, as bits.

A board is a set of cells, `[H, L]` uint32: column c of a row is bit c % 32 of its word c // 32. A search keeps a board for each heading
where turns matter, and one where they do not.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from sjdsl.runtime.actions import DIRECTIONS, STEPS, TURNS
from sjdsl.runtime.bits import WIDTH, pack
from sjdsl.runtime.varying import settled


@dataclass(frozen=True, eq=False)
class Moves:
    """The moves of a game, in the order of its actions; `stay` is none of them.

    actions: their numbers; turns: quarter turns to the right of each; steps: the direction of each from the heading, or of the compass if
    `relative` is false; None for a turn. open: `[H, W]` bool, cells that agents can ever enter. wraps: whether the map's edges are joined.
    """

    actions: tuple[int, ...]
    turns: tuple[int, ...]
    steps: tuple[int | None, ...]
    relative: bool
    open: np.ndarray
    wraps: bool = False

    @property
    def turns_matter(self) -> bool:
        """Whether it depends on the heading which cells an agent can step to."""
        return self.relative and len({step for step in self.steps if step is not None}) < len(
            DIRECTIONS
        )


def moves_of(
    actions: Sequence[str], relative: bool, open_cells: np.ndarray, wraps: bool = False
) -> Moves:
    """Returns the moves among the actions of a game. `open_cells`: `[H, W]` bool, cells that agents can ever enter."""
    moves = [
        (number, name) for number, name in enumerate(actions) if name in STEPS or name in TURNS
    ]
    return Moves(
        actions=tuple(number for number, _ in moves),
        turns=tuple(TURNS.get(name, 0) for _, name in moves),
        steps=tuple(STEPS.get(name) for _, name in moves),
        relative=relative,
        open=open_cells,
        wraps=wraps,
    )


def board(cells: Array) -> Array:
    """Returns `[..., H, W]` bool as `[..., H, L]` uint32."""
    words: Array = pack(cells)
    return words


def shifted(boards: Array, rows: int, cols: int, width: int) -> Array:
    """Returns boards `[..., H, L]` whose members are so many rows down and columns to the right; those that leave the map are gone."""
    height, words = boards.shape[-2:]
    if abs(rows) >= height or abs(cols) >= width:
        return jnp.zeros_like(boards)
    if rows:
        boards = _moved(boards, -2, rows)
    if cols:
        far, near = divmod(abs(cols), WIDTH)
        sign = 1 if cols > 0 else -1
        whole = _moved(boards, -1, sign * far)
        if near:
            rest = _moved(boards, -1, sign * (far + 1))
            by, back = jnp.uint32(near), jnp.uint32(WIDTH - near)
            whole = (whole << by) | (rest >> back) if cols > 0 else (whole >> by) | (rest << back)
        boards = whole
        if cols > 0 and width % WIDTH:
            last = np.full(words, 0xFFFFFFFF, np.uint32)
            last[-1] = (1 << width % WIDTH) - 1
            boards = boards & jnp.asarray(last).reshape((1,) * (boards.ndim - 1) + (-1,))
    return boards


def wrapped(boards: Array, rows: int, cols: int, width: int) -> Array:
    """Returns boards as `shifted` does, on a map that wraps: members that leave it come back at the other side."""
    height = boards.shape[-2]
    rows, cols = rows % height, cols % width
    if rows:
        boards = shifted(boards, rows, 0, width) | shifted(boards, rows - height, 0, width)
    return (
        shifted(boards, 0, cols, width) | shifted(boards, 0, cols - width, width)
        if cols
        else boards
    )


def _moved(boards: Array, axis: int, by: int) -> Array:
    """Returns boards whose entries stand `by` places further along an axis, zeros where nothing comes from."""
    axis = boards.ndim + axis
    edges = [(0, 0, 0)] * boards.ndim
    edges[axis] = (by, -by, 0)
    return lax.pad(boards, jnp.uint32(0), edges)


def contains(boards: Array, which: Array, row: Array, col: Array) -> Array:
    """Returns whether cells are on boards: `[K, H, L]`, and index, row and column of each cell; off the map there is nothing."""
    height, words = boards.shape[-2:]
    inside = (row >= 0) & (row < height) & (col >= 0) & (col < words * WIDTH)
    r, c = jnp.where(inside, row, 0), jnp.where(inside, col, 0)
    word = boards[which, r, c // WIDTH]
    result: Array = inside & (((word >> (c % WIDTH).astype(jnp.uint32)) & jnp.uint32(1)) != 0)
    return result


def first_moves(
    moves: Moves, goals: Array, enterable: Array, agents: tuple[Array, Array, Array], wanted: Array
) -> tuple[Array, Array, Array]:
    """Returns for each agent the first move of a shortest path to a goal.

    Args:
      goals: `[K, P, H, L]` boards of where a path may end, with heading p if P is 4, with any if P is 1; K is 1 if all agents have the
        same goals, else N.
      enterable: `[1 or N, H, L]` boards of cells that a path may step on.
      agents: heading, row and column of each, `[N]` int32.
      wanted: `[N]` bool, whose paths are asked for; nothing is said of the others.
    Returns:
      whether the agent is at a goal already, whether a path leads to one (both `[N]` bool), and the place of its first move among
      `moves.actions`, `[N]` int32; of moves equally good the first.
    """
    heading, row, col = agents
    planes = goals.shape[1]
    goals = jnp.broadcast_to(goals, (max(goals.shape[0], enterable.shape[0]), *goals.shape[1:]))
    own = jnp.arange(heading.shape[0]) if goals.shape[0] > 1 else jnp.zeros_like(heading)

    def holds(reached: Array, facing: Array, r: Array, c: Array) -> Array:
        flat = reached.reshape(-1, *reached.shape[2:])
        return contains(flat, own * planes + (facing if planes > 1 else 0), r, c)

    def options(reached: Array) -> Array:
        """Returns which moves lead into what is reached, `[N, M]`."""
        entered = reached & enterable[:, None]
        found = []
        for turn, step in zip(moves.turns, moves.steps, strict=True):
            if step is None:
                found.append(holds(reached, (heading + turn) % 4, row, col))
            else:
                r, c = destination(moves, step, heading, row, col)
                found.append(holds(entered, heading, r, c))
        return jnp.stack(found, axis=-1)

    def advance(carry: tuple[Array, Array, Array, Array]) -> tuple[Array, Array, Array, Array]:
        reached, found, best, _ = carry
        further = reached | _expanded(moves, reached, enterable)
        arrives = ~found & holds(further, heading, row, col)
        best = jnp.where(arrives, jnp.argmax(options(reached), axis=-1).astype(jnp.int32), best)
        return further, found | arrives, best, jnp.any(further != reached)

    def goes_on(carry: tuple[Array, Array, Array, Array]) -> Array:
        return carry[3] & ~jnp.all(carry[1] | ~wanted)

    arrived = holds(goals, heading, row, col)
    if not moves.actions:
        return arrived, arrived, jnp.zeros_like(heading)
    start = (goals, arrived, jnp.zeros_like(heading), jnp.asarray(True))
    _, found, best, _ = lax.while_loop(goes_on, advance, settled(advance, start))
    return arrived, found, best


def destination(
    moves: Moves, step: int, heading: Array, row: Array, col: Array
) -> tuple[Array, Array]:
    """Returns the row and column that a step leads to, open or not."""
    facing = (heading * int(moves.relative) + step) % 4
    by = jnp.asarray(DIRECTIONS, jnp.int32)
    row, col = row + by[facing, 0], col + by[facing, 1]
    return (row % moves.open.shape[0], col % moves.open.shape[1]) if moves.wraps else (row, col)


def _expanded(moves: Moves, reached: Array, enterable: Array) -> Array:
    """Returns the boards `[K, P, H, L]` from which one move leads into what is reached."""
    width = moves.open.shape[1]
    planes = reached.shape[1]
    entered = reached & enterable[:, None]

    def before(plane: int, direction: int) -> Array:
        rows, cols = DIRECTIONS[direction]
        return (wrapped if moves.wraps else shifted)(entered[:, plane], -rows, -cols, width)

    found = []
    for plane in range(planes):
        union = jnp.zeros_like(reached[:, plane])
        for turn, step in zip(moves.turns, moves.steps, strict=True):
            if step is not None:
                union = union | before(
                    plane, (plane * int(moves.relative) + step) % 4 if planes > 1 else step
                )
            elif planes > 1:
                union = union | reached[:, (plane + turn) % 4]
        found.append(union)
    return jnp.stack(found, axis=1)
