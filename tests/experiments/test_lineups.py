"""Line-ups: how many there are, and who gets which slot."""

from collections import Counter
from math import factorial

import numpy as np
import pytest
from scipy import stats

from sjdsl.experiments import ExperimentError
from sjdsl.experiments.lineups import (
    all_mixtures,
    cooperating,
    fixed_orders,
    key_bits,
    orders_of,
    paired_mixtures,
    play_key,
    visiting,
)
from sjdsl.trainers.policies.evaluation import evaluation_key


def test_all_mixtures_of_few_policies() -> None:
    assert all_mixtures(2, 3) == ((0, 0, 0), (0, 0, 1), (0, 1, 1), (1, 1, 1))
    assert len(all_mixtures(3, 7)) == 36
    assert all_mixtures(1, 4) == ((0, 0, 0, 0),)


def test_too_many_mixtures_are_refused_with_their_number() -> None:
    assert len(all_mixtures(31, 2)) == 496
    with pytest.raises(
        ExperimentError,
        match="32 policies fill 2 slots in 528 mixtures, and at most 500 are played",
    ):
        all_mixtures(32, 2)
    with pytest.raises(ExperimentError, match=r"6 policies fill 7 slots in 792 mixtures"):
        all_mixtures(6, 7)
    with pytest.raises(ExperimentError, match="23 policies make 529 pairs, and at most 500"):
        paired_mixtures(23, 3)


def test_pairs() -> None:
    """Of two agents each pair once; of more, who is alone matters."""
    assert paired_mixtures(3, 2) == ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
    assert paired_mixtures(2, 3) == ((0, 0, 0), (0, 0, 1), (0, 1, 1), (1, 1, 1))
    assert visiting(1, 0, 4) == (0, 0, 0, 1)


def test_cooperators_come_first() -> None:
    assert [cooperating(k, 3) for k in range(4)] == [(1, 1, 1), (0, 1, 1), (0, 0, 1), (0, 0, 0)]


def test_orders_do_not_depend_on_the_number_of_episodes() -> None:
    orders = orders_of(3, 1, 50, 5)
    np.testing.assert_array_equal(orders[:20], orders_of(3, 1, 20, 5))
    np.testing.assert_array_equal(np.sort(orders, axis=1), fixed_orders(50, 5))
    assert (orders != orders_of(3, 0, 50, 5)).any()
    assert (orders != orders_of(4, 1, 50, 5)).any()


def test_every_order_is_as_likely() -> None:
    """Chi-square of 3,000 orders of four slots, at one in a million."""
    found = Counter(map(tuple, orders_of(0, 0, 3000, 4).tolist()))
    expected = 3000 / factorial(4)
    assert len(found) == factorial(4)
    assert sum((count - expected) ** 2 / expected for count in found.values()) < stats.chi2.ppf(
        1 - 1e-6, factorial(4) - 1
    )


def test_replicates_have_keys_of_their_own() -> None:
    """The first has that of an evaluation; none is one that a run evaluates its updates with."""
    keys = [tuple(key_bits(play_key(0, replicate))) for replicate in range(20)]
    assert keys[0] == tuple(key_bits(evaluation_key(0)))
    assert (
        len({*keys, *(tuple(key_bits(evaluation_key(0, update))) for update in range(1, 100))})
        == 20 + 99
    )
