"""Contrasts and verdicts of returns in closed form, and how often they are right where returns are noisy."""

from collections.abc import Sequence

import numpy as np
import pytest

from sjdsl.experiments.contrasts import (
    JOINT_CONFIDENCE,
    Returns,
    contrast_samples,
    estimate_contrasts,
    estimate_lines,
)
from sjdsl.experiments.verdict import judge, share_that_may_differ

DATA_SETS = 1000


def returns_of(
    cooperating: list[float], defecting: list[float], replicates: int = 1, episodes: int = 3
) -> Returns:
    """Returns the same C(l) and D(l) in each episode."""
    nothing = [np.nan]
    by_k = np.array([nothing + cooperating, defecting + nothing])
    cooperators, defectors = np.broadcast_to(
        by_k[:, :, None, None], (2, len(by_k[0]), replicates, episodes)
    )
    k, last = np.arange(len(cooperating) + 1)[:, None, None], len(cooperating)
    everybody = (k * np.nan_to_num(cooperators) + (last - k) * np.nan_to_num(defectors)) / last
    return Returns(cooperators, defectors, everybody)


def test_equal_samples_have_an_interval_of_no_width() -> None:
    """Also those whose mean is rounded: 0.1 three times makes 0.30000000000000004."""
    returns = returns_of([0.1, 0.7], [0.3, 1.1], episodes=3)
    for figure in (
        *estimate_contrasts(contrast_samples(returns)).values(),
        *estimate_lines(returns, returns.cooperating),
    ):
        assert figure.low == figure.mean == figure.high
    assert [figure.mean for figure in estimate_lines(returns, returns.cooperating)] == [0.1, 0.7]
    seeds = returns_of([0.1, 0.7], [0.3, 1.1], replicates=3, episodes=3)
    assert [figure.mean for figure in estimate_lines(seeds, seeds.cooperating)] == [0.1, 0.7]
    assert {
        figure.high - figure.low for figure in estimate_contrasts(contrast_samples(seeds)).values()
    } == {0.0}


SPREAD, ZERO, ABOVE = np.array([-1.0, -1.1, -0.9]), np.zeros(3), np.ones(3)


@pytest.mark.parametrize(
    ("samples", "outcome", "named"),
    [
        ((ZERO, ZERO, ZERO, ZERO), "no dilemma", ("A", "B", "fear", "greed")),
        ((SPREAD, ABOVE, ZERO, ZERO), "no dilemma", ()),  # A alone decides
        ((-SPREAD, -SPREAD, ZERO, SPREAD), "no dilemma", ("fear",)),
        ((ABOVE, -SPREAD, ABOVE, ZERO), "dilemma", ("A", "fear")),
        ((-SPREAD, -SPREAD, ABOVE, -SPREAD), "dilemma", ()),  # greed alone is enough
        ((-SPREAD, -SPREAD, -SPREAD, ZERO), "dilemma", ()),
        ((SPREAD + 1, SPREAD + 1, ZERO, ABOVE), "undecided", ()),
    ],
)
def test_a_verdict_that_rests_on_equal_samples_names_them(
    samples: tuple[np.ndarray, ...], outcome: str, named: tuple[str, ...]
) -> None:
    """Only those without which the verdict would be another."""
    found = judge(dict(zip(("A", "B", "fear", "greed"), samples, strict=True)))
    assert (found.outcome, found.without_spread) == (outcome, named)


@pytest.mark.parametrize("number", [2, 30, 300])
def test_the_share_that_may_differ_is_seldom_exceeded(number: int) -> None:
    """Were it larger than the bound, so many equal samples would be found in fewer than 5 % of all data sets."""
    bound = share_that_may_differ(number)
    assert (1 - bound) ** number == pytest.approx(0.05)
    assert f"{100 * bound:.2g}" == {2: "78", 30: "9.5", 300: "0.99"}[number]


def test_one_episode_decides_nothing() -> None:
    found = judge(contrast_samples(returns_of([0.0, 3.0], [1.0, 5.0], episodes=1)))
    assert (found.outcome, found.wanted) == ("undecided", None)


def test_training_seeds_are_the_samples_where_there_are_two() -> None:
    """Episodes of a seed are averaged first: three seeds that differ by one, whatever their episodes do."""
    values = np.arange(3.0)[:, None] + np.array([-10.0, 10.0])  # [R, E]
    cooperators = np.stack([values * np.nan, values, values + 4])
    defectors = np.stack([values + 1, values + 6, values * np.nan])
    returns = Returns(cooperators, defectors, values[None].repeat(3, axis=0))
    assert returns.unit == "training seed"
    lowest = estimate_lines(returns, returns.cooperating)[0]
    assert lowest.mean == 1.0
    assert lowest.high - lowest.mean == pytest.approx(
        4.302653 / np.sqrt(3)
    )  # t(0.975, 2), standard deviation 1
    found = contrast_samples(returns)
    assert {name: samples.tolist() for name, samples in found.items()} == {
        "A": [3] * 3,
        "B": [4] * 3,
        "fear": [1] * 3,
        "greed": [2] * 3,
    }


def noisy(
    key: np.random.Generator,
    sets: int,
    cooperating: Sequence[float],
    defecting: Sequence[float],
    noise: float,
    units: int,
) -> list[dict[str, np.ndarray]]:
    """Returns contrasts of data sets of a game with lines C(l) and D(l), l = 0..N-1, and Gaussian noise on every point of both."""
    lines = np.array([cooperating, defecting])[..., None] + noise * key.standard_normal(
        (sets, 2, len(cooperating), units)
    )
    nobody = np.full((1, units), np.nan)  # earned where no agent is of the kind

    def one(cooperators: np.ndarray, defectors: np.ndarray) -> dict[str, np.ndarray]:
        whole = (
            np.concatenate([nobody, cooperators])[:, None],
            np.concatenate([defectors, nobody])[:, None],
        )
        return contrast_samples(Returns(*whole, np.zeros((len(cooperators) + 1, 1, units))))

    return [one(*data) for data in lines]


LINES: dict[
    str, tuple[Sequence[float], Sequence[float]]
] = {  # C(l) and D(l); of two agents S, R and P, T
    "prisoner's dilemma": ((0, 3), (1, 5)),
    "stag hunt": ((0, 4), (1, 3)),
    "chicken": ((1, 3), (0, 4)),
    "harmony": ((2, 4), (1, 3)),
    "deadlock": ((0, 1), (2, 3)),
    # public goods of N agents: what is paid is doubled; or a benefit of 3 at a cost of 1 where more than half pay
    **{
        f"linear, {n}": (
            [2 * (other + 1) / n - 1 for other in range(n)],
            [2 * other / n for other in range(n)],
        )
        for n in range(2, 9)
    },
    **{
        f"threshold, {n}": (
            [3 * (other >= n // 2) - 1 for other in range(n)],
            [3 * (other > n // 2) for other in range(n)],
        )
        for n in range(2, 9)
    },
}
USUAL = (
    "prisoner's dilemma",
    "linear, 4",
    "threshold, 4",
)  # the others only with the thorough tests


@pytest.mark.parametrize("units", [3, 30])
@pytest.mark.parametrize(
    "game",
    [name if name in USUAL else pytest.param(name, marks=pytest.mark.thorough) for name in LINES],
)
def test_the_four_intervals_hold_together(game: str, units: int) -> None:
    """At least 95 % of 1,000 data sets, less three standard errors of such a share."""
    c, d = LINES[game]
    truth = {"A": c[-1] - d[0], "B": c[-1] - c[0], "fear": d[0] - c[0], "greed": d[-1] - c[-1]}
    held = 0
    for samples in noisy(np.random.default_rng(units), DATA_SETS, c, d, 2.0, units):
        found = estimate_contrasts(samples)
        held += all(found[name].low <= value <= found[name].high for name, value in truth.items())
    assert held / DATA_SETS >= 0.95 - 3 * np.sqrt(0.95 * 0.05 / DATA_SETS)
    assert pytest.approx(0.9875) == JOINT_CONFIDENCE


@pytest.mark.parametrize(("cooperating", "defecting"), [((0, 1), (1, 2)), ((1, 3), (0, 3))])
def test_verdicts_at_the_border_are_seldom_wrong(
    cooperating: tuple[float, float], defecting: tuple[float, float]
) -> None:
    """R = P, and neither fear nor greed (T = R, P < S), which is no dilemma: the other verdict in at most 5 % of 1,000 data sets."""
    outcomes = [
        judge_fast(samples)
        for samples in noisy(np.random.default_rng(5), DATA_SETS, cooperating, defecting, 1.0, 12)
    ]
    wrong = outcomes.count("dilemma")
    assert wrong / DATA_SETS <= 0.05


def judge_fast(samples: dict[str, np.ndarray]) -> str:
    """Returns the outcome without asking how many samples would settle it."""
    from sjdsl.experiments.verdict import outcome_of

    return outcome_of(estimate_contrasts(samples))
