"""`first_moves` against distances found by relaxing them move by move, on random maps up to three words wide."""

from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.runtime.path_search import Moves, board, first_moves, moves_of

CASES = 12
AGENTS = 5
FAR = 10**6
NORTH_EAST_SOUTH_WEST = ((-1, 0), (0, 1), (1, 0), (0, -1))
DIRECTION = {"forward": 0, "step_right": 1, "backward": 2, "step_left": 3}
STRAFING = ("turn_left", "turn_right", "step_left", "step_right", "forward", "backward", "stay")
MAZES = {
    "steps_anywhere": ((5, 7), STRAFING, True, 1),
    "headings_of_goals_matter": ((4, 6), STRAFING, True, 4),
    "turns_to_walk": ((4, 33), ("zap", "turn_right", "stay", "forward"), True, 4),
    "a_word_wide": ((3, 32), ("step_left", "turn_left", "forward"), True, 4),
    "three_words_wide": (
        (3, 70),
        ("backward", "step_right", "step_left", "turn_left", "turn_right", "forward"),
        False,
        1,
    ),
    "two_words_wide": ((1, 64), ("step_left", "step_right"), False, 1),
    "a_column": ((40, 1), ("forward", "turn_right"), True, 4),
    "nobody_moves": ((3, 3), ("stay",), True, 1),
}


def leads_to(name: str, relative: bool, heading: int, row: int, col: int) -> tuple[int, int, int]:
    """Returns heading, row and column after a move, whatever stands there."""
    if name.startswith("turn"):
        return (heading + (1 if name == "turn_right" else 3)) % 4, row, col
    down, right = NORTH_EAST_SOUTH_WEST[(DIRECTION[name] + heading * relative) % 4]
    return heading, row + down, col + right


def choices(
    names: Sequence[str], relative: bool, goals: np.ndarray, enterable: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Returns the moves that each pose needs to a goal, `[4, H, W]`, and those after each of its moves, `[M, 4, H, W]`; FAR: never.

    Args:
      goals: `[4, H, W]` bool. enterable: `[H, W]` bool.
    """
    height, width = enterable.shape
    distance = np.where(goals, 0, FAR)
    while True:
        after = np.full((len(names), *distance.shape), FAR)
        for number, heading, row, col in np.ndindex(after.shape):
            turned, r, c = leads_to(names[number], relative, heading, row, col)
            if (r, c) == (row, col) or (0 <= r < height and 0 <= c < width and enterable[r, c]):
                after[number, heading, row, col] = distance[turned, r, c]
        nearer = np.minimum(distance, 1 + after.min(axis=0, initial=FAR))
        if np.array_equal(nearer, distance):
            return distance, after
        distance = nearer


def random_cases(random: np.random.Generator, shape: tuple[int, int], planes: int) -> Any:
    """Returns goals `[C, N, P, H, W]`, enterable cells `[C, H, W]`, and headings, rows and columns `[C, N]` of agents, also on closed cells."""
    open_cells = random.random((CASES, *shape)) < random.uniform(0.6, 1.2, (CASES, 1, 1))
    goals = random.random((CASES, AGENTS, planes, *shape)) < random.choice(
        [0, 0.01, 0.05, 0.3], (CASES, AGENTS, 1, 1, 1)
    )
    places = [random.integers(0, size, (CASES, AGENTS)) for size in (4, *shape)]
    return goals, open_cells, *places


@pytest.mark.parametrize("maze", MAZES)
def test_first_moves(maze: str) -> None:
    shape, acts, relative, planes = MAZES[maze]
    random = np.random.default_rng(len(maze))
    moves = moves_of(acts, relative, np.ones(shape, bool))
    names = [acts[number] for number in moves.actions]
    goals, open_cells, heading, row, col = random_cases(random, shape, planes)

    def search(goals: Any, enterable: Any, *agents: Any) -> Any:
        return first_moves(
            moves, board(goals), board(enterable)[None], agents, jnp.ones(AGENTS, bool)
        )

    found = jax.jit(jax.vmap(search))(
        *(
            jnp.asarray(x)
            for x in (goals, open_cells, *(x.astype(np.int32) for x in (heading, row, col)))
        )
    )
    arrived, reached, best = (np.asarray(x) for x in found)
    lengths = set()
    for case in range(0, CASES, 1 if shape[0] * shape[1] < 50 else 4):
        for agent in range(AGENTS):
            distance, after = choices(
                names, relative, np.broadcast_to(goals[case, agent], (4, *shape)), open_cells[case]
            )
            at = heading[case, agent], row[case, agent], col[case, agent]
            said = (case, agent, *at)
            assert arrived[case, agent] == (distance[at] == 0), said
            assert reached[case, agent] == (distance[at] < FAR), said
            if 0 < distance[at] < FAR:
                assert best[case, agent] == after[:, *at].argmin(), said
            lengths.add(min(distance[at], FAR))
    assert len(lengths) > (1 if not names else 3), "too little to see"


def test_goals_of_all_agents_and_closed_cells_of_each() -> None:
    """The goals are the same for all, the cells that may be entered are each agent's own."""
    moves: Moves = moves_of(("step_left", "step_right"), False, np.ones((1, 4), bool))
    goals = board(jnp.asarray([[[[True, False, False, True]]]]))
    enterable = board(jnp.asarray([[[True, False, True, True]], [[True, True, True, False]]]))
    agents = (jnp.zeros(2, jnp.int32), jnp.zeros(2, jnp.int32), jnp.asarray([1, 2], jnp.int32))
    _, found, best = first_moves(moves, goals, enterable, agents, jnp.ones(2, bool))
    assert found.tolist() == [True, True]
    assert best.tolist() == [
        0,
        0,
    ]  # the second agent is nearer to the goal on its right, which is closed to it
