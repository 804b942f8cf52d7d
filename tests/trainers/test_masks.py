"""Actions that the game forbids: never drawn, valued or learnt from, by any algorithm.

The game: each agent has two actions at a time, `stay` and the one door that is open, which it cannot see. Who chooses a closed door stays.
"""

from functools import cache, partial
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from probes import FAST_TO_COMPILE, matching, quick

import sjdsl
from sjdsl.trainers import PPOConfig, TrainState, VDNConfig, make_train
from sjdsl.trainers.algorithms.losses import Batch
from sjdsl.trainers.algorithms.ppo import ppo_loss
from sjdsl.trainers.algorithms.vdn_targets import Team, Transition, bootstrapped, team_loss
from sjdsl.trainers.networks.masks import draw_any, masked, wants_masks

VDN = {"algorithm": "vdn"}
ALLOWED = jnp.array([[True, False, True], [False, False, True]])


@cache
def one_door() -> Any:
    return sjdsl.make(Path(__file__).parent / "games" / "one_door.sj")


# parts


def test_what_is_forbidden_has_no_probability_and_finite_gradients() -> None:
    logits = jnp.array([[0.3, 5.0, -0.2], [9.0, 0.0, -9.0]])
    probabilities = jax.nn.softmax(masked(logits, ALLOWED))
    assert (probabilities[~ALLOWED] == 0.0).all()
    np.testing.assert_allclose(
        probabilities[0, [0, 2]], jax.nn.softmax(jnp.array([0.3, -0.2])), rtol=1e-6
    )
    assert float(probabilities[1, 2]) == 1.0
    assert masked(logits, None) is logits


def test_the_loss_knows_only_what_is_allowed() -> None:
    """Its entropy is that of the actions left; the gradients of all other logits are exactly zero."""
    batch = Batch(
        observation=None,
        joint=None,
        fresh=None,
        memory=(),
        action=jnp.array([0, 2]),
        log_probability=jnp.array([-0.5, 0.0]),
        value=jnp.zeros(2),
        advantage=jnp.array([1.0, -1.0]),
        target=jnp.zeros(2),
        allowed=ALLOWED,
    )

    def loss(logits: jax.Array) -> tuple[jax.Array, Any]:
        return ppo_loss(None, lambda *_: ((), logits, jnp.zeros(2)), batch, PPOConfig())

    logits = jnp.array([[0.3, 5.0, -0.2], [9.0, 0.0, -9.0]])
    gradient, parts = jax.grad(loss, has_aux=True)(logits)
    left = 1 / (1 + np.exp(-0.5))  # of two logits that differ by 0.5
    assert float(parts["entropy"]) == pytest.approx(
        -(left * np.log(left) + (1 - left) * np.log(1 - left)) / 2, rel=1e-5
    )
    assert np.isfinite(gradient).all()
    assert (gradient[~ALLOWED] == 0.0).all()
    assert (gradient[0, [0, 2]] != 0.0).all()


@pytest.mark.parametrize(("double_q", "best"), [(False, 2.0 + 7.0), (True, 1.0 + 7.0)])
def test_the_best_that_follows_is_one_of_those_allowed(double_q: bool, best: float) -> None:
    """Two agents; the target's values are best in actions that are forbidden where the step led. A network is its table."""
    network = type("Network", (), {"apply": staticmethod(lambda table, _: table)})
    target, online = (
        jnp.array([[[1.0, 50.0, 2.0], [50.0, 60.0, 7.0]]]),
        jnp.array([[[4.0, 9.0, 3.0], [9.0, 9.0, 3.0]]]),
    )
    taken = jnp.zeros((1, 2), jnp.int32)
    batch = Transition(
        None, taken, jnp.array([1.0]), None, jnp.array([False]), allowed=ALLOWED[None]
    )
    team = Team(network, jnp.arange(2))  # type: ignore[arg-type]
    steps = bootstrapped(online, target, batch, team, VDNConfig(gamma=0.5, double_q=double_q))
    loss, _ = team_loss(online, team, steps, weight=1.0)
    assert float(loss) == pytest.approx((13.0 - (1.0 + 0.5 * best)) ** 2)


def test_exploring_draws_evenly_from_what_is_allowed() -> None:
    """Of 4000 draws from two actions a half, with a standard error of 0.008."""
    allowed = jnp.broadcast_to(ALLOWED, (4000, 2, 3))
    drawn = np.asarray(draw_any(jax.random.key(0), (4000, 2), 3, allowed))
    assert set(drawn[:, 0]) == {0, 2}
    assert set(drawn[:, 1]) == {2}
    assert (drawn[:, 0] == 2).mean() == pytest.approx(0.5, abs=0.035)


def test_masks_are_for_games_that_forbid() -> None:
    config = quick()
    assert wants_masks(one_door(), config)
    assert not wants_masks(one_door(), quick(mask_actions=False))
    assert not wants_masks(sjdsl.make("coins"), config)
    assert not wants_masks(matching(), config)


# playing and learning

SMALL = {"num_envs": 4, "num_steps": 8, "num_epochs": 1, "num_minibatches": 1}
SMALL_VALUES = {**VDN, "num_envs": 4, "num_steps": 8, "buffer_size": 64}


@cache
def first_update(**changes: Any) -> tuple[TrainState, Any, dict[str, Any]]:
    """Returns a state before the first update, what was played in it, and its losses."""
    program = make_train(
        one_door(), quick(**{**(SMALL_VALUES if "vdn" in changes.values() else SMALL), **changes})
    )

    @partial(jax.jit, compiler_options=FAST_TO_COMPILE)
    def run(key: jax.Array) -> tuple[TrainState, Any, dict[str, Any]]:
        state = program.init(key)
        after, played = program.collect(state)
        learnt, metrics = program.learn(after, played)
        return state, (getattr(played, "rollout", None), learnt), metrics

    return run(jax.random.key(0))


@pytest.mark.thorough
@pytest.mark.parametrize(
    "changes",
    [
        pytest.param({}, marks=pytest.mark.slow),
        {"algorithm": "mappo", "sharing": "per_agent"},
        pytest.param(
            {"algorithm": "mappo", "sharing": "per_agent", "memory": "gru"}, marks=pytest.mark.slow
        ),
    ],
    ids=["ippo", "mappo per agent", "mappo per agent with memory"],
)
def test_closed_doors_are_never_chosen_and_learning_knows_it(changes: dict[str, Any]) -> None:
    """Who chooses anything but `stay` is paid. Networks that have learnt nothing take either of two actions with one half."""
    _, (rollout, _), metrics = first_update(**changes)
    np.testing.assert_array_equal(rollout.reward == 1.0, rollout.action != 0)
    assert set(np.unique(rollout.action)) == {0, 1, 2, 3, 4}
    np.testing.assert_allclose(rollout.acting.log_probability, np.log(0.5), atol=0.05)
    assert float(metrics["entropy"]) == pytest.approx(np.log(2), abs=0.01)
    assert abs(float(metrics["kl"])) < 1e-6
    assert np.isfinite(metrics["gradient_norm"])
    assert rollout.acting.allowed.dtype == jnp.uint8
