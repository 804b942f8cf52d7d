"""Training under settings of JAX that users turn on: 64-bit numbers, and errors where a NaN comes up."""

from typing import Any

import jax
import numpy as np
import pytest
from probes import matching, quick, stream, uneven

from sjdsl.trainers import make_train
from sjdsl.trainers.runs.metric_rows import flatten_metrics

KINDS: dict[str, dict[str, Any]] = {
    "ippo": {},
    "convolutions": {"network": "cnn", "reward": "svo"},
    "mappo": {"algorithm": "mappo", "critic": "state", "reward": "inequity"},
    "own networks with memory": {
        "sharing": "per_agent",
        "memory": "gru",
        "agent_id": True,
        "precision": "bfloat16",
    },
    "vdn": {"algorithm": "vdn", "double_q": True},
    "a partner": {"partners": {1: "random"}},
}


@pytest.mark.thorough
@pytest.mark.parametrize("kind", KINDS)
def test_64_bits_do_not_change_what_is_learnt_from(kind: str) -> None:
    """States, parameters and metrics have the dtypes that they have without."""

    def types() -> dict[str, str]:
        run = make_train(uneven(), quick(**KINDS[kind]))
        state = jax.eval_shape(run.init, jax.eval_shape(lambda: jax.random.key(0)))
        leaves = jax.tree_util.tree_leaves_with_path((state, jax.eval_shape(run.update, state)))
        return {jax.tree_util.keystr(path): str(leaf.dtype) for path, leaf in leaves}

    without = types()
    with jax.enable_x64(True):
        assert types() == without


@pytest.mark.thorough
def test_64_bits_do_not_change_what_is_drawn() -> None:
    def learnt() -> Any:
        run = make_train(matching(), quick(total_timesteps=256))
        return jax.jit(run.update)(run.init(jax.random.key(3)))[1]

    without = learnt()
    with jax.enable_x64(True):
        jax.tree.map(
            lambda here, there: np.testing.assert_allclose(here, there, rtol=1e-4, atol=1e-6),
            learnt(),
            without,
        )


@pytest.mark.thorough
def test_no_nan_comes_up_in_healthy_training() -> None:
    """Neither where no episode has finished in an update, nor where equality means nothing; rows have NaN for both all the same."""
    run = make_train(
        stream("truncated"), quick(num_envs=4, num_steps=2, num_minibatches=1, total_timesteps=64)
    )
    with jax.debug_nans(True):
        _, metrics = jax.jit(run.update)(run.init(jax.random.key(0)))
    assert metrics["episodes"] == 0
    row = flatten_metrics(jax.device_get(metrics))
    assert np.isnan([row["collective_return"], row["equality"], row["episode_length"]]).all()
    assert np.isfinite(row["loss"])
