"""The published figures, and the rule by which the paper chooses a ratio, against its own choices and closed forms."""

import math
from itertools import product

import pytest

from bench.paper import published
from bench.paper.ninety_five_percent_rule import choice_frequencies, chosen_ratio
from sjdsl.results.bundled import rules_now


@pytest.mark.parametrize("game", published.suite())
def test_the_rule_chooses_what_the_paper_has_in_bold(game: str) -> None:
    assert chosen_ratio(
        {ratio: printed.mean for ratio, printed in published.exchange(game).items()}
    ) == published.exchange_chosen(game)


def test_the_rule_at_its_limits() -> None:
    assert chosen_ratio({}) is None
    assert chosen_ratio({0.0: 0.0, 1.0: 0.0}) is None
    assert chosen_ratio({0.0: -5.0, 1.0: -1.0}) is None
    assert (
        chosen_ratio({0.0: -5.0, 0.5: 95.0, 1.0: 100.0}) == 0.5
    )  # exactly 0.95 of the best is enough
    assert chosen_ratio({0.0: 94.9, 1.0: 100.0}) == 1.0


def test_frequencies_of_two_seeds_in_closed_form() -> None:
    """Of two seeds a and b the mean is a, b or half of both, with 1/4, 1/4 and 1/2: all combinations can be counted."""
    samples = {0.0: (80.0, 100.0), 0.5: (94.0, 97.0), 1.0: (-10.0, 100.0)}
    exact = dict.fromkeys([*samples, None], 0.0)
    means = {ratio: ((a, 0.25), ((a + b) / 2, 0.5), (b, 0.25)) for ratio, (a, b) in samples.items()}
    for drawn in product(*means.values()):
        choice = chosen_ratio(dict(zip(means, (mean for mean, _ in drawn), strict=True)))
        exact[choice] += math.prod(share for _, share in drawn)
    found = choice_frequencies(samples)
    assert math.isclose(sum(found.values()), 1.0)
    for ratio, share in exact.items():
        assert (
            abs(found[ratio] - share) < 4 * math.sqrt(share * (1 - share) / 10_000) + 1e-9
        )  # four standard errors
    assert min(exact[0.0], exact[0.5]) > 0.1


def test_every_table_of_the_paper_is_whole() -> None:
    for game in published.suite():
        assert [*published.exchange(game)] == [0, 0.25, 0.5, 0.75, 1]
        assert [*published.svo(game)] == [0, 22.5, 45, 67.5, 90]
        metric = published.metric(game)
        assert metric is not None
        assert [*metric.printed] == list(published.metric_columns())
        assert [*published.speed(game, crowd=False)] == [1, 128, 1024, 4096]
    assert published.svo("pd_arena")[90].mean == 4 * 53.36
    assert published.best_return("pd_arena") == 260
    assert published.best_return("clean_up") == 1780
    assert published.best_return("orchard") is None
    assert published.hours("coins") == 3
    crowded = [game for game in published.suite() if published.speed(game, crowd=True)]
    assert set(published.suite()) - set(crowded) == {"coins", "pd_arena"}


def test_the_variants_that_the_paper_played_are_there() -> None:
    """In Gift Refinement, results have a name of former rules."""
    assert published.variant("coins") == "socialjax"
    assert published.variant("gift_refinement") == "socialjax+automatic"
    others = [game for game in published.suite() if game != "gift_refinement"]
    assert None not in [rules_now(game, published.variant(game)) for game in others]
