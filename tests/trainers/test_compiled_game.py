"""The trainer on a compiled game: the packaged preset, made small."""

import dataclasses
import json
from pathlib import Path

import jax
import numpy as np
import pytest

import sjdsl
from sjdsl.trainers import evaluate, load_policy, load_preset, train

SMALL = {"num_envs": 4, "num_steps": 10, "total_timesteps": 4 * 10 * 6, "num_minibatches": 2}


@pytest.mark.slow
def test_a_packaged_preset_runs(tmp_path: Path) -> None:
    """Episodes of 20 steps: three in each environment of the run."""
    preset = load_preset("two_cores", SMALL, "coins")
    env = sjdsl.make(preset.game, params={"length": 20}, **preset.environment)
    result = train(env, preset.config, tmp_path / "run", "none")
    assert [row["episodes"] for row in result.rows] == [0, 4, 0, 4, 0, 4]
    for row in result.rows:
        assert row["shaped_return"] == row["collective_return"] or np.isnan(
            row["collective_return"]
        )
        assert np.isfinite([row["loss"], row["entropy"], row["kl"], row["gradient_norm"]]).all()
    assert "event_own_coins_agent_1" in result.rows[0]
    manifest = json.loads((tmp_path / "run" / "manifest.json").read_text())
    assert manifest["game"]["hash"] == env.hash
    assert manifest["game"]["params"]["length"] == 20
    assert manifest["game"]["observation_shape"] == list(env.observation_shape)

    evaluation = evaluate(env, load_policy(tmp_path / "run", env), jax.random.key(0), 5)
    assert dataclasses.asdict(evaluation)["returns"].shape == (5, 2)
    np.testing.assert_array_equal(evaluation.lengths, 20)
    taken = sum(evaluation.events[name] for name in ("own_coins", "other_coins"))
    np.testing.assert_array_equal(
        evaluation.returns, taken - 2 * evaluation.events["other_coins"][:, ::-1]
    )
