"""How far a count may lie from what is expected before a test fails: bounds that hold exactly, for any numbers.

Each assertion fails by chance with a probability below `FALSE_ALARM`; seeds are fixed, so a test that passes passes always.
"""

import math
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from sjdsl.runtime.env import Environment

FALSE_ALARM = 1e-6
BATCH = 4096


def distance(trials: float, probability: float, false_alarm: float = FALSE_ALARM) -> float:
    """Returns how far the hits of independent trials lie from their mean at most, but for the false alarm.

    Source: Bernstein's inequality: P(|X - np| >= t) <= 2 exp(-t^2 / 2 (np(1 - p) + t / 3)).
    """
    logarithm = math.log(2 / false_alarm)
    variance = trials * probability * (1 - probability)
    return logarithm / 3 + math.sqrt(logarithm**2 / 9 + 2 * logarithm * variance)


def assert_share(hits: float, trials: float, probability: float, within: float) -> None:
    """Asserts a share of hits. `within`: how tight the test must be at least, as a part of the probability."""
    allowed = distance(trials, probability)
    assert allowed <= within * trials * probability, (
        f"{trials} trials tell {probability} to {allowed / trials / probability:.3f} only"
    )
    assert abs(hits - trials * probability) <= allowed, (
        f"{hits / trials:.6g}, not {probability:.6g} +- {allowed / trials:.2g}"
    )


def assert_uniform(counts: Any, within: float) -> None:
    """Asserts that all outcomes of independent trials came equally often, each to within that part."""
    counts = np.asarray(counts)
    probability = 1 / counts.size
    allowed = distance(counts.sum(), probability, FALSE_ALARM / counts.size)
    assert allowed <= within * counts.sum() * probability, (
        f"the test is tight to {allowed / counts.sum() / probability:.3f} only"
    )
    assert np.abs(counts - counts.sum() * probability).max() <= allowed, counts.tolist()


def assert_shares(counts: Any, probabilities: Any, within: float) -> None:
    """Asserts how often each outcome of independent trials came. `within`: how tight the test must be, as a share of the trials."""
    counts, probabilities = np.asarray(counts), np.asarray(probabilities)
    assert counts.shape == probabilities.shape
    assert abs(probabilities.sum() - 1) < 1e-9
    trials = counts.sum()
    for outcome in np.ndindex(counts.shape):
        allowed = distance(trials, probabilities[outcome], FALSE_ALARM / counts.size)
        assert allowed <= within * trials, (
            f"{trials} trials tell the share of {outcome} to {allowed / trials:.3f} only"
        )
        found = counts[outcome] / trials
        assert abs(found - probabilities[outcome]) <= allowed / trials, (
            f"{outcome}: {found:.6g}, not {probabilities[outcome]:.6g}"
        )
        assert probabilities[outcome] > 0 or found == 0, f"{outcome} is impossible"


def many(
    env: Environment, look: Callable[[Any, Any, Any], Any], batch: int = BATCH
) -> Callable[..., Any]:
    """Returns a function that takes the same step many times, each time with another key, and sums what `look` sees.

    `look`: (state before, state after, rewards) -> numbers. The function: (seed, state, actions, params, rounds of `batch` steps).
    """

    def one(key: jax.Array, state: Any, actions: jax.Array, params: Any) -> Any:
        _, after, reward, *_ = env.step_env(key, state, actions, params)
        return jax.tree.map(lambda x: jnp.asarray(x).astype(jnp.int32), look(state, after, reward))

    def rounds(
        key: jax.Array, number: jax.Array, state: Any, actions: jax.Array, params: Any
    ) -> Any:
        def add(i: jax.Array, sums: Any) -> Any:
            keys = jax.random.split(jax.random.fold_in(key, i), batch)
            seen = jax.vmap(one, in_axes=(0, None, None, None))(keys, state, actions, params)
            return jax.tree.map(lambda a, b: a + jnp.sum(b, axis=0, dtype=jnp.int32), sums, seen)

        shapes = jax.eval_shape(one, jax.random.key(0), state, actions, params)
        return jax.lax.fori_loop(
            0, number, add, jax.tree.map(lambda x: jnp.zeros(x.shape, jnp.int32), shapes)
        )

    run = jax.jit(rounds)

    def repeat(seed: int, state: Any, actions: Any, params: Any, number: int) -> Any:
        sums = run(
            jax.random.key(seed), jnp.int32(number), state, jnp.asarray(actions, jnp.int32), params
        )
        return jax.tree.map(np.asarray, sums)

    return repeat
