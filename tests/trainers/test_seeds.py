"""Runs of several seeds side by side."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax import Array
from probes import FAST_TO_COMPILE, learn, matching, quick

from sjdsl.trainers import Config, make_train
from sjdsl.trainers.runs.compiled import compile_train


@pytest.mark.thorough
@pytest.mark.parametrize("algorithm", ["ippo", pytest.param("vdn", marks=pytest.mark.thorough)])
def test_compiled_seeds_are_the_runs_they_would_have_been_alone(algorithm: str) -> None:
    """One after the other or as a batch, as it is for this device: two updates, to rounding."""

    def played(config: Config) -> tuple[Any, Any]:
        run = compile_train(make_train(matching(), config), config)
        state = run.start()
        for _ in range(2):
            state, metrics = run.learn(*run.collect(state))
        return run.parameters(state), metrics

    config = quick(algorithm=algorithm)
    with jax.debug_key_reuse(False):  # JAX takes the keys of any vmapped scan for used
        together = played(config.model_copy(update={"seeds": 3, "seed": 1}))
        alone = [played(config.model_copy(update={"seed": seed})) for seed in (1, 2, 3)]
    jax.tree.map(
        lambda all_of, *own: np.testing.assert_allclose(
            all_of, np.stack(own), rtol=1e-4, atol=1e-5
        ),
        together,
        *alone,
    )


@pytest.mark.thorough
def test_other_seeds_are_other_runs() -> None:
    """Other parameters, other worlds and other actions, from the first update on."""
    runs = [learn(matching(), seed) for seed in range(2)]
    assert len({float(metrics["agent_return"][0, 0]) for _, metrics in runs}) == 2
    assert len({float(metrics["loss"][0]) for _, metrics in runs}) == 2
    kernels = [
        np.asarray(state.learner.params["params"]["actor"]["out"]["kernel"]) for state, _ in runs
    ]
    assert not np.allclose(kernels[0], kernels[1])


@pytest.mark.thorough
@pytest.mark.parametrize(
    "changes", [{}, pytest.param({"algorithm": "vdn"}, marks=pytest.mark.slow)], ids=["ippo", "vdn"]
)
def test_a_seed_that_diverges_stands_still_and_the_others_learn_on(changes: dict[str, Any]) -> None:
    """One of three is given a parameter that is not finite: from then on its parameters stay, and its loss is not a number."""
    program = make_train(matching(), quick(**changes))

    def poison(seeds: Array, updates: int) -> tuple[Any, Any, Any]:
        states = jax.vmap(lambda seed: program.init(jax.random.key(seed)))(seeds)
        kernel = jax.tree.map(lambda leaf: leaf.at[1].set(jnp.inf), program.parameters(states))
        states = jax.vmap(program.adopt)(states, kernel)
        after, metrics = jax.lax.scan(
            lambda state, _: jax.vmap(program.update)(state), states, length=updates
        )
        return kernel, after, metrics

    with jax.debug_key_reuse(False):
        before, after, metrics = jax.jit(
            poison, static_argnums=1, compiler_options=FAST_TO_COMPILE
        )(jnp.arange(3), 3)
    assert after.diverged.tolist() == [False, True, False]
    assert np.isfinite(metrics["loss"]).all(axis=0).tolist() == [True, False, True]
    assert np.isnan(metrics["loss"][:, 1]).all()
    for old, new in zip(
        jax.tree.leaves(before), jax.tree.leaves(program.parameters(after)), strict=True
    ):
        np.testing.assert_array_equal(new[1], old[1])
    moved = [
        np.any(new != old, axis=tuple(range(1, new.ndim)))
        for old, new in zip(*map(jax.tree.leaves, (before, program.parameters(after))))
    ]
    assert np.any(moved, axis=0).tolist() == [True, False, True]
