"""The yardstick: a step of Commons Harvest (open) written by hand in JAX, with which compiled games
are compared.

It does the whole work of one environment step: turns, relative moves with collisions, eating,
regrowth by neighbour count, the zap beam, respawn, and the 11 x 11 egocentric windows of seven
agents. It is fast because a cell is one uint8 token instead of one-hot floats, and apples are a
vector of 64 sites with a constant neighbour matrix. Each window is cut with one dynamic_slice and
turned by selecting among four rotations. Collisions are N x N comparisons, unrolled, and nothing is
sorted. It has no resets, and uses threefry. As a fixed measure it is not changed any more, not even
to be faster.
"""

from itertools import product

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

NUM_AGENTS = 7
NUM_ACTIONS = 8
HEIGHT = 16  # of the map
WIDTH = 22
PAD = 10  # cells around the map, in the frame
ROWS = HEIGHT + 2 * PAD  # of the frame
COLS = WIDTH + 2 * PAD
HEADINGS = np.array([[-1, 0], [0, 1], [1, 0], [0, -1]])
PATCHES = ((2, 7), (2, 14), (7, 2), (7, 19))
SPAWN_CELLS = (
    [(13, c) for c in range(2, 20)] + [(14, c) for c in range(1, 21)] + [(15, c) for c in range(22)]
)

# position [7] int32, cell of the padded frame; heading [7] int32; ripe [64] bool
State = tuple[Array, Array, Array]


def _apple_cells() -> list[tuple[int, int]]:
    """Returns the cells of four diamonds and two corners, in reading order."""
    cells = []
    for row, col in product(range(HEIGHT), range(WIDTH)):
        is_in_patch = any(abs(row - r) + abs(col - c) <= 2 for r, c in PATCHES)
        is_in_corner = row + min(col, WIDTH - 1 - col) <= 2
        if is_in_patch or is_in_corner:
            cells.append((row, col))
    return cells


def _in_frame(cells: list[tuple[int, int]]) -> np.ndarray:
    """Returns the numbers of cells of the map in the padded frame, `[C]` int32."""
    return np.array([(r + PAD) * COLS + c + PAD for r, c in cells], np.int32)


def _near(cells: list[tuple[int, int]]) -> np.ndarray:
    """Returns which apples are within two cells of which, `[64, 64]` float32."""
    places = np.array(cells)
    squares = ((places[:, None] - places[None]) ** 2).sum(-1)
    result: np.ndarray = ((squares <= 4) & (squares > 0)).astype(np.float32)
    return result


APPLES = _apple_cells()
SITES = jnp.asarray(_in_frame(APPLES))
SPAWNS = jnp.asarray(_in_frame(SPAWN_CELLS))
OUTSIDE = jnp.asarray(
    np.pad(np.zeros((HEIGHT, WIDTH), np.uint8), PAD, constant_values=1).reshape(-1)
)
NEAR = jnp.asarray(_near(APPLES))
_SITE_NUMBERS = np.full(ROWS * COLS, len(APPLES), np.int32)
_SITE_NUMBERS[_in_frame(APPLES)] = np.arange(len(APPLES))
SITE_OF = jnp.asarray(_SITE_NUMBERS)
STEP = jnp.asarray(HEADINGS[:, 0] * COLS + HEADINGS[:, 1], jnp.int32)
NOT_SELF = ~np.eye(NUM_AGENTS, dtype=bool)


def reset() -> State:
    """Returns the first state."""
    return SPAWNS[:NUM_AGENTS], jnp.zeros(NUM_AGENTS, jnp.int32), jnp.ones(len(APPLES), bool)


def step(state: State, action: Array, key: Array) -> tuple[State, Array, Array]:
    """Returns the next state, rewards `[7]` float32 and tokens `[7, 11, 11]` uint8."""
    position, heading, ripe = state
    k_tie, k_grow, k_spawn = (jax.random.fold_in(key, i) for i in range(3))
    ripe = _regrow(position, ripe, k_grow)
    heading = (heading + jnp.where(action == 0, 3, 0) + jnp.where(action == 1, 1, 0)) & 3
    position = _move(position, heading, action, k_tie)
    eaten = (SITE_OF[position][:, None] == jnp.arange(len(APPLES))) & ripe[None]
    reward = jnp.any(eaten, 1).astype(jnp.float32)
    ripe = ripe & ~jnp.any(eaten, 0)
    position, beam, zap = _zap(position, heading, action, k_spawn)
    tokens = _observe(position, heading, ripe, beam, zap)
    return (position, heading, ripe), reward, tokens


def _regrow(position: Array, ripe: Array, key: Array) -> Array:
    """Returns which apples are ripe after regrowth, which ripe ones nearby make likelier."""
    on_site = SITE_OF[position][:, None] == jnp.arange(len(APPLES))
    near = NEAR @ ripe.astype(jnp.float32)
    chance = jnp.where(
        near >= 3, 0.025, jnp.where(near >= 2, 0.005, jnp.where(near >= 1, 0.001, 0.0))
    )
    return ripe | ((jax.random.uniform(key, (len(APPLES),)) < chance) & ~jnp.any(on_site, 0))


def _move(position: Array, heading: Array, action: Array, key: Array) -> Array:
    """Returns the positions after the moves: nobody swaps cells or enters one that stays taken, and
    a lot decides between agents that want the same one.
    """
    offset = jnp.where(action == 2, 3, jnp.where(action == 3, 1, jnp.where(action == 5, 2, 0)))
    moving = (action >= 2) & (action <= 5)
    target = jnp.where(moving, position + STEP[(heading + offset) & 3], position)
    target = jnp.where(OUTSIDE[target] > 0, position, target)
    # The lots: the agents' numbers in the low bits make them different.
    drawn = jax.random.bits(key, (NUM_AGENTS,)) & jnp.uint32(0xFFFFFFF8)
    order = drawn | jnp.arange(NUM_AGENTS, dtype=jnp.uint32)
    # [7, 7]: whether an agent wants the cell of another, and whether both want the same cell
    into = (target[:, None] == position[None]) & NOT_SELF
    same = (target[:, None] == target[None]) & NOT_SELF
    moves = (target != position) & ~jnp.any(into & into.T, 1)
    for _ in range(NUM_AGENTS):  # whoever stays may keep another from entering
        enters = moves & ~jnp.any(into & ~moves[None], 1)
        moves = enters & ~jnp.any(same & moves[None] & (order[None] > order[:, None]), 1)
    return jnp.where(moves, target, position)


def _zap(position: Array, heading: Array, action: Array, key: Array) -> tuple[Array, Array, Array]:
    """Returns the positions after those hit were sent to spawn cells, the cells of the beams, and
    who zapped.
    """
    ahead = STEP[heading]
    right = STEP[(heading + 1) & 3]
    beam = jnp.stack(  # [7, 4]
        [
            position + ahead,
            position + 2 * ahead,
            position + ahead + right,
            position + ahead - right,
        ],
        1,
    )
    zap = action == 7
    # [7, 4, 7]: whether a cell of an agent's beam is the position of another
    reaches = (beam[:, :, None] == position[None, None]) & NOT_SELF[:, None, :]
    hit = jnp.any(reaches & zap[:, None, None], (0, 1))
    taken = jnp.any((SPAWNS[:, None] == position[None]) & ~hit[None], 1)
    rank = jnp.where(taken, jnp.uint32(0xFFFFFFFF), jax.random.bits(key, (len(SPAWN_CELLS),)) >> 1)
    homes = []
    # The smallest ranks one after another: much faster than a sort on a CPU.
    for _ in range(NUM_AGENTS):
        best = jnp.argmin(rank)
        homes.append(SPAWNS[best])
        rank = rank.at[best].set(jnp.uint32(0xFFFFFFFF))
    return jnp.where(hit, jnp.stack(homes), position), beam, zap


def _observe(position: Array, heading: Array, ripe: Array, beam: Array, zap: Array) -> Array:
    """Returns what each agent sees: 0 floor, 1 outside, 2 apple, 3 beam, 4 and more agents."""
    grid = OUTSIDE.at[SITES].set(
        ripe.astype(jnp.uint8) * 2, mode="promise_in_bounds", unique_indices=True
    )
    grid = grid.at[jnp.where(zap[:, None], beam, 0).reshape(-1)].set(3, mode="promise_in_bounds")
    grid = grid.at[position].set(
        (jnp.arange(NUM_AGENTS) + 4).astype(jnp.uint8), mode="promise_in_bounds"
    )
    grid = grid.reshape(ROWS, COLS)

    def window(row: Array, col: Array, facing: Array) -> Array:
        """Returns what an agent there sees, with its heading upwards, `[11, 11]`."""
        around = jax.lax.dynamic_slice(grid, (row - 9, col - 9), (19, 19))
        turned = [jnp.rot90(around, k)[0:11, 4:15] for k in range(4)]
        return jnp.where(
            facing == 0,
            turned[0],
            jnp.where(facing == 1, turned[1], jnp.where(facing == 2, turned[2], turned[3])),
        )

    return jax.vmap(window)(position // COLS, position % COLS, heading)
