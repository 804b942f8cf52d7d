"""What one draw gives tells nothing of any other: of another rule, instance, step, environment or key."""

from itertools import combinations

import numpy as np
import pytest

from tests.statistics.chi_square import assert_independent
from tests.statistics.many import outcomes

pytestmark = pytest.mark.parametrize(
    "keys", ["rollout", pytest.param("counted", marks=pytest.mark.thorough)]
)
PER_CELL = ("hit", "tabled", "chain", "number", "wide", "colour", "burden", "part")
COARSER = {"wide": 100, "part": 5}  # so many classes taken as one
OF_AGENTS = (
    "partner",
    "came",
    "gate",
    "heading",
    "den",
    "returned heading",
    "den again",
    "heading again",
    "taker",
    "strayed",
)
PAIRS = list(combinations((*PER_CELL, "picked", "some", *OF_AGENTS, "pushed"), 2))


def classes(keys: str) -> dict[str, np.ndarray]:
    """Returns each outcome as one number of a few, `[T, B]`: of the first cell or agent, and of who is picked, the first one."""
    found = {name: value[..., 0] for name, value in outcomes(keys).items()}
    for name in ("picked", "came"):
        found[name] = outcomes(keys)[name].argmax(axis=-1)
    found["some"] = outcomes(keys)["some"].argmax(axis=-1)
    found |= {name: found[name] // of for name, of in COARSER.items()}
    return {
        name: np.unique(value, return_inverse=True)[1].reshape(value.shape)
        for name, value in found.items()
    }


def table(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Returns how often each value of one came with each value of the other."""
    counts = np.zeros((a.max() + 1, b.max() + 1))
    np.add.at(counts, (a.reshape(-1), b.reshape(-1)), 1)
    return counts


def merged(counts: np.ndarray) -> np.ndarray:
    """Returns a table without classes too rare to be counted: the rarest rows and columns are added to their neighbours."""
    for axis in (0, 1):
        while counts.shape[axis] > 2 and _expected(counts).min() < 20:
            sums = counts.sum(axis=1 - axis)
            rare = int(sums.argmin())
            into = rare - 1 if rare else 1
            order = np.arange(counts.shape[axis])
            order[rare] = into
            counts = np.stack(
                [
                    np.take(counts, np.flatnonzero(order == i), axis).sum(axis=axis)
                    for i in np.unique(order)
                ],
                axis,
            )
    return counts


def _expected(counts: np.ndarray) -> np.ndarray:
    return counts.sum(axis=1, keepdims=True) * counts.sum(axis=0, keepdims=True) / counts.sum()


@pytest.mark.thorough
def test_of_two_rules(keys: str) -> None:
    found = classes(keys)
    for a, b in PAIRS:
        assert_independent(merged(table(found[a], found[b])), finds=0.06, tests=len(PAIRS))


@pytest.mark.parametrize("name", PER_CELL)
def test_of_two_neighbouring_instances(name: str, keys: str) -> None:
    """Two words that lie side by side are made by one call of the generator."""
    value = outcomes(keys)[name] // COARSER.get(name, 1)
    for first in (0, 1):
        pairs = table(value[..., first:-1:2], value[..., first + 1 :: 2])
        assert_independent(merged(pairs), finds=0.025, tests=2)


def test_of_two_steps_and_of_two_environments(keys: str) -> None:
    """One after the other, and side by side: their keys are made from one."""
    found = classes(keys)
    for value in found.values():
        steps, environments = table(value[:-1], value[1:]), table(value[:, :-1], value[:, 1:])
        for counts in (steps, environments):
            assert_independent(merged(counts), finds=0.06, tests=2 * len(found))
