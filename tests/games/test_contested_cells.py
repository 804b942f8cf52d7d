"""Who gets a cell that several want, counted in each game: everybody as often."""

from functools import cache
from typing import Any

import pytest

from .chance import BATCH, assert_uniform, many
from .environments import Cell, environment, frame_cells, placed

pytestmark = pytest.mark.optimised

STAY, FORWARD = 6, 4
# game -> a cell with room to its west, south and east, and where the others wait
CELLS: dict[str, tuple[Cell, list[Cell]]] = {
    "coins": ((5, 5), []),
    "harvest_open": ((11, 6), [(15, col) for col in range(7)]),
    "clean_up": ((11, 6), [(9, col) for col in range(4, 9)]),
    "coop_mining": ((16, 13), [(3, col) for col in range(15, 20)]),
    "gift_refinement": ((15, 12), [(2, col) for col in range(14, 19)]),
    "mushrooms": ((6, 2), [(11, col) for col in range(18, 23)]),
    "pd_arena": ((6, 10), [(1, col) for col in range(1, 5)]),
}
ROUNDS = 16


@cache
def counter(game: str) -> Any:
    """Counts how often each agent comes to the contested cell."""
    env = environment(game)
    contested = int(frame_cells(env, CELLS[game][0]))
    return many(env, lambda _, after, __: after.position == contested)


@pytest.mark.parametrize(
    ("game", "number"),
    [("coins", 2), *((game, n) for game in CELLS if game != "coins" for n in (2, 3))],
)
def test_a_contested_cell_goes_to_each_alike(game: str, number: int) -> None:
    env, ((row, col), waiting) = environment(game), CELLS[game]
    around = [(row, col - 1), (row + 1, col), (row, col + 1)][:number]
    others = env.num_agents - number
    state = placed(env, [*around, *waiting[:others]], [1, 0, 3][:number] + [0] * others)
    won = counter(game)(7, state, [FORWARD] * number + [STAY] * others, env.params, ROUNDS)
    assert won.sum() == ROUNDS * BATCH
    assert_uniform(won[:number], 0.04)
