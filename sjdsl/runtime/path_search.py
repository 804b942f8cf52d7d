"""Shortest paths on a map whose cells may close from step to step: breadth-first search on bits.

A board is a set of cells, `[H, L]` uint32: column c of a row is bit c % 32 of entry c // 32. The
search runs from the goals. It has a board for each heading if turns matter, else one.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from sjdsl.runtime.actions import DIRECTIONS, STEPS, TURNS
from sjdsl.runtime.bits import WIDTH, pack
from sjdsl.runtime.rows import on_last_axis
from sjdsl.runtime.varying import settled


@dataclass(frozen=True, eq=False)
class Moves:
    """The moves of a game, in the order of its actions, without `stay`.

    actions: their numbers; turns: quarter turns to the right of each.
    steps: the direction of each, from the heading if `relative`, else of the compass; None for a
    turn.
    open: `[H, W]` bool, cells that agents can ever enter; wraps: whether the edges are joined.
    """

    actions: tuple[int, ...]
    turns: tuple[int, ...]
    steps: tuple[int | None, ...]
    relative: bool
    open: np.ndarray
    wraps: bool = False

    @property
    def turns_matter(self) -> bool:
        """Whether the cells that an agent can step to depend on its heading."""
        directions = {step for step in self.steps if step is not None}
        return self.relative and len(directions) < len(DIRECTIONS)


def moves_of(
    actions: Sequence[str], relative: bool, open_cells: np.ndarray, wraps: bool = False
) -> Moves:
    """Returns the moves among the actions of a game. `open_cells`: see `Moves.open`."""
    names = [name for name in actions if name in STEPS or name in TURNS]
    return Moves(
        actions=tuple(map(actions.index, names)),
        turns=tuple(TURNS.get(name, 0) for name in names),
        steps=tuple(map(STEPS.get, names)),
        relative=relative,
        open=open_cells,
        wraps=wraps,
    )


def board(cells: Array) -> Array:
    """Returns `[..., H, W]` bool as `[..., H, L]` uint32."""
    words: Array = pack(cells)
    return words


def shifted(boards: Array, rows: int, cols: int, width: int) -> Array:
    """Returns boards `[..., H, L]` with all members some rows down and columns to the right.

    Those that leave the map are gone.
    """
    height, words = boards.shape[-2:]
    if abs(rows) >= height or abs(cols) >= width:
        return jnp.zeros_like(boards)
    if rows:
        boards = _moved(boards, -2, rows)
    if cols:
        num_words, num_bits = divmod(abs(cols), WIDTH)
        sign = 1 if cols > 0 else -1
        moved = _moved(boards, -1, sign * num_words)
        if num_bits:
            carried = _moved(boards, -1, sign * (num_words + 1))
            by = jnp.uint32(num_bits)
            back = jnp.uint32(WIDTH - num_bits)
            if cols > 0:
                moved = (moved << by) | (carried >> back)
            else:
                moved = (moved >> by) | (carried << back)
        boards = moved
        if cols > 0 and width % WIDTH:
            last = np.full(words, 0xFFFFFFFF, np.uint32)
            last[-1] = (1 << width % WIDTH) - 1
            boards = boards & on_last_axis(jnp.asarray(last), boards.ndim)
    return boards


def wrapped(boards: Array, rows: int, cols: int, width: int) -> Array:
    """Returns boards as `shifted` does, on a map that wraps."""
    height = boards.shape[-2]
    rows %= height
    cols %= width
    if rows:
        boards = shifted(boards, rows, 0, width) | shifted(boards, rows - height, 0, width)
    if cols:
        boards = shifted(boards, 0, cols, width) | shifted(boards, 0, cols - width, width)
    return boards


def _moved(boards: Array, axis: int, by: int) -> Array:
    """Returns boards whose entries are moved along an axis, with zeros in the places left."""
    axis = boards.ndim + axis
    edges = [(0, 0, 0)] * boards.ndim
    edges[axis] = (by, -by, 0)
    return lax.pad(boards, jnp.uint32(0), edges)


def contains(boards: Array, which: Array, row: Array, col: Array) -> Array:
    """Returns whether cells are members of boards, False for those off the map.

    Args:
      boards: `[K, H, L]`.
      which, row, col: the board, row and column of each cell, of one shape.
    """
    height, words = boards.shape[-2:]
    inside = (row >= 0) & (row < height) & (col >= 0) & (col < words * WIDTH)
    row = jnp.where(inside, row, 0)
    col = jnp.where(inside, col, 0)
    word = boards[which, row, col // WIDTH]
    bit = (word >> (col % WIDTH).astype(jnp.uint32)) & 1
    return inside & (bit != 0)


def first_moves(
    moves: Moves, goals: Array, enterable: Array, agents: tuple[Array, Array, Array], wanted: Array
) -> tuple[Array, Array, Array]:
    """Returns for each agent the first move of a shortest path to a goal.

    Args:
      goals: `[K, P, H, L]` boards of where a path may end, with heading p if P is 4, with any if P
        is 1; K is 1 if all agents have the same goals, else N.
      enterable: `[1 or N, H, L]` boards of cells that a path may step on.
      agents: heading, row and column of each, `[N]` int32.
      wanted: `[N]` bool, whose paths are needed; the result is undefined for the others.

    Returns:
      whether the agent is at a goal already, whether a path leads to one (both `[N]` bool), and the
      index of its first move in `moves.actions`, `[N]` int32; of equally good moves the first.
    """
    # Backwards from the goals: what is reached after each move more is what one move leads into. An
    # agent's first move is one that led into what was reached when its own place first was.
    heading, row, col = agents
    planes = goals.shape[1]
    num_boards = max(goals.shape[0], enterable.shape[0])
    goals = jnp.broadcast_to(goals, (num_boards, *goals.shape[1:]))
    board_of_agent = jnp.zeros_like(heading)
    if goals.shape[0] > 1:
        board_of_agent = jnp.arange(heading.shape[0])

    def holds(reached: Array, facing: Array, at_row: Array, at_col: Array) -> Array:
        """Returns which agents' boards contain a place with a heading, `[N]` bool."""
        flat = reached.reshape(-1, *reached.shape[2:])
        plane = facing if planes > 1 else 0
        return contains(flat, board_of_agent * planes + plane, at_row, at_col)

    def leading_moves(reached: Array) -> Array:
        """Returns which moves lead into what is reached, `[N, M]`."""
        entered = reached & enterable[:, None]
        leads = []
        for turn, step in zip(moves.turns, moves.steps, strict=True):
            if step is None:
                leads.append(holds(reached, (heading + turn) % 4, row, col))
            else:
                next_row, next_col = destination(moves, step, heading, row, col)
                leads.append(holds(entered, heading, next_row, next_col))
        return jnp.stack(leads, axis=-1)

    def advance(carry: tuple[Array, Array, Array, Array]) -> tuple[Array, Array, Array, Array]:
        """Extends what is reached by one move; notes whose first move that is."""
        reached, has_path, best, _ = carry
        further = reached | _expanded(moves, reached, enterable)
        arrives = ~has_path & holds(further, heading, row, col)
        move = jnp.argmax(leading_moves(reached), axis=-1).astype(jnp.int32)
        best = jnp.where(arrives, move, best)
        return further, has_path | arrives, best, jnp.any(further != reached)

    def goes_on(carry: tuple[Array, Array, Array, Array]) -> Array:
        _, has_path, _, is_growing = carry
        return is_growing & ~jnp.all(has_path | ~wanted)

    arrived = holds(goals, heading, row, col)
    if not moves.actions:
        return arrived, arrived, jnp.zeros_like(heading)
    start = (goals, arrived, jnp.zeros_like(heading), jnp.asarray(True))
    _, has_path, best, _ = lax.while_loop(goes_on, advance, settled(advance, start))
    return arrived, has_path, best


def destination(
    moves: Moves, step: int, heading: Array, row: Array, col: Array
) -> tuple[Array, Array]:
    """Returns the row and column that a step leads to, open or not."""
    direction = (heading * int(moves.relative) + step) % 4
    steps = jnp.asarray(DIRECTIONS, jnp.int32)
    row = row + steps[direction, 0]
    col = col + steps[direction, 1]
    if moves.wraps:
        height, width = moves.open.shape
        return row % height, col % width
    return row, col


def _expanded(moves: Moves, reached: Array, enterable: Array) -> Array:
    """Returns the boards `[K, P, H, L]` of places from which one move leads into what is reached.

    reached: boards `[K, P, H, L]`, one for each heading if P is 4. A step comes from the cell
    behind, a turn from the same cell with another heading.
    """
    width = moves.open.shape[1]
    headings = reached.shape[1]  # 1 if they don't matter
    entered = reached & enterable[:, None]

    move_back = wrapped if moves.wraps else shifted
    boards = []
    for heading in range(headings):
        union = jnp.zeros_like(reached[:, heading])
        for turn, step in zip(moves.turns, moves.steps, strict=True):
            if step is not None:
                direction = step
                if headings > 1:
                    direction = (heading * int(moves.relative) + step) % 4
                rows, cols = DIRECTIONS[direction]
                union = union | move_back(entered[:, heading], -rows, -cols, width)
            elif headings > 1:
                union = union | reached[:, (heading + turn) % 4]
        boards.append(union)
    return jnp.stack(boards, axis=1)
