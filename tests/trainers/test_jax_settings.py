"""Training under settings of JAX that users turn on: 64-bit numbers, and errors where a NaN comes up."""

from typing import Any

import jax
import pytest
from probes import quick, uneven

from sjdsl.trainers import make_train

KINDS: dict[str, dict[str, Any]] = {
    "ippo": {},
    "convolutions": {"network": "cnn", "reward": "svo"},
    "mappo": {"algorithm": "mappo", "critic": "state", "reward": "inequity"},
    "own networks with memory": {"sharing": "per_agent", "memory": "gru", "agent_id": True, "precision": "bfloat16"},
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
