"""Collective return and equality (1 - Gini) of an episode's returns, for NumPy and JAX arrays."""

from typing import Any


def collective_return(returns: Any) -> Any:
    """Returns the sum over agents of returns `[..., N]`: `[...]`."""
    return returns.sum(axis=-1)


def equality(returns: Any) -> Any:
    """Returns one minus the Gini coefficient of returns: `[..., N]` -> `[...]` floating.

    It is 1 if all are equal, 1 / N if one agent has everything, and NaN if a return is negative or
    all are 0, for which the coefficient isn't defined.
    Source: Perolat et al. 2017, their equality; the Gini coefficient is the mean difference of two
    agents over twice the mean.
    """
    arrays = returns.__array_namespace__()
    total = collective_return(returns)
    is_defined = (returns >= 0).all(axis=-1) & (total > 0)
    divisor = arrays.where(is_defined, total, 1)
    differences = arrays.abs(returns[..., :, None] - returns[..., None, :])
    num_agents = returns.shape[-1]
    gini = differences.sum(axis=(-2, -1)) / (2 * num_agents * divisor)
    return arrays.where(is_defined, 1 - gini, arrays.nan)
