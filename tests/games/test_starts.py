"""Where agents begin, in every game and room: over many resets, each start as often as it should be."""

import jax
import numpy as np
import pytest

from .chance import assert_uniform, times
from .environments import HARVESTS, cells_of, environment, places

RESETS = 40_000


def starts(game: str) -> tuple[np.ndarray, np.ndarray]:
    """Returns the (row, col) `[resets, agents, 2]` and headings `[resets, agents]` of many resets."""
    env = environment(game)

    def pose(key: jax.Array) -> tuple[jax.Array, jax.Array]:
        _, state = env.reset(key)
        return state.position, state.heading

    position, heading = jax.jit(jax.vmap(pose))(jax.random.split(jax.random.key(3), RESETS))
    return places(env, position), np.asarray(heading)


def numbers(game: str, kind: str, cells: np.ndarray) -> np.ndarray:
    """Returns the number of each cell among those of a kind; all are of the kind."""
    index = {cell: i for i, cell in enumerate(cells_of(environment(game), kind))}
    return np.vectorize(lambda r, c: index[r, c])(cells[..., 0], cells[..., 1])


@pytest.mark.parametrize("game", [*HARVESTS, "clean_up", "coins"])
def test_starts(game: str) -> None:
    """Different cells; each agent on each of them, looking each way, equally often; no two of these tell of each other."""
    cells, heading = starts(game)
    agents = cells.shape[1]
    inner = 2 if game in HARVESTS else 0
    flat = cells[..., 0] * 100 + cells[..., 1]
    assert (np.diff(np.sort(flat, axis=1), axis=1) > 0).all()
    for agent in range(agents):
        assert_uniform(times(heading[:, agent], 4), 0.05)
    if inner:
        dens = numbers(game, "den", cells[:, :2])
        assert (dens.sum(axis=1) == 1).all()
        assert_uniform(times(dens[:, 0], 2), 0.04)
    kind = "corner" if game == "coins" else "gate"
    outer = numbers(game, kind, cells[:, inner:])
    number = len(cells_of(environment(game), kind))
    for agent in range(outer.shape[1]):
        assert_uniform(times(outer[:, agent], number), 0.3)
    if number > 2:
        low = outer < number / 2  # the half of the map it begins in, and the way another agent, or it, looks
        for a, b in ((0, 1), (1, outer.shape[1] - 1)):
            for half in (False, True):
                assert_uniform(times(heading[low[:, a] == half][:, inner + b], 4), 0.08)
                assert_uniform(times(heading[low[:, a] == half][:, inner + a], 4), 0.08)
    else:
        assert_uniform(times(outer[:, 0] * 4 + heading[:, 0], 8), 0.1)
    assert_uniform(times(heading[:, 0] * 4 + heading[:, 1], 16), 0.15)
