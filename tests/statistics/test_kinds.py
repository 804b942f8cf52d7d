"""Every kind of draw has its distribution: over all instances together, and in each of them."""

from itertools import combinations, permutations

import numpy as np
import pytest

from tests.statistics.chi_square import assert_distribution, assert_independent
from tests.statistics.many import game, outcomes

pytestmark = pytest.mark.parametrize(
    "keys", ["rollout", pytest.param("counted", marks=pytest.mark.thorough)]
)
GATES, DENS = (8, 9, 10, 19, 20, 21), (30, 31, 32, 41, 42, 43)
# chain: 0.3, half of the rest, a fifth of what is left then; the first is what no branch leaves
PER_CELL = {
    "hit": (0.98, 0.02),
    "chain": (0.7 * 0.5 * 0.8, 0.3, 0.7 * 0.5, 0.7 * 0.5 * 0.2),
    "number": (1 / 7,) * 7,
    "wide": (1 / 1000,) * 1000,
    "colour": (1 / 3,) * 3,
    "burden": (0.15, 0.6, 0.25),
    "part": (1 / 20,) * 20,
}


def high() -> np.ndarray:
    """Returns which cells of floor are of the sort that a table and two picks go by."""
    glyphs = [g for row in game().game.rows for g in row if g in "fF"]
    return np.array(glyphs) == "F"


def ways(found: np.ndarray, possible: list[tuple[int, ...]]) -> np.ndarray:
    """Returns how often each of the possible outcomes `[..., k]` came. Raises KeyError for an impossible one."""
    number = {way: i for i, way in enumerate(possible)}
    counts = np.zeros(len(possible))
    values, times = np.unique(found.reshape(-1, found.shape[-1]), axis=0, return_counts=True)
    for value, n in zip(values.tolist(), times, strict=True):
        counts[number[tuple(value)]] = n
    return counts


def one_of(number: int) -> list[tuple[int, ...]]:
    return [tuple(row) for row in np.eye(number, dtype=int).tolist()]


@pytest.mark.parametrize("name", PER_CELL)
def test_of_each_cell(name: str, keys: str) -> None:
    """A chance, a chain of chances, numbers, words, weighted words."""
    found, shares = outcomes(keys)[name], PER_CELL[name]
    assert_distribution(
        np.bincount(found.reshape(-1), minlength=len(shares)),
        shares,
        finds=0.021 if len(shares) > 10 else 0.011,
    )
    if len(shares) < 10:
        cells = found.reshape(-1, found.shape[-1]).T
        assert_independent(
            np.stack([np.bincount(cell, minlength=len(shares)) for cell in cells]), finds=0.015
        )


def test_a_chance_from_a_table(keys: str) -> None:
    found = outcomes(keys)["tabled"]
    for cells, probability in ((~high(), 0.1), (high(), 0.6)):
        assert_distribution(
            np.bincount(found[..., cells].reshape(-1)), (1 - probability, probability), finds=0.013
        )


def test_pick(keys: str) -> None:
    """One of seven; three of eight, all 56 ways equally likely; nobody else."""
    one, some = outcomes(keys)["picked"], outcomes(keys)["some"]
    assert not one[..., ~high()].any()
    assert not some[..., high()].any()
    assert_distribution(ways(one[..., high()], one_of(7)), None, finds=0.04)
    threes = [tuple(int(i in three) for i in range(8)) for three in combinations(range(8), 3)]
    assert_distribution(ways(some[..., ~high()], threes), None, finds=0.05)


# each agent's partner where it is the left one: two pairs of four agents, and in each pair either is left
PAIRS = {
    tuple({a: b, c: d}.get(agent, -1) for agent in range(4))
    for a, b, c, d in permutations(range(4))
}
# What comes out: all ways, each equally likely, and the fault that so many draws find.
EQUAL = {
    "came": (one_of(4), 0.04),  # four agents enter one cell: one of them comes there
    "partner": ([*PAIRS], 0.045),
    "gate": ([*permutations(GATES, 4)], 0.07),  # four are sent to six gates at once
    "den": ([*permutations(DENS, 2)], 0.05),  # two come back to six dens
    "den again": ([*permutations(DENS, 2)], 0.05),  # and are sent there again
    "heading": ([*np.ndindex(4, 4, 4, 4)], 0.07),  # of the four who are sent
    "returned heading": ([*np.ndindex(4, 4)], 0.07),  # of the two who come back
    "heading again": ([*np.ndindex(4, 4)], 0.07),
    "strayed": ([*np.ndindex(4, 4, 4)], 0.05),  # three movers have four open cells each
    "pushed": (one_of(2), 0.035),  # two are sent by one cell to the same place: one comes there
}


@pytest.mark.parametrize("name", EQUAL)
def test_all_ways_are_equally_likely(name: str, keys: str) -> None:
    possible, finds = EQUAL[name]
    assert_distribution(ways(outcomes(keys)[name], possible), None, finds=finds)


def test_lots(keys: str) -> None:
    """Four would write each of six fields, one of them does: each equally often, in every cell."""
    taker = outcomes(keys)["taker"]
    assert_distribution(np.bincount(taker.reshape(-1), minlength=4), (1 / 4,) * 4, finds=0.02)
    cells = taker.reshape(-1, taker.shape[-1]).T
    assert_independent(np.stack([np.bincount(cell, minlength=4) for cell in cells]), finds=0.02)
