"""The 95 % rule: the smallest exchange ratio that is nearly as good as the best, and how sure the
choice is.

Source: SocialJax, ICLR 2026: the smallest ratio whose mean return is at least 0.95 of the best. The
resampling of seeds is ours.
"""

from collections.abc import Mapping, Sequence

import numpy as np

SHARE = 0.95  # of the best mean
RESAMPLES = 10_000
SEED = 0  # of the resamples: the same seeds have the same frequencies


def chosen_ratio(means: Mapping[float, float]) -> float | None:
    """Returns the smallest ratio whose mean is at least 0.95 of the best; None if the best is not
    above 0, or nothing is given.
    """
    best = max(means.values(), default=0.0)
    if best <= 0:
        return None
    return min(ratio for ratio, mean in means.items() if mean >= SHARE * best)


def choice_frequencies(
    samples: Mapping[float, Sequence[float]],
) -> dict[float | None, float]:
    """Returns how often each ratio is chosen where the seeds of each ratio are drawn again, with
    replacement.

    Args:
      samples: the returns of the seeds of each ratio, one at least each.
    Returns:
      a frequency for each ratio, and for None: no ratio. They add up to 1.
    """
    ratios = sorted(samples)
    draw = np.random.default_rng(SEED)
    means = []
    for ratio in ratios:
        values = np.asarray(samples[ratio], np.float64)
        drawn = draw.integers(len(values), size=(RESAMPLES, len(values)))
        means.append(values[drawn].mean(axis=1))
    table = np.stack(means)  # [ratios, resamples]
    best = table.max(axis=0)
    first = (table >= SHARE * best).argmax(axis=0)
    chosen = np.where(best > 0, first, len(ratios))  # one past the last ratio: none
    counts = np.bincount(chosen, minlength=len(ratios) + 1)
    return {
        ratio: float(count / RESAMPLES)
        for ratio, count in zip([*ratios, None], counts, strict=True)
    }
