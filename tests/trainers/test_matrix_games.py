"""A prisoner's dilemma written in the language: what each algorithm and reward makes of it.

Defecting pays 1 more whatever the other does; two cooperators have 3 each, two defectors 1.
"""

from functools import cache
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest
from probes import FAST_TO_COMPILE, quick

import sjdsl
from sjdsl.trainers import make_train

GAME = Path(__file__).parent / "games" / "prisoners_dilemma.sj"
STEPS = 4
DEFECT, COOPERATE = 1.0, 3.0


@cache
def dilemma() -> Any:
    return sjdsl.make(GAME)


def payoff_learnt(**changes: Any) -> np.ndarray:
    """Returns what each agent has a step at the end of a run, in its last ten updates."""
    config = quick(**changes)
    program = make_train(dilemma(), config)

    def run(key: jax.Array) -> dict[str, Any]:
        return jax.lax.scan(lambda state, _: program.update(state), program.init(key), length=config.num_updates)[1]

    metrics = jax.jit(run, compiler_options=FAST_TO_COMPILE)(jax.random.key(0))
    return np.asarray(metrics["agent_return"][-10:]).mean(axis=0) / STEPS


def test_the_game_is_the_dilemma() -> None:
    env = dilemma()
    _, state = env.reset(jax.random.key(0))
    found = [[env.step(jax.random.key(1), state, jax.numpy.array([one, other]))[2].tolist() for other in (0, 1)] for one in (0, 1)]
    assert found == [[[3, 3], [0, 4]], [[4, 0], [1, 1]]]
    assert env.action_names == ("stay", "betray")


@pytest.mark.thorough
def test_each_for_itself_defects() -> None:
    np.testing.assert_allclose(payoff_learnt(), DEFECT, atol=0.2)


@pytest.mark.thorough
@pytest.mark.parametrize(
    "changes",
    [
        {"reward": "common"},
        {"algorithm": "vdn"},
        pytest.param({"reward": "exchange", "exchange_ratio": 1.0}, marks=pytest.mark.slow),
        pytest.param({"reward": "svo", "svo_angle": 90, "svo_weight": 3.0}, marks=pytest.mark.slow),
        pytest.param({"reward": "svo", "svo_angle": 67.5, "svo_weight": 4.0}, marks=pytest.mark.slow),
        pytest.param({"reward": "inequity", "inequity_envy": 0.0, "inequity_guilt": 2.0}, marks=pytest.mark.slow),
        pytest.param({"reward": "common", "algorithm": "mappo", "critic": "state"}, marks=pytest.mark.slow),
    ],
    ids=["common", "vdn", "exchange", "svo 90", "svo 67.5", "inequity", "mappo of the state"],
)
def test_who_minds_the_other_cooperates(changes: dict[str, Any]) -> None:
    """To VDN a step is explored with a probability of 0.05 at the end: 3 less at most 0.05."""
    np.testing.assert_allclose(payoff_learnt(**changes), COOPERATE, atol=0.2)


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [
        {"reward": "exchange", "exchange_ratio": 0.0},
        {"reward": "svo", "svo_weight": 0.0},
        {"reward": "svo", "svo_angle": 45, "svo_weight": 3.0},
        {"reward": "inequity", "inequity_envy": 5.0, "inequity_guilt": 2.0},
    ],
    ids=["exchange of nothing", "svo of no weight", "svo 45", "envy"],
)
def test_who_minds_the_other_too_little_or_fears_it_defects(changes: dict[str, Any]) -> None:
    """At 45 degrees, and with envy, it is a stag hunt: cooperating is best with a cooperator, and worse with who does either by chance."""
    np.testing.assert_allclose(payoff_learnt(**changes), DEFECT, atol=0.2)
