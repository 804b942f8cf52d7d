"""IPPO compiles and learns in every substrate: two tiny updates each, of which losses are finite and parameters move. `--thorough`."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from probes import FAST_TO_COMPILE

import sjdsl
from sjdsl.library.substrates import Substrate, written_substrates
from sjdsl.trainers import PPOConfig, make_train

NUM_ENVS, NUM_STEPS, UPDATES = 4, 4, 2


@pytest.mark.thorough
@pytest.mark.parametrize("entry", written_substrates(), ids=lambda entry: entry.name)
def test_two_updates_of_ippo(entry: Substrate) -> None:
    env = sjdsl.make(entry.game, variant=entry.variant or None)
    config = PPOConfig(
        num_envs=NUM_ENVS,
        num_steps=NUM_STEPS,
        total_timesteps=UPDATES * NUM_ENVS * NUM_STEPS,
        network="mlp",
        network_width=8,
        num_minibatches=1,
        num_epochs=1,
    )
    program = make_train(env, config)
    key = jax.random.key(0)
    state = jax.jit(program.init).lower(key).compile(compiler_options=FAST_TO_COMPILE)(key)
    before = jax.device_get(program.parameters(state))
    update = jax.jit(program.update).lower(state).compile(compiler_options=FAST_TO_COMPILE)
    for _ in range(UPDATES):
        state, metrics = update(state)
        assert not [
            name
            for name, value in metrics.items()
            if "loss" in name and not np.isfinite(value).all()
        ]
    after = jax.device_get(program.parameters(state))
    moved = [
        not np.array_equal(a, b)
        for a, b in zip(jax.tree.leaves(before), jax.tree.leaves(after), strict=True)
    ]
    assert any(moved)
    assert all(jnp.isfinite(leaf).all() for leaf in jax.tree.leaves(after))
